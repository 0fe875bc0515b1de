//! A plan as the shaders read it. Everything is worked out in 64 bits and then rounded once; lengths are in
//! `unit`s, so that no scale of a world is too large or too small for 32 bits.

use crate::classification::compositing_code;
use crate::params::{Frame, TILE_SIDE, flag};
use slabsplat_backend::{ColorSplats, FramePlan, LayerPlan, SectionSplats, Slabs};
use slabsplat_core::{BlinnPhong, Lookup, SliceOrder};

/// What the shaders read of `plan`, whose splats are these, and whose table has `row_len` quads in a row.
pub(crate) fn frame_params(
    plan: &FramePlan<'_>,
    layer: &LayerPlan<'_>,
    splats: &ColorSplats,
    row_len: u32,
) -> Frame {
    let mut frame = Frame {
        opacity_cutoff: plan.opacity_cutoff,
        compositing: compositing_code(plan.compositing),
        background: plan.image.background,
        row_len,
        ..bytemuck::Zeroable::zeroed()
    };
    put_view(layer, &mut frame);
    put_footprint(layer, &mut frame);
    put_sheets(layer, splats, &mut frame);
    if let Some(light) = &layer.light {
        put_light(light, &mut frame);
    }
    frame
}

fn put_view(layer: &LayerPlan<'_>, frame: &mut Frame) {
    let (grid, view) = (layer.volume.grid(), &layer.view);
    let unit = grid.unit();
    let from_index = view.from_index(grid);
    let row = |axis: usize| {
        let in_units = from_index.matrix.row(axis) / unit;
        in_units.extend(from_index.center_in_view[axis] / unit).as_vec4().to_array()
    };
    [frame.right, frame.up, frame.depth] = [0, 1, 2].map(row);
    frame.center_in_index = from_index.center_in_index.as_vec3().to_array();
    frame.dims = grid.dims().map(|n| n as u32);
    frame.image_size = view.image_size();
    frame.n_tiles = view.image_size().map(|side| side.div_ceil(TILE_SIDE));
    frame.image_center = view.image_size().map(|side| 0.5 * side as f32);
    frame.is_perspective = flag(view.is_perspective());
    let near = view.near_depth();
    // A unit before the near depth is the eye, where there is one.
    let eye_to_near = if view.is_perspective() { unit } else { 0.0 };
    frame.eye_distance = ((eye_to_near - near) / unit) as f32;
    frame.near = (near / unit) as f32;
    frame.pixels_per_unit = (view.pixels_per_world(near) * unit) as f32;
}

fn put_footprint(layer: &LayerPlan<'_>, frame: &mut Frame) {
    let (shape, unit) = (&layer.shape, layer.volume.grid().unit());
    frame.radius = layer.radius as f32;
    frame.half_depth = (layer.half_depth / unit) as f32;
    frame.index_per_depth = (shape.index_per_depth * unit) as f32;
    frame.is_tilted = flag(shape.is_tilted(layer.radius));
    frame.across = (shape.across * unit * unit) as f32;
    frame.lean = -shape.lean as f32;
    frame.along = (shape.along * unit * unit) as f32;
    let [right, up] = shape.tilt.map(|c| (c * unit) as f32);
    frame.tilt = [right, -up];
    frame.half_extent = shape.half_extent.map(|c| (c / unit) as f32);
}

fn put_sheets(layer: &LayerPlan<'_>, splats: &ColorSplats, frame: &mut Frame) {
    frame.method = method_code(splats);
    match splats {
        ColorSplats::Sections(sections) => {
            let SectionSplats { slabs, table, .. } = &**sections;
            put_slabs(layer, slabs, frame);
            let rows = table.rows();
            frame.samples_per_index = table.samples_per_index();
            frame.rows_per_index = rows.rows_per_index;
            frame.last_row = rows.last_row;
            frame.is_mirrored = flag(rows.mirrored);
            frame.is_nearest = flag(table.lookup() == Lookup::Nearest);
        }
        ColorSplats::Slices { order, table } => {
            put_slices(order, frame);
            frame.samples_per_index = table.samples_per_index();
        }
        ColorSplats::Voxels { table } => {
            frame.n_sheets = 1;
            frame.samples_per_index = table.samples_per_index();
        }
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

fn put_slabs(layer: &LayerPlan<'_>, slabs: &Slabs, frame: &mut Frame) {
    let Slabs { grid, first_drawn, n_before } = *slabs;
    frame.n_sheets = grid.n_slabs() as u32;
    frame.slab_thickness = (grid.thickness() / layer.volume.grid().unit()) as f32;
    frame.first_slab = (grid.front(0) / grid.thickness()).round() as i32;
    frame.n_slabs_before = n_before as u32;
    frame.first_drawn = first_drawn as u32;
}

fn put_slices(order: &SliceOrder, frame: &mut Frame) {
    frame.n_sheets = order.n_slices as u32;
    frame.slice_axis = order.axis as u32 + if order.is_reversed { 4 } else { 0 };
}

/// A light and a viewer, both infinitely far away.
fn put_light(BlinnPhong { phong, lamps }: &BlinnPhong, frame: &mut Frame) {
    frame.is_lit = 1;
    frame.is_two_sided = flag(phong.two_sided);
    // The backend lets no frames through that have more, or coloured ones.
    if let [lamp] = lamps.as_slice() {
        frame.to_light = lamp.to_light.as_vec3().to_array();
        frame.halfway = lamp.halfway.as_vec3().to_array();
    }
    let coefficients = [phong.ambient, phong.diffuse, phong.specular, phong.shininess];
    [frame.ambient, frame.diffuse, frame.specular, frame.shininess] =
        coefficients.map(|c| c as f32);
}
