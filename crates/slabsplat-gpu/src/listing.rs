//! Who lists the relevant voxels of a layer, `L_r` of the paper's §4, with their normals and colours.
//!
//! Where a voxel's look follows from its value, the device does: it holds the samples, and a new transfer
//! function sends its points, nothing else. Where more decides, as labels, gradients and voxels' own colours
//! do, the host does, by the rules that the CPU backend lists by, and sends the device a record for each. So
//! such rules are defined once, and no sample of the layer need be on the device; the price is that every
//! change of them sends all records again.

use crate::classification::Classification;
use crate::host_list::HostList;
use crate::known_volume::KnownVolume;
use slabsplat_backend::ByIdentity;
use std::sync::Arc;

/// How the relevant voxels of a layer are found.
#[derive(Clone, Debug)]
pub(crate) enum Listing {
    /// By the device, among the samples of that volume.
    ByDevice(Arc<KnownVolume>, Classification),
    /// By the host.
    ByHost(Arc<HostList>),
}

/// What identifies a listing. It does not keep the host's list alive, as the next one may need the room.
#[derive(Debug)]
pub(crate) enum ListingName {
    ByDevice(Arc<KnownVolume>, Classification),
    ByHost(ByIdentity<HostList>),
}

impl Listing {
    /// At least as many voxels as are relevant.
    pub(crate) fn max_voxels(&self) -> u64 {
        match self {
            Self::ByDevice(known, Classification { key_ranges, .. }) => {
                known.key_counts().at_most(key_ranges)
            }
            Self::ByHost(list) => list.n_voxels(),
        }
    }

    /// The volume whose samples the device needs, if it does.
    pub(crate) fn samples(&self) -> Option<&Arc<KnownVolume>> {
        match self {
            Self::ByDevice(known, _) => Some(known),
            Self::ByHost(_) => None,
        }
    }

    pub(crate) fn name(&self) -> ListingName {
        match self {
            Self::ByDevice(known, classification) => {
                ListingName::ByDevice(known.clone(), classification.clone())
            }
            Self::ByHost(list) => ListingName::ByHost(ByIdentity::of(list)),
        }
    }
}

impl ListingName {
    /// Whether it is that of a listing.
    pub(crate) fn is_of(&self, listing: &Listing) -> bool {
        match (self, listing) {
            (Self::ByDevice(known, own), Listing::ByDevice(of_known, other)) => {
                Arc::ptr_eq(known, of_known) && own == other
            }
            (Self::ByHost(own), Listing::ByHost(list)) => *own == ByIdentity::of(list),
            (Self::ByDevice(..), Listing::ByHost(_)) | (Self::ByHost(_), Listing::ByDevice(..)) => {
                false
            }
        }
    }
}
