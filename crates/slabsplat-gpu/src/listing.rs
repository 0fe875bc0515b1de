//! Who lists the relevant voxels of a layer, `L_r` of the paper's §4, with their normals and colours.
//!
//! Where a voxel's look follows from its value, the device does: it holds the samples, and a new transfer
//! function sends its points, nothing else. Where more decides, as labels, gradients and voxels' own colours
//! do, the host does, by the rules that the CPU backend lists by, and sends the device a record for each. So
//! such rules are defined once, and no sample of the layer need be on the device; the price is that every
//! change of them sends all records again. So it is where cells of voxels may be drawn.

use crate::classification::Classification;
use crate::detail_lists::DetailLists;
use crate::host_list::{HostList, RecordPiece};
use crate::known_volume::KnownVolume;
use slabsplat_backend::ByIdentity;
use slabsplat_core::{Cancelled, FrameHandle};
use std::sync::Arc;

/// How the relevant voxels of a layer are found, or the cells that stand for them.
#[derive(Clone, Debug)]
pub(crate) enum Listing {
    /// By the device, among the samples of that volume.
    ByDevice(Arc<KnownVolume>, Classification),
    /// By the host.
    ByHost(HostRecords),
}

/// What the host lists.
#[derive(Clone, Debug)]
pub(crate) enum HostRecords {
    /// All relevant voxels.
    Voxels(Arc<HostList>),
    /// Those that are drawn as such, at level 0, or cells of a level.
    Level(Arc<DetailLists>, usize),
}

/// What identifies a listing. It does not keep the host's list alive, as the next one may need the room.
#[derive(Debug)]
pub(crate) enum ListingName {
    ByDevice(Arc<KnownVolume>, Classification),
    ByHost(ByIdentity<HostList>),
    Level(ByIdentity<DetailLists>, usize),
}

impl Listing {
    /// At least as many voxels as are relevant.
    pub(crate) fn max_voxels(&self) -> u64 {
        match self {
            Self::ByDevice(known, Classification { key_ranges, .. }) => {
                known.key_counts().at_most(key_ranges)
            }
            Self::ByHost(records) => records.n_records(),
        }
    }

    /// The level of what is listed: 0 of voxels.
    pub(crate) fn level(&self) -> usize {
        match self {
            Self::ByHost(HostRecords::Level(_, level)) => *level,
            Self::ByHost(HostRecords::Voxels(_)) | Self::ByDevice(..) => 0,
        }
    }

    /// How many more voxels cells stand for than they are.
    pub(crate) fn n_more_voxels(&self) -> i64 {
        match self {
            Self::ByHost(HostRecords::Level(lists, level)) => {
                lists.n_voxels(*level) as i64 - lists.n_records(*level) as i64
            }
            Self::ByHost(HostRecords::Voxels(_)) | Self::ByDevice(..) => 0,
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
            Self::ByHost(HostRecords::Voxels(list)) => ListingName::ByHost(ByIdentity::of(list)),
            Self::ByHost(HostRecords::Level(lists, level)) => {
                ListingName::Level(ByIdentity::of(lists), *level)
            }
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
            (Self::ByHost(own), Listing::ByHost(HostRecords::Voxels(list))) => {
                *own == ByIdentity::of(list)
            }
            (Self::Level(own, level), Listing::ByHost(HostRecords::Level(lists, other))) => {
                *own == ByIdentity::of(lists) && level == other
            }
            (Self::ByDevice(..) | Self::ByHost(_) | Self::Level(..), _) => false,
        }
    }
}

impl HostRecords {
    /// Voxels, or cells of them.
    pub(crate) fn n_records(&self) -> u64 {
        match self {
            Self::Voxels(list) => list.n_voxels(),
            Self::Level(lists, level) => lists.n_records(*level),
        }
    }

    /// Calls `send` with the records of all of them, made piece by piece for a frame.
    pub(crate) fn for_each_piece<E: From<Cancelled>>(
        &self,
        frame: &FrameHandle,
        send: impl FnMut(RecordPiece) -> Result<(), E>,
    ) -> Result<(), E> {
        match self {
            Self::Voxels(list) => list.pieces().try_for_each(send),
            Self::Level(lists, level) => lists.for_each_piece(*level, frame, send),
        }
    }
}
