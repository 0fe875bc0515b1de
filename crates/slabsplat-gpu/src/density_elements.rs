//! What densities are shown by, as elements of the shaders' `table`.

use slabsplat_backend::LayerPlan;
use slabsplat_backend::densities::{self, ValueScale, WeightCell};
use slabsplat_core::TransferFunction;

/// An element of the shaders' `table`.
pub(crate) type Element = [f32; 4];

/// Elements that a cell takes: `shaders/shared/cells.wgsl`.
pub(crate) const ELEMENTS_OF_CELL: u32 = 6;

/// Elements that a surface takes: `shaders/shared/isosurfaces.wgsl`.
pub(crate) const ELEMENTS_OF_SURFACE: u32 = 2;

/// The cells of a transfer function, where an opacity weighs that, with the integrals up to each.
pub(crate) fn cells(
    transfer: &TransferFunction,
    weight: impl Fn(f64) -> f64,
    scale: &ValueScale,
) -> Vec<Element> {
    let steps: Vec<f64> = densities::steps(transfer).map(|step| scale.unclamped(step)).collect();
    let mut integrals = [0.0; 5];
    let mut elements = Vec::new();
    for cell in densities::weight_cells(transfer, weight, scale) {
        elements.extend(elements_of_cell(&cell, steps.contains(&cell.start), &integrals));
        for powers in cell.integrals() {
            integrals.iter_mut().zip(powers).for_each(|(sum, term)| *sum += term);
        }
    }
    elements
}

fn elements_of_cell(
    cell: &WeightCell,
    is_step: bool,
    integrals: &[f64; 5],
) -> [Element; ELEMENTS_OF_CELL as usize] {
    // What a float leaves over of each integral is a second one.
    let large = integrals.map(|integral| integral as f32);
    let mut rest = [0.0; 5];
    for (rest, (integral, large)) in rest.iter_mut().zip(integrals.iter().zip(large)) {
        *rest = (integral - f64::from(large)) as f32;
    }
    let [start, width] = [cell.start, cell.width].map(|density| density as f32);
    let [red, green, blue] = cell.color.map(|channel| channel.map(|number| number as f32));
    let is_step = if is_step { 1.0 } else { 0.0 };
    [
        [start, width, large[4], rest[4]],
        cell.weight.map(|coefficient| coefficient as f32),
        [red[0], green[0], blue[0], is_step],
        [red[1], green[1], blue[1], 0.0],
        [large[0], large[1], large[2], large[3]],
        [rest[0], rest[1], rest[2], rest[3]],
    ]
}

/// The surfaces of a layer, by value, rising.
pub(crate) fn surfaces(layer: &LayerPlan<'_>, scale: &ValueScale) -> Vec<Element> {
    let mut surfaces: Vec<_> = layer.isosurfaces.iter().collect();
    surfaces.sort_by(|a, b| a.value().total_cmp(&b.value()));
    let elements = surfaces.into_iter().flat_map(|surface| {
        let [r, g, b] = surface.color().unwrap_or_else(|| layer.transfer.color(surface.value()));
        let value = scale.of_isosurface(surface);
        [[value, surface.opacity(), 0.0, 0.0], [r, g, b, 0.0]]
    });
    elements.map(|element| element.map(|number| number as f32)).collect()
}
