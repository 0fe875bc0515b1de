//! Which values of a layer a frame shows: those of the voxels to be listed, or of the densities.

use crate::ShownDensities;
use slabsplat_core::{IsoRange, Isosurface, LabelStyle, Layer, Statistic, TransferFunction};

/// The values that are visible of any voxel.
fn visible_ranges(layer: &Layer) -> Vec<IsoRange> {
    let ranges_of_layer = || match &layer.transfer_2d {
        Some(transfer_2d) => transfer_2d.iso_ranges(),
        None => layer.transfer.iso_ranges(),
    };
    let Some(labels) = &layer.labels else { return ranges_of_layer() };
    let styles = labels.map().labels().iter().map(|&label| labels.style(label));
    let shown: Vec<&LabelStyle> =
        styles.filter(|style| style.transfer_in(&layer.transfer).is_some()).collect();
    let own = shown.iter().filter_map(|style| style.transfer.as_ref());
    let shows_layer = shown.iter().any(|style| style.transfer.is_none());
    let of_layer = shows_layer.then(ranges_of_layer);
    IsoRange::union(
        own.flat_map(TransferFunction::iso_ranges).chain(of_layer.into_iter().flatten()),
    )
}

/// The values that decide what is shown of a layer.
pub(crate) fn shown_ranges(layer: &Layer, shown: ShownDensities) -> Vec<IsoRange> {
    match shown {
        ShownDensities::Composited => visible_ranges(layer),
        ShownDensities::Statistic(statistic) => deciding_ranges(visible_ranges(layer), statistic),
        ShownDensities::Isosurfaces => {
            let values = layer.isosurfaces.iter().map(Isosurface::value);
            let mut ranges: Vec<IsoRange> = values.map(|v| IsoRange { lo: v, hi: v }).collect();
            ranges.sort_by(|a, b| a.lo.total_cmp(&b.lo));
            ranges
        }
    }
}

/// The densities that decide which one stands for all, where those of some ranges are visible.
fn deciding_ranges(visible: Vec<IsoRange>, statistic: Statistic) -> Vec<IsoRange> {
    let (Some(first), Some(last)) = (visible.first(), visible.last()) else { return visible };
    // A larger density hides a visible one, or a lesser one does; into a mean all of them go.
    let (lo, hi) = match statistic {
        Statistic::Maximum => (first.lo, f64::INFINITY),
        Statistic::Minimum => (f64::NEG_INFINITY, last.hi),
        Statistic::Average => (f64::NEG_INFINITY, f64::INFINITY),
    };
    vec![IsoRange { lo, hi }]
}
