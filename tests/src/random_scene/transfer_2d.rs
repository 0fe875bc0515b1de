//! Two-dimensional transfer functions at random.

use fastrand::Rng;
use slabsplat_core::{TransferBox, TransferFunction2d, TransferImage};

/// Over a range of values, and gradients as steep as these are far apart.
pub(super) fn random_transfer_2d(rng: &mut Rng, [lo, hi]: [f64; 2]) -> TransferFunction2d {
    let (lo, extent) = if (hi - lo).is_finite() && lo < hi { (lo, hi - lo) } else { (0.0, 1.0) };
    if rng.bool() {
        let boxes = (0..rng.usize(1..=4)).map(|_| random_box(rng, lo, extent));
        return TransferFunction2d::Boxes(boxes.collect());
    }
    let (width, height) = (rng.usize(1..6), rng.usize(1..4));
    let pixels = (0..width * height).map(|_| random_pixel(rng)).collect();
    let values = [lo - extent * rng.f64(), lo + extent * (0.1 + rng.f64())];
    let image = TransferImage::new(width, pixels, values, [0.0, extent * (0.1 + rng.f64())]);
    TransferFunction2d::Image(image.expect("the ends rise, and channels lie within 0 to 1"))
}

/// Some sides have no end, some boxes fade.
fn random_box(rng: &mut Rng, lo: f64, extent: f64) -> TransferBox {
    let mut side = |least: f64, extent: f64| {
        let first = least + 0.7 * extent * rng.f64();
        let last = first + extent * rng.f64();
        let start = if rng.u32(..4) == 0 { f64::NEG_INFINITY } else { first };
        [start, if rng.u32(..4) == 0 { f64::INFINITY } else { last }]
    };
    let values = side(lo, extent);
    let gradients = side(0.0, 0.5 * extent);
    let mut fade = |[first, last]: [f64; 2]| {
        let most = if (last - first).is_finite() { 0.5 * (last - first) } else { 0.2 * extent };
        if rng.bool() { 0.0 } else { 0.99 * most * rng.f64() }
    };
    let fade = [fade(values), fade(gradients)];
    let part = TransferBox::new(values, gradients).and_then(|part| part.fade(fade));
    let color = [rng.f64(), rng.f64(), rng.f64()];
    let part = part.and_then(|part| part.opacity(0.9 * rng.f64())?.color(color));
    part.expect("the ends rise, and shares lie within 0 to 1")
}

fn random_pixel(rng: &mut Rng) -> [f32; 4] {
    let opacity = if rng.bool() { 0.0 } else { 0.9 * rng.f32() };
    [rng.f32(), rng.f32(), rng.f32(), opacity]
}
