//! A plan as the shaders read it: what all layers share. Everything is worked out in 64 bits and then rounded
//! once.

use crate::classification::compositing_code;
use crate::params::{Frame, LightInView, TILE_SIDE, flag};
use crate::regions::ray_per_pixel;
use crate::splits::merged_sections;
use slabsplat_backend::{ColorSplats, FramePlan, LayerPlan, Slabs, Splats};
use slabsplat_core::Lookup;
use slabsplat_core::glam::DVec3;

/// A layer as a plan has it, and what it splats.
pub(crate) type SplatLayer<'a, 'p> = (&'a LayerPlan<'p>, &'a Splats);

/// What the shaders read of `plan`, whose layers are these, and whose tables have `row_len` quads in a row.
pub(crate) fn frame_params(
    plan: &FramePlan<'_>,
    layers: &[SplatLayer<'_, '_>],
    row_len: u32,
) -> Frame {
    let image_size = [plan.image.width, plan.image.height];
    let mut frame = Frame {
        image_size,
        n_tiles: image_size.map(|side| side.div_ceil(TILE_SIDE)),
        image_center: image_size.map(|side| 0.5 * side as f32),
        compositing: compositing_code(plan.compositing),
        n_layers: layers.len() as u32,
        has_regions: flag(layers.iter().any(|(layer, _)| layer.region.is_some())),
        row_len,
        opacity_cutoff: plan.opacity_cutoff,
        background: plan.image.background,
        ..bytemuck::Zeroable::zeroed()
    };
    put_kernel(layers, &mut frame);
    put_sheets(layers, &mut frame);
    put_lights(layers, &mut frame);
    frame
}

/// All layers splat one kernel, and read it alike.
fn put_kernel(layers: &[SplatLayer<'_, '_>], frame: &mut Frame) {
    let Some((layer, _)) = layers.first() else { return };
    let is_tilted = |layer: &LayerPlan<'_>| layer.shape.is_tilted(layer.radius);
    frame.is_perspective = flag(layer.view.is_perspective());
    frame.is_tilted = flag(layers.iter().any(|(layer, _)| is_tilted(layer)));
    frame.radius = layer.radius as f32;
}

/// The slabs that a layer's sheets are of, if they are of any.
pub(crate) fn slabs_of(splats: &Splats) -> Option<&Slabs> {
    match splats {
        Splats::Colors(ColorSplats::Sections(sections)) => Some(&sections.slabs),
        Splats::Colors(ColorSplats::Slices { .. } | ColorSplats::Voxels { .. }) => None,
        Splats::Densities(densities) => Some(&densities.slabs),
    }
}

/// How many slabs before a slab the splats may begin whose sections it holds: none of those that are all
/// whole, as cells are in parallel rays.
fn n_slabs_before(splats: &Splats) -> usize {
    let are_all_whole = merged_sections(splats)
        .is_some_and(|merged| merged.levels.split(f32::MAX).share_of_half_depth == 0.0);
    if are_all_whole { 0 } else { slabs_of(splats).map_or(0, |slabs| slabs.n_before) }
}

/// What sheets of the first layer have in common with those of the others.
fn put_sheets(layers: &[SplatLayer<'_, '_>], frame: &mut Frame) {
    let Some((layer, splats)) = layers.first() else { return };
    frame.method = method_code(splats);
    if let Some(slabs) = slabs_of(splats) {
        let grid = slabs.grid;
        frame.n_sheets = grid.n_slabs() as u32;
        frame.first_slab = (grid.front(0) / grid.thickness()).round() as i32;
        let [start, step] = ray_per_pixel(&layer.view);
        [frame.ray_start, frame.ray_step] = [(start / grid.thickness()) as f32, step as f32];
    }
    let n_before = layers.iter().map(|(_, splats)| n_slabs_before(splats));
    frame.n_slabs_before = n_before.max().unwrap_or(0) as u32;
    match splats {
        Splats::Colors(ColorSplats::Sections(sections)) => {
            let table = &sections.table;
            frame.samples_per_index = table.samples_per_index();
            frame.is_nearest = flag(table.lookup() == Lookup::Nearest);
        }
        Splats::Colors(ColorSplats::Slices { order, table }) => {
            frame.n_sheets = order.n_slices as u32;
            frame.samples_per_index = table.samples_per_index();
        }
        Splats::Colors(ColorSplats::Voxels { table }) => {
            frame.n_sheets = 1;
            frame.samples_per_index = table.samples_per_index();
        }
        // They have tables of another kind.
        Splats::Densities(_) => {}
    }
}

/// All layers that are lit at all have the same lights. Normals of densities are those of view space.
fn put_lights(layers: &[SplatLayer<'_, '_>], frame: &mut Frame) {
    let is_lit = |(layer, _): &&SplatLayer<'_, '_>| layer.light.is_some();
    let Some((layer, splats)) = layers.iter().find(is_lit) else { return };
    let Some(phong) = &layer.light else { return };
    let four = |v: DVec3| v.extend(0.0).as_vec4().to_array();
    for (light, of_plan) in frame.lights.iter_mut().zip(&phong.lights) {
        let seen = match splats {
            Splats::Colors(_) => *of_plan,
            Splats::Densities(_) => of_plan.seen_along(layer.view.axes()),
        };
        let [to_light, halfway, color] = [seen.to_light, seen.halfway, seen.color].map(four);
        *light = LightInView { to_light, halfway, color };
        frame.n_lights += 1;
    }
}

/// The number by which the shaders know the method.
fn method_code(splats: &Splats) -> u32 {
    match splats {
        Splats::Colors(ColorSplats::Sections(_)) => 0,
        Splats::Colors(ColorSplats::Slices { .. }) => 1,
        Splats::Colors(ColorSplats::Voxels { .. }) => 2,
        Splats::Densities(_) => 3,
    }
}
