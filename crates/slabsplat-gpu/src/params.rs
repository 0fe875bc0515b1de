//! The structs that shaders read, as Rust has them. A test compares their layouts with what naga says of
//! the shaders' own.

use bytemuck::{Pod, Zeroable};
use slabsplat_core::Light;
use std::mem::offset_of;

/// A flag in a struct that a shader reads.
pub(crate) fn flag(is_set: bool) -> u32 {
    u32::from(is_set)
}

/// `shaders/shared/frame.wgsl` says what each member means.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Frame {
    pub(crate) image_size: [u32; 2],
    pub(crate) n_tiles: [u32; 2],
    pub(crate) image_center: [f32; 2],
    pub(crate) is_perspective: u32,
    pub(crate) method: u32,
    pub(crate) compositing: u32,
    pub(crate) n_sheets: u32,
    pub(crate) first_slab: i32,
    pub(crate) n_slabs_before: u32,
    pub(crate) n_layers: u32,
    pub(crate) has_regions: u32,
    pub(crate) is_tilted: u32,
    pub(crate) radius: f32,
    pub(crate) samples_per_index: f32,
    pub(crate) row_len: u32,
    pub(crate) is_nearest: u32,
    pub(crate) opacity_cutoff: f32,
    pub(crate) ray_start: f32,
    pub(crate) ray_step: f32,
    pub(crate) max_visits: u32,
    pub(crate) n_lights: u32,
    pub(crate) background: [f32; 4],
    pub(crate) lights: [LightInView; Light::MAX_LIGHTS],
}

impl Frame {
    /// What shaders look at: the rest are lights that there are not.
    pub(crate) fn bytes_in_use(&self) -> &[u8] {
        let n_unused = self.lights.len() - self.n_lights as usize;
        let bytes = bytemuck::bytes_of(self);
        &bytes[..bytes.len() - n_unused * size_of::<LightInView>()]
    }
}

/// A light, likewise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct LightInView {
    pub(crate) to_light: [f32; 4],
    pub(crate) halfway: [f32; 4],
    pub(crate) color: [f32; 4],
}

/// `shaders/shared/layer.wgsl`, likewise.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Layer {
    pub(crate) right: [f32; 4],
    pub(crate) up: [f32; 4],
    pub(crate) depth: [f32; 4],
    pub(crate) center_in_index: [f32; 3],
    pub(crate) pixels_per_unit: f32,
    pub(crate) dims: [u32; 3],
    pub(crate) first_voxel: u32,
    pub(crate) ambient: f32,
    pub(crate) diffuse: f32,
    pub(crate) specular: f32,
    pub(crate) shininess: f32,
    pub(crate) is_lit: u32,
    pub(crate) is_two_sided: u32,
    pub(crate) eye_distance: f32,
    pub(crate) near: f32,
    pub(crate) half_depth: f32,
    pub(crate) index_per_depth: f32,
    pub(crate) tilt: [f32; 2],
    pub(crate) half_extent: [f32; 2],
    pub(crate) across: f32,
    pub(crate) shear: f32,
    pub(crate) along: f32,
    pub(crate) slab_thickness: f32,
    pub(crate) first_drawn: u32,
    pub(crate) slice_axis: u32,
    pub(crate) is_tilted: u32,
    pub(crate) first_element: u32,
    pub(crate) rows_per_index: f32,
    pub(crate) last_row: f32,
    pub(crate) is_mirrored: u32,
    pub(crate) region: u32,
    pub(crate) first_plane: u32,
    pub(crate) n_planes: u32,
    pub(crate) is_inverted: u32,
    pub(crate) has_lit_faces: u32,
    pub(crate) zero_gradient: f32,
    pub(crate) least_stretch_squared: f32,
    pub(crate) first_out: [f32; 3],
    pub(crate) spread: f32,
    pub(crate) last_out: [f32; 3],
    pub(crate) n_part_planes: u32,
    pub(crate) first_split: u32,
    pub(crate) first_merged_element: u32,
    pub(crate) merged_rows_per_index: f32,
    pub(crate) last_merged_row: f32,
}

