//! Where a ray passes surfaces between two nodes (model §12).

use super::between_sheets::Between;
use slabsplat_core::Isosurface;

/// Where a ray passes a surface: from 0 at the first node to 1 at the second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Crossing {
    pub(super) position: f64,
    /// Which of the surfaces.
    pub(super) surface: usize,
}

/// A density that is less than this part of all values below a surface's counts as on it.
const PLATEAU: f64 = 1.0 / (1 << 19) as f64;

/// The surfaces that are passed from a node to the next, in their order, if densities differ from values by
/// `moved` beside what the model says. All values, also those of surfaces, lie between `ends`.
pub(super) fn crossings(
    surfaces: &[Isosurface],
    between: &Between,
    ends: [f64; 2],
    moved: f64,
) -> Vec<Crossing> {
    let [start, end] = between.ends.map(|node| node.density);
    let slopes = between.ends.map(|node| node.slopes.z);
    let mut crossings = Vec::new();
    for (surface, isosurface) in surfaces.iter().enumerate() {
        let value = isosurface.value() - PLATEAU * (ends[1] - ends[0]) + moved;
        if (start < value) != (end < value) {
            let part = (value - start) / (end - start);
            let position = position_of(part, slopes.map(|slope| slope / (end - start)));
            crossings.push(Crossing { position, surface });
        }
    }
    crossings.sort_by(|a, b| a.position.total_cmp(&b.position));
    crossings
}

/// Where a cubic with those slopes at its ends, as far as they let it rise, has risen by a part of 1.
fn position_of(part: f64, slopes: [f64; 2]) -> f64 {
    let [a, b] = slopes.map(|slope| slope.clamp(0.0, 3.0));
    let risen = |t: f64| {
        // Hermite's basis: the value at the end, and the slopes at both ends.
        let (s, u) = (t * t, 1.0 - t);
        s * (3.0 - 2.0 * t) + a * t * u * u - b * s * u
    };
    let [mut least, mut most] = [0.0, 1.0];
    for _ in 0..60 {
        let middle = 0.5 * (least + most);
        if risen(middle) < part { least = middle } else { most = middle }
    }
    0.5 * (least + most)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn isosurfaces_of_a_straight_way_and_of_curves() {
        let check = |part: f64, slopes: [f64; 2], expected: f64| {
            let position = position_of(part, slopes);
            assert!((position - expected).abs() < 1e-12, "{part} {slopes:?}: {position}");
        };
        check(0.3, [1.0, 1.0], 0.3);
        // A parabola, t².
        check(0.25, [0.0, 2.0], 0.5);
        // t³.
        check(0.125, [0.0, 3.0], 0.5);
        // What would turn back rises as slowly, or as fast, as it may.
        check(0.5, [-4.0, -4.0], 0.5);
        check(0.156_25, [-7.0, 0.0], 0.25);
        check(0.875, [9.0, 0.0], 0.5);
    }
}
