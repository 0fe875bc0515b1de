//! How slabs split kernels, as the shaders read it: `shaders/shared/spans.wgsl`.

use crate::regions::Element;
use slabsplat_backend::{ColorSplats, MergedSections, Splats};

/// An element for each split of a layer; `None` if all its voxels have all their sections.
pub(crate) fn elements(splats: &Splats) -> Option<impl Iterator<Item = Element>> {
    let merged = merged_sections(splats)?;
    // Shaders need know no infinity: the last one has no bound, however large it is.
    let finite = |most: f32| most.clamp(-f32::MAX, f32::MAX);
    let all = merged.levels.all();
    Some(
        all.map(move |(most, split)| [finite(most), split.share_of_half_depth, split.n_slabs, 0.0]),
    )
}

/// What may be merged of what a layer splats.
pub(crate) fn merged_sections(splats: &Splats) -> Option<&MergedSections> {
    match splats {
        Splats::Colors(ColorSplats::Sections(sections)) => sections.merged.as_ref(),
        _ => None,
    }
}