/// `shaders/shared/densities.wgsl`, likewise.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Densities {
    pub(crate) mode: u32,
    pub(crate) first_shown: u32,
    pub(crate) n_shown: u32,
    pub(crate) is_product: u32,
    pub(crate) values: [f32; 2],
    pub(crate) faint: f32,
    pub(crate) rim: f32,
    pub(crate) across: [[f32; 4]; 3],
    pub(crate) along: [[f32; 4]; 3],
    pub(crate) worst: f32,
    pub(crate) per_rise: f32,
    pub(crate) padding: [u32; 2],
}

/// `shaders/shared/sample.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct VolumeParams {
    pub(crate) gradient_x: [f32; 4],
    pub(crate) gradient_y: [f32; 4],
    pub(crate) gradient_z: [f32; 4],
    pub(crate) dims: [u32; 3],
    pub(crate) sample_type: u32,
    pub(crate) n_ranges: u32,
    pub(crate) n_opacities: u32,
    pub(crate) n_colors: u32,
    pub(crate) compositing: u32,
}

/// `shaders/shared/record.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Record {
    pub(crate) normal: [f32; 3],
    pub(crate) voxel_idx: u32,
    pub(crate) color: [f32; 4],
}

/// `shaders/shared/cell_record.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct CellRecord {
    pub(crate) cell_idx: u32,
    pub(crate) extinction: f32,
    pub(crate) color: [u32; 2],
    pub(crate) normal: [u32; 2],
    pub(crate) moments: [u32; 2],
}

/// `shaders/depth_key.wgsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct DepthParams {
    pub(crate) low: [[u32; 4]; 3],
    pub(crate) high: [[u32; 4]; 3],
    pub(crate) dims: [u32; 3],
    pub(crate) fraction_bits: u32,
    pub(crate) bias: [u32; 2],
    pub(crate) padding: [u32; 2],
}

/// `shaders/shared/step.wgsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Step {
    pub(crate) first: u32,
    pub(crate) n_elements: u32,
    pub(crate) count_slot: u32,
    pub(crate) chunk_bits: u32,
    pub(crate) shift: u32,
    pub(crate) digit_bits: u32,
    pub(crate) n_blocks: u32,
    pub(crate) first_block: u32,
    pub(crate) first_sample: u32,
    pub(crate) layer: u32,
    pub(crate) first_surface: u32,
    pub(crate) follows_last: u32,
    pub(crate) sheets_behind: i32,
}

/// No slot of the counts.
pub(crate) const NO_COUNT: u32 = u32::MAX;

/// `shaders/shared/spans.wgsl`.
pub(crate) const NO_SPLITS: u32 = u32::MAX;

/// `shaders/shared/surfaces.wgsl`.
pub(crate) const NO_SURFACES: u32 = u32::MAX;

/// `shaders/shared/step.wgsl`, `COUNT_*`: what a frame counts, as it is read back.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Counts {
    pub(crate) n_voxels: u32,
    /// Splats on tiles that there are, whether there is room for them or not.
    pub(crate) n_tossed: u32,
    pub(crate) n_splatted: [u32; 2],
    pub(crate) n_culled: [u32; 2],
    pub(crate) n_tiles: u32,
    pub(crate) n_saturated_tiles: u32,
    /// Tiles that need another round.
    pub(crate) n_paused_tiles: u32,
    /// Not 0 if the driver cut a loop short.
    pub(crate) n_faults: u32,
    /// 1 if the picture is whole, as the device needs to know that leaves it in a texture.
    pub(crate) is_whole: u32,
    /// Tiles on which splats are seen that were not tossed.
    pub(crate) n_cut_tiles: u32,
    /// Splats that were not tossed.
    pub(crate) n_hidden: [u32; 2],
}

/// The word of the counts that says whether the picture is whole.
pub(crate) const COUNT_IS_WHOLE: u32 = (offset_of!(Counts, is_whole) / size_of::<u32>()) as u32;

/// Slots of [`Counts`].
pub(crate) const COUNT_VOXELS: u32 = 0;
pub(crate) const COUNT_SPLATS: u32 = 1;
/// The first of the slots behind them, one for each list of relevant voxels.
pub(crate) const COUNT_OF_LISTS: u32 = (size_of::<Counts>() / size_of::<u32>()) as u32;

