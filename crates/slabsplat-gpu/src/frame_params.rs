//! A plan as the shaders read it: what all layers share. Everything is worked out in 64 bits and then rounded
//! once.

use crate::classification::compositing_code;
use crate::params::{Frame, Lamp, TILE_SIDE, flag};
use crate::regions::ray_per_pixel;
use slabsplat_backend::{ColorSplats, FramePlan, LayerPlan};
use slabsplat_core::Lookup;
use slabsplat_core::glam::DVec3;

/// A layer of colours, as a plan has it.
pub(crate) type ColorLayer<'a, 'p> = (&'a LayerPlan<'p>, &'a ColorSplats);

/// What the shaders read of `plan`, whose layers are these, and whose tables have `row_len` quads in a row.
pub(crate) fn frame_params(
    plan: &FramePlan<'_>,
    layers: &[ColorLayer<'_, '_>],
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
    put_lamps(layers, &mut frame);
    frame
}

/// All layers splat one kernel, and read it alike.
fn put_kernel(layers: &[ColorLayer<'_, '_>], frame: &mut Frame) {
    let Some((layer, _)) = layers.first() else { return };
    let is_tilted = |layer: &LayerPlan<'_>| layer.shape.is_tilted(layer.radius);
    frame.is_perspective = flag(layer.view.is_perspective());
    frame.is_tilted = flag(layers.iter().any(|(layer, _)| is_tilted(layer)));
    frame.radius = layer.radius as f32;
}

/// What sheets of the first layer have in common with those of the others.
fn put_sheets(layers: &[ColorLayer<'_, '_>], frame: &mut Frame) {
    let Some((layer, splats)) = layers.first() else { return };
    frame.method = method_code(splats);
    match splats {
        ColorSplats::Sections(sections) => {
            let (grid, table) = (sections.slabs.grid, &sections.table);
            frame.n_sheets = grid.n_slabs() as u32;
            frame.first_slab = (grid.front(0) / grid.thickness()).round() as i32;
            frame.samples_per_index = table.samples_per_index();
            frame.is_nearest = flag(table.lookup() == Lookup::Nearest);
            let [start, step] = ray_per_pixel(&layer.view);
            [frame.ray_start, frame.ray_step] = [(start / grid.thickness()) as f32, step as f32];
        }
        ColorSplats::Slices { order, table } => {
            frame.n_sheets = order.n_slices as u32;
            frame.samples_per_index = table.samples_per_index();
        }
        ColorSplats::Voxels { table } => {
            frame.n_sheets = 1;
            frame.samples_per_index = table.samples_per_index();
        }
    }
    for (_, splats) in layers {
        if let ColorSplats::Sections(sections) = splats {
            frame.n_slabs_before = frame.n_slabs_before.max(sections.slabs.n_before as u32);
        }
    }
}

/// All layers that are lit at all have the same lights.
fn put_lamps(layers: &[ColorLayer<'_, '_>], frame: &mut Frame) {
    let Some(light) = layers.iter().find_map(|(layer, _)| layer.light.as_ref()) else { return };
    let four = |v: DVec3| v.extend(0.0).as_vec4().to_array();
    for (lamp, of_plan) in frame.lamps.iter_mut().zip(&light.lamps) {
        let [to_light, halfway, color] =
            [of_plan.to_light, of_plan.halfway, of_plan.color].map(four);
        *lamp = Lamp { to_light, halfway, color };
        frame.n_lamps += 1;
    }
}

/// The number by which the shaders know the method.
fn method_code(splats: &ColorSplats) -> u32 {
    match splats {
        ColorSplats::Sections(_) => 0,
        ColorSplats::Slices { .. } => 1,
        ColorSplats::Voxels { .. } => 2,
    }
}
