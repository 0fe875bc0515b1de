//! What the last plan's voxels were listed by, cached for the next one.

use crate::classification::Classification;
use crate::detail_lists::DetailLists;
use crate::host_list::{HostList, rules_of};
use crate::known_volume::KnownVolume;
use crate::listing::{HostRecords, Listing};
use crate::params::MAX_LAYERS;
use slabsplat_backend::{FramePlan, LayerPlan};
use slabsplat_core::{FrameHandle, StageError, Volume};
use std::convert::Infallible;
use std::sync::Arc;

/// The volumes of the last plan, and what the host listed of them.
#[derive(Debug, Default)]
pub(crate) struct Listings {
    volumes: Vec<Arc<KnownVolume>>,
    host_lists: Vec<Arc<HostList>>,
    detail_lists: Vec<Arc<DetailLists>>,
}

impl Listings {
    /// How the voxels of each layer of a plan are listed, and cells of them, if any may be drawn: the
    /// listings of each layer's levels. What no layer needs is dropped before anything is made, as two lists
    /// need not fit at a time.
    pub(crate) fn of(
        &mut self,
        plan: &FramePlan<'_>,
        frame: &FrameHandle,
    ) -> Result<Vec<Vec<Listing>>, StageError> {
        let is_shown = |known: &Arc<KnownVolume>| {
            plan.layers.iter().any(|layer| Arc::ptr_eq(&known.volume, layer.volume))
        };
        self.volumes.retain(is_shown);
        self.host_lists.retain(|list| plan.layers.iter().any(|layer| list.is_of(plan, layer)));
        self.detail_lists.retain(|lists| plan.layers.iter().any(|layer| lists.are_of(plan, layer)));
        let n_levels: usize = plan.layers.iter().map(|layer| layer.levels().count()).sum();
        let has_room = n_levels <= MAX_LAYERS as usize;
        let listings = |layer: &LayerPlan<'_>| match &layer.coarser {
            Some(_) if has_room => self.levels(plan, layer, frame),
            _ => Ok(vec![self.listing(plan, layer, frame)?]),
        };
        plan.layers.iter().map(listings).collect()
    }

    fn levels(
        &mut self,
        plan: &FramePlan<'_>,
        layer: &LayerPlan<'_>,
        frame: &FrameHandle,
    ) -> Result<Vec<Listing>, StageError> {
        frame.check()?;
        let known = self.known(layer.volume);
        let is_it = |lists: &DetailLists| lists.are_of(plan, layer);
        let make = || DetailLists::new(plan, layer, &known, frame);
        let lists = found_or_added(&mut self.detail_lists, is_it, make)?;
        let listing = |level| Listing::ByHost(HostRecords::Level(lists.clone(), level));
        Ok(lists.filled_levels().map(listing).collect())
    }

    fn listing(
        &mut self,
        plan: &FramePlan<'_>,
        layer: &LayerPlan<'_>,
        frame: &FrameHandle,
    ) -> Result<Listing, StageError> {
        frame.check()?;
        let known = self.known(layer.volume);
        if rules_of(layer).are_all_by_value() {
            let classification = Classification::new(plan, layer, &known);
            Ok(Listing::ByDevice(known, classification))
        } else {
            let is_it = |list: &HostList| list.is_of(plan, layer);
            let make = || HostList::new(plan, layer, &known, frame);
            let list = found_or_added(&mut self.host_lists, is_it, make)?;
            Ok(Listing::ByHost(HostRecords::Voxels(list)))
        }
    }

    fn known(&mut self, volume: &Arc<Volume>) -> Arc<KnownVolume> {
        let is_it = |known: &KnownVolume| Arc::ptr_eq(&known.volume, volume);
        let make = || Ok::<_, Infallible>(KnownVolume::new(volume.clone()));
        found_or_added(&mut self.volumes, is_it, make).unwrap_or_else(|never| match never {})
    }
}

fn found_or_added<T, E>(
    all: &mut Vec<Arc<T>>,
    is_it: impl Fn(&T) -> bool,
    make: impl FnOnce() -> Result<T, E>,
) -> Result<Arc<T>, E> {
    if let Some(found) = all.iter().find(|one| is_it(one)) {
        return Ok(found.clone());
    }
    let made = Arc::new(make()?);
    all.push(made.clone());
    Ok(made)
}