/// Bytes of all counts on the device.
pub(crate) const COUNTS_BYTES: u64 = 4 * (COUNT_OF_LISTS + MAX_LAYERS) as u64;

/// `shaders/shared/layer.wgsl`: layers that a frame can have.
pub(crate) const MAX_LAYERS: u32 = 64;

/// `shaders/shared/densities_among_others.wgsl`: layers of densities that a frame can have.
pub(crate) const MOST_DENSITY_LAYERS: usize = 16;

pub(crate) const RECORD_BYTES: u64 = size_of::<Record>() as u64;
/// Bytes of `shaders/shared/splat.wgsl`.
pub(crate) const SPLAT_BYTES: u64 = 32;
/// Bytes of `shaders/shared/tile_work.wgsl`.
pub(crate) const TILE_WORK_BYTES: u64 = 28;

/// `shaders/shared/tile.wgsl`: pixels along the side of a tile.
pub(crate) const TILE_SIDE: u32 = 8;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::classification::{SUMS_DENSITIES, compositing_code};
    use crate::densities::mode_code;
    use crate::density_elements::ELEMENTS_OF_CELL;
    use crate::regions::ELEMENTS_OF_PLANE;
    use slabsplat_backend::ShownDensities;
    use slabsplat_core::{Compositing, Statistic};
    use slabsplat_kernel::SplitLevels;
    use slabsplat_mesh::N_SAMPLES;
    use slabsplat_shaders::{STRUCTS, StructLayout};

    fn layout(name: &str) -> &'static StructLayout {
        STRUCTS.iter().find(|layout| layout.name == name).expect("a shader declares it")
    }

    /// Compares a struct with the shaders' one of the same name, member by member.
    macro_rules! check {
        ($name:ident { $($member:ident),* $(,)? }) => {{
            let layout = layout(stringify!($name));
            assert_eq!(size_of::<$name>(), layout.size as usize, stringify!($name));
            let members = [$((stringify!($member), offset_of!($name, $member))),*];
            let expected: Vec<_> =
                layout.members.iter().map(|m| (m.name, m.offset as usize)).collect();
            assert_eq!(members.as_slice(), expected, stringify!($name));
        }};
    }

    #[test]
    fn layouts_of_frames_are_the_shaders() {
        check!(Frame {
            image_size,
            n_tiles,
            image_center,
            is_perspective,
            method,
            compositing,
            n_sheets,
            first_slab,
            n_slabs_before,
            n_layers,
            has_regions,
            is_tilted,
            radius,
            samples_per_index,
            row_len,
            is_nearest,
            opacity_cutoff,
            ray_start,
            ray_step,
            max_visits,
            n_lights,
            background,
            lights,
        });
        check!(LightInView { to_light, halfway, color });
        check!(Layer {
            right,
            up,
            depth,
            center_in_index,
            pixels_per_unit,
            dims,
            first_voxel,
            ambient,
            diffuse,
            specular,
            shininess,
            is_lit,
            is_two_sided,
            eye_distance,
            near,
            half_depth,
            index_per_depth,
            tilt,
            half_extent,
            across,
            shear,
            along,
            slab_thickness,
            first_drawn,
            slice_axis,
            is_tilted,
            first_element,
            rows_per_index,
            last_row,
            is_mirrored,
            region,
            first_plane,
            n_planes,
            is_inverted,
            has_lit_faces,
            zero_gradient,
            least_stretch_squared,
            first_out,
            spread,
            last_out,
            n_part_planes,
            first_split,
            first_merged_element,
            merged_rows_per_index,
            last_merged_row,
        });
        check!(Densities {
            mode,
            first_shown,
            n_shown,
            is_product,
            values,
            faint,
            rim,
            across,
            along,
            worst,
            per_rise,
            padding,
        });
    }

    #[test]
    fn layouts_of_stages_are_the_shaders() {
        check!(VolumeParams {
            gradient_x,
            gradient_y,
            gradient_z,
            dims,
            sample_type,
            n_ranges,
            n_opacities,
            n_colors,
            compositing,
        });
        check!(Record { normal, voxel_idx, color });
        check!(CellRecord { cell_idx, extinction, color, normal, moments });
        check!(DepthParams { low, high, dims, fraction_bits, bias, padding });
        check!(Step {
            first,
            n_elements,
            count_slot,
            chunk_bits,
            shift,
            digit_bits,
            n_blocks,
            first_block,
            first_sample,
            layer,
            first_surface,
            follows_last,
            sheets_behind,
        });
    }

    #[test]
    fn sizes_are_the_shaders() {
        assert_eq!(u64::from(layout("Splat").size), SPLAT_BYTES);
        assert_eq!(u64::from(layout("TileWork").size), TILE_WORK_BYTES);
    }

    /// Constants have no layout to reflect, so their declarations are looked for.
    #[test]
    fn constants_are_the_shaders() {
        let source: String = slabsplat_shaders::ALL.iter().map(|shader| shader.wgsl).collect();
        let declares = |line: String| assert!(source.contains(&line), "{line}");
        declares(format!("const TILE_SIDE: u32 = {TILE_SIDE}u;"));
        for &compositing in Compositing::ALL {
            let (name, code) = (compositing.name().to_uppercase(), compositing_code(compositing));
            declares(format!("const COMPOSITING_{name}: u32 = {code}u;"));
        }
        declares(format!("const SUMS_DENSITIES: u32 = {SUMS_DENSITIES}u;"));
        declares(format!("const MOST_LAYERS: u32 = {MOST_DENSITY_LAYERS}u;"));
        declares(format!("const ELEMENTS_OF_CELL: u32 = {ELEMENTS_OF_CELL}u;"));
        for (name, shown) in [
            ("COMPOSITED", ShownDensities::Composited),
            ("MAXIMUM", ShownDensities::Statistic(Statistic::Maximum)),
            ("MINIMUM", ShownDensities::Statistic(Statistic::Minimum)),
            ("AVERAGE", ShownDensities::Statistic(Statistic::Average)),
            ("ISOSURFACES", ShownDensities::Isosurfaces),
        ] {
            declares(format!("const MODE_{name}: u32 = {}u;", mode_code(shown)));
        }
        declares(format!("const COUNT_VOXELS: u32 = {COUNT_VOXELS}u;"));
        declares(format!("const COUNT_SPLATS: u32 = {COUNT_SPLATS}u;"));
        declares(format!("const COUNT_OF_LISTS: u32 = {COUNT_OF_LISTS}u;"));
        declares(format!("const MAX_LAYERS: u32 = {MAX_LAYERS}u;"));
        declares(format!("const NO_SPLITS: u32 = {NO_SPLITS:#x}u;"));
        declares(format!("const ON_FACE: f32 = {};", SplitLevels::ON_FACE));
        declares(format!("const N_SPLITS: u32 = {}u;", SplitLevels::N_SPLITS));
        declares(format!("const NO_SURFACES: u32 = {NO_SURFACES:#x}u;"));
        declares(format!("const N_SAMPLES: u32 = {N_SAMPLES}u;"));
        declares(format!("const ELEMENTS_OF_PLANE: u32 = {ELEMENTS_OF_PLANE}u;"));
        let slot = |offset: usize| offset / size_of::<u32>();
        declares(format!("COUNT_SPLATTED: u32 = {}u", slot(offset_of!(Counts, n_splatted))));
        declares(format!("COUNT_CULLED: u32 = {}u", slot(offset_of!(Counts, n_culled))));
        declares(format!("COUNT_TILES: u32 = {}u", slot(offset_of!(Counts, n_tiles))));
        declares(format!(
            "COUNT_FULL_TILES: u32 = {}u",
            slot(offset_of!(Counts, n_saturated_tiles))
        ));
        declares(format!(
            "COUNT_PAUSED_TILES: u32 = {}u",
            slot(offset_of!(Counts, n_paused_tiles))
        ));
        declares(format!("COUNT_FAULTS: u32 = {}u", slot(offset_of!(Counts, n_faults))));
        declares(format!("COUNT_IS_WHOLE: u32 = {}u", slot(offset_of!(Counts, is_whole))));
        declares(format!("COUNT_CUT_TILES: u32 = {}u", slot(offset_of!(Counts, n_cut_tiles))));
        declares(format!("COUNT_HIDDEN: u32 = {}u", slot(offset_of!(Counts, n_hidden))));
    }
}
