//! A layer of a plan as the shaders read it. Everything is worked out in 64 bits and then rounded once;
//! lengths are in `unit`s, so that no scale of a world is too large or too small for 32 bits.

use crate::params::{Layer, flag};
use slabsplat_backend::{ColorSplats, LayerPlan, SectionSplats, Slabs, SmoothSections, Splats};
use slabsplat_core::{Phong, SliceOrder, View};

/// What the shaders read of a layer, but for where its voxels, its table and its planes are among those of
/// all layers.
pub(crate) fn layer_params(plan: &LayerPlan<'_>, splats: &Splats) -> Layer {
    let mut layer = bytemuck::Zeroable::zeroed();
    put_view(plan, &mut layer);
    put_cells(plan, &mut layer);
    put_footprint(plan, &mut layer);
    match splats {
        Splats::Colors(ColorSplats::Sections(sections)) => {
            let SectionSplats { slabs, table, merged, .. } = &**sections;
            put_slabs(plan, slabs, &mut layer);
            let rows = table.rows();
            layer.rows_per_index = rows.rows_per_index;
            layer.last_row = rows.last_row;
            layer.is_mirrored = flag(rows.mirrored);
            if let Some(merged) = merged {
                let rows = merged.table.rows();
                layer.merged_rows_per_index = rows.rows_per_index;
                layer.last_merged_row = rows.last_row;
            }
        }
        Splats::Colors(ColorSplats::Slices { order, .. }) => put_slices(order, &mut layer),
        Splats::Colors(ColorSplats::Voxels { .. }) => {}
        Splats::Densities(densities) => {
            put_slabs(plan, &densities.slabs, &mut layer);
            if let SmoothSections::Table(table) = &densities.smooth {
                [layer.rows_per_index, layer.last_row] = table.rows();
            }
        }
    }
    if let Some(light) = &plan.light {
        put_shading(&light.phong, &mut layer);
    }
    if let Some(region) = &plan.region {
        layer.n_planes = region.planes().len() as u32;
        layer.is_inverted = flag(region.is_inverted());
        layer.has_lit_faces = flag(region.is_lit());
    }
    layer
}

fn put_view(plan: &LayerPlan<'_>, layer: &mut Layer) {
    let (grid, view) = (&plan.grid(), &plan.view);
    let unit = grid.unit();
    let from_index = view.from_index(grid);
    let row = |axis: usize| {
        let in_units = from_index.matrix.row(axis) / unit;
        in_units.extend(from_index.center_in_view[axis] / unit).as_vec4().to_array()
    };
    [layer.right, layer.up, layer.depth] = [0, 1, 2].map(row);
    layer.center_in_index = from_index.center_in_index.as_vec3().to_array();
    layer.dims = grid.dims().map(|n| n as u32);
    let near = view.near_depth();
    // A voxel step before the near depth is the eye, where there is one.
    let step = plan.volume.grid().unit();
    let eye_to_near = if view.is_perspective() { step } else { 0.0 };
    layer.eye_distance = ((eye_to_near - near) / unit) as f32;
    layer.near = (near / unit) as f32;
    let pixels_at_eye = if view.is_perspective() { step / unit } else { 1.0 };
    layer.pixels_per_unit = (view.pixels_per_world(near) * unit * pixels_at_eye) as f32;
}

/// By how much footprints are widened, and where cells end; grids of voxels end with these.
fn put_cells(plan: &LayerPlan<'_>, layer: &mut Layer) {
    let spread = plan.view.spread_of_cells();
    let least = if spread.is_some() { View::LEAST_STRETCH_OF_CELLS } else { 1.0 };
    layer.least_stretch_squared = least.powi(2) as f32;
    layer.spread = spread.unwrap_or(0.0) as f32;
    let ends = plan.volume.grid().ends_of_cells(plan.level);
    [layer.first_out, layer.last_out] = [0, 1].map(|end| ends.map(|of_axis| of_axis[end] as f32));
}

fn put_footprint(plan: &LayerPlan<'_>, layer: &mut Layer) {
    let (shape, unit) = (&plan.shape, plan.grid().unit());
    layer.half_depth = (plan.half_depth / unit) as f32;
    layer.index_per_depth = (shape.index_per_depth * unit) as f32;
    layer.is_tilted = flag(shape.is_tilted(plan.radius));
    layer.across = (shape.across * unit * unit) as f32;
    layer.shear = -shape.shear as f32;
    layer.along = (shape.along * unit * unit) as f32;
    let [right, up] = shape.tilt.map(|c| (c * unit) as f32);
    layer.tilt = [right, -up];
    layer.half_extent = shape.half_extent.map(|c| (c / unit) as f32);
}

fn put_slabs(plan: &LayerPlan<'_>, slabs: &Slabs, layer: &mut Layer) {
    layer.slab_thickness = (slabs.grid.thickness() / plan.grid().unit()) as f32;
    layer.first_drawn = slabs.first_drawn as u32;
}

fn put_slices(order: &SliceOrder, layer: &mut Layer) {
    layer.slice_axis = order.axis as u32 + if order.is_reversed { 4 } else { 0 };
}

fn put_shading(phong: &Phong, layer: &mut Layer) {
    layer.is_lit = 1;
    layer.is_two_sided = flag(phong.two_sided);
    let coefficients = [phong.ambient, phong.diffuse, phong.specular, phong.shininess];
    [layer.ambient, layer.diffuse, layer.specular, layer.shininess] =
        coefficients.map(|c| c as f32);
    layer.zero_gradient = phong.zero_gradient as f32;
}
