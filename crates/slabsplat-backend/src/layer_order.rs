//! The order in which layers are summed: not the scene's, so that a picture does not depend on it by a bit.

use slabsplat_core::{
    Isosurface, LabelMap, LabelStyle, Labels, Layer, Phong, PiecewiseLinear, Shading,
    TransferFunction, TransferFunction2d, Volume, VoxelColors,
};
use std::cmp::Ordering;
use std::sync::Arc;

/// The layers in an order that depends on what they are, not on where they stand in the scene.
pub(crate) fn in_one_order(layers: &[Layer]) -> Vec<&Layer> {
    let mut ordered: Vec<&Layer> = layers.iter().collect();
    ordered.sort_by(|a, b| compare(a, b));
    ordered
}

/// Layers that are equal look the same.
fn compare(a: &Layer, b: &Layer) -> Ordering {
    let by_position = || in_numbers(position(a), position(b));
    let by_look = || in_numbers(look(a), look(b));
    in_numbers(region(a), region(b))
        .then_with(by_position)
        .then_with(by_look)
        .then_with(|| by_values(&a.volume, &b.volume))
        .then_with(|| by_labels(a, b))
        .then_with(|| by_colors(a.colors.as_ref(), b.colors.as_ref()))
}

/// The grids are the same.
fn by_values(a: &Arc<Volume>, b: &Arc<Volume>) -> Ordering {
    if Arc::ptr_eq(a, b) {
        return Ordering::Equal;
    }
    let values = |volume| move |idx| Volume::value(volume, idx);
    let n_voxels = a.grid().n_voxels();
    in_numbers((0..n_voxels).map(values(a)), (0..n_voxels).map(values(b)))
}

/// The styles are the same.
fn by_labels(a: &Layer, b: &Layer) -> Ordering {
    let [a, b] = [a, b].map(|layer| layer.labels.as_ref().map(Labels::map));
    let numbers =
        |map: Option<&LabelMap>| map.map(|map| (map.labels().to_vec(), map.indices().to_vec()));
    if a.zip(b).is_some_and(|(a, b)| std::ptr::eq(a, b)) {
        return Ordering::Equal;
    }
    numbers(a).cmp(&numbers(b))
}

/// The grids are the same.
fn by_colors(a: Option<&VoxelColors>, b: Option<&VoxelColors>) -> Ordering {
    let (Some(a), Some(b)) = (a, b) else { return a.is_some().cmp(&b.is_some()) };
    if a.is_same(b) {
        return Ordering::Equal;
    }
    let numbers = |colors| {
        let at = move |idx| VoxelColors::at(colors, idx).map(f64::from);
        (0..colors.samples().len()).flat_map(at)
    };
    in_numbers(numbers(a), numbers(b))
}

/// Where it is seen; first of all, so that layers of one region follow each other.
fn region(layer: &Layer) -> impl Iterator<Item = f64> {
    let planes = layer.region.planes().iter();
    let planes = planes.flat_map(|plane| [plane.normal().to_array(), [plane.distance(); 3]]);
    let switches = [layer.region.is_inverted(), layer.region.is_lit()];
    switches.into_iter().map(|is_on| f64::from(u8::from(is_on))).chain(planes.flatten())
}

/// Where its voxels are.
fn position(layer: &Layer) -> impl Iterator<Item = f64> {
    let grid = layer.volume.grid();
    let dims = grid.dims().map(|n| n as f64);
    dims.into_iter().chain(grid.world_from_index().to_cols_array())
}

/// What is seen of them.
fn look(layer: &Layer) -> impl Iterator<Item = f64> {
    let points = points(&layer.transfer);
    let factors = layer.gradient_opacity.iter().flat_map(PiecewiseLinear::points);
    let factors = factors.flat_map(|&(gradient, [factor])| [gradient, factor]);
    let by_both = layer.transfer_2d.iter().flat_map(TransferFunction2d::numbers);
    points
        .chain(light(layer.shading))
        .chain(factors)
        .chain(by_both)
        .chain(styles(layer.labels.as_ref()))
        .chain(surfaces(&layer.isosurfaces))
}

/// A function of values.
fn points(transfer: &TransferFunction) -> impl Iterator<Item = f64> {
    let opacity = transfer.opacity_points().points().iter();
    let color = transfer.color_points().points().iter();
    let opacity = opacity.flat_map(|&(value, [opacity])| [value, opacity]);
    let color = color.flat_map(|&(value, [r, g, b])| [value, r, g, b]);
    opacity.chain(color)
}

/// What labels change.
fn styles(labels: Option<&Labels>) -> impl Iterator<Item = f64> {
    labels.into_iter().flat_map(Labels::styles).flat_map(|(&label, style)| {
        let LabelStyle { transfer, color, opacity, .. } = style;
        let of_transfer = transfer.iter().flat_map(points);
        [label as f64, *opacity]
            .into_iter()
            .chain(color.iter().flatten().copied())
            .chain(of_transfer)
    })
}

/// What is shown of them by isosurfaces, whose order has no meaning.
fn surfaces(isosurfaces: &[Isosurface]) -> impl Iterator<Item = f64> {
    let mut isosurfaces: Vec<&Isosurface> = isosurfaces.iter().collect();
    isosurfaces.sort_by(|a, b| a.value().total_cmp(&b.value()));
    isosurfaces.into_iter().flat_map(|surface| {
        let color = surface.color();
        let has_color = f64::from(u8::from(color.is_some()));
        let numbers = [surface.value(), surface.opacity(), has_color];
        numbers.into_iter().chain(color.into_iter().flatten())
    })
}

fn light(shading: Shading) -> Vec<f64> {
    let Shading::Phong(phong) = shading else { return Vec::new() };
    let Phong { ambient, diffuse, zero_gradient, specular, shininess, two_sided, .. } = phong;
    vec![ambient, diffuse, zero_gradient, specular, shininess, f64::from(u8::from(two_sided))]
}

fn in_numbers(a: impl IntoIterator<Item = f64>, b: impl IntoIterator<Item = f64>) -> Ordering {
    let (mut a, mut b) = (a.into_iter(), b.into_iter());
    loop {
        match (a.next(), b.next()) {
            (None, None) => return Ordering::Equal,
            (None, Some(_)) => return Ordering::Less,
            (Some(_), None) => return Ordering::Greater,
            (Some(a), Some(b)) if a.total_cmp(&b).is_eq() => {}
            (Some(a), Some(b)) => return a.total_cmp(&b),
        }
    }
}
