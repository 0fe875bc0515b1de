//! A nerve cell: a stand-in for the paper's, which is not public. Sparse and thin, it is the test of
//! fine structures that most of the volume's voxels have no part in.
//!
//! It grows by rules that real pyramidal cells suggest: a cell body, a thick apical dendrite upwards
//! that ends in a tuft, basal dendrites around, and a thin axon downwards. Branches wander, taper
//! and split; the widths at a split obey Rall's law (d^3/2 is conserved). No sines or powers are
//! taken, so that the cell is the same on every machine.

use slabsplat_core::Samples;
use slabsplat_core::glam::DVec3;

use super::{smoothstep, to_byte};

/// Of the many cells tried, one that fills its box well.
const SEED: u64 = 1998;

/// Width of the soft edge in voxels.
const EDGE: f64 = 2.5;

/// Length of one straight piece; the cell lies in the ball of radius 1.
const STEP: f64 = 0.028;

/// The thinnest that a branch becomes.
const MIN_RADIUS: f64 = 0.0095;

/// 0.5^(2/3): the width of either branch after an even split, by Rall's law.
const SPLIT: f64 = 0.63;

/// A piece of a branch: a cone with round ends.
struct Piece {
    ends: [DVec3; 2],
    radii: [f64; 2],
}

/// The growing end of a branch, and how it grows.
#[derive(Clone, Copy)]
struct Tip {
    at: DVec3,
    direction: DVec3,
    radius: f64,
    /// Splits still to come.
    n_splits: u32,
    n_steps: u32,
    /// How far a step strays from the one before it.
    wander: f64,
    /// How much a step tends towards the direction that the branch began with.
    purpose: f64,
}

pub(super) fn samples(size: usize) -> Samples {
    let half_side = size as f64 / 2.0;
    let mut samples = vec![0_u8; size.pow(3)];
    for Piece { ends, radii } in grown_cell() {
        let ends = ends.map(|end| end * half_side + (half_side - 0.5));
        draw(&mut samples, size, &Piece { ends, radii: radii.map(|r| r * half_side) });
    }
    Samples::U8(samples)
}

fn grown_cell() -> Vec<Piece> {
    let mut rng = SplitMix64(SEED);
    let mut pieces = body();
    for tip in first_tips(&mut rng) {
        grow(tip, &mut rng, &mut pieces);
    }
    pieces
}

/// A pear, narrow end up.
fn body() -> Vec<Piece> {
    let piece = |z: [f64; 2], radii| Piece { ends: z.map(|z| DVec3::Z * z), radii };
    vec![piece([-0.15, -0.02], [0.125, 0.11]), piece([-0.02, 0.16], [0.11, 0.05])]
}

fn first_tips(rng: &mut SplitMix64) -> Vec<Tip> {
    let dendrite = Tip {
        at: DVec3::ZERO,
        direction: DVec3::Z,
        radius: 0.042,
        n_splits: 4,
        n_steps: 6,
        wander: 0.3,
        purpose: 0.1,
    };
    let apical = Tip { at: DVec3::Z * 0.15, radius: 0.052, n_steps: 10, n_splits: 5, ..dendrite };
    let axon = Tip {
        at: DVec3::Z * -0.22,
        direction: -DVec3::Z,
        radius: 0.02,
        n_steps: 14,
        n_splits: 1,
        wander: 0.18,
        ..dendrite
    };
    let mut tips = vec![apical, axon];
    // Seven directions evenly about the waist, like the corners of a heptagon, some down, some up.
    const AROUND: [(f64, f64, f64); 7] = [
        (1.00, 0.00, -0.35),
        (0.62, 0.78, 0.30),
        (-0.22, 0.97, -0.55),
        (-0.90, 0.43, 0.10),
        (-0.90, -0.43, -0.60),
        (-0.22, -0.97, 0.25),
        (0.62, -0.78, -0.50),
    ];
    for (x, y, z) in AROUND {
        let direction = (DVec3::new(x, y, z) + 0.2 * rng.in_ball()).normalize();
        let at = DVec3::Z * -0.1 + direction * 0.08;
        tips.push(Tip { at, direction, ..dendrite });
    }
    tips
}

/// Lets a branch wander to its end, then splits it in two.
fn grow(mut tip: Tip, rng: &mut SplitMix64, pieces: &mut Vec<Piece>) {
    let heading = tip.direction;
    for _ in 0..tip.n_steps {
        let stray = tip.wander * rng.in_ball() + tip.purpose * heading;
        tip.direction = (tip.direction + stray).normalize();
        let next = tip.at + tip.direction * STEP;
        let radius = (tip.radius * 0.97).max(MIN_RADIUS);
        if 0.94 < next.length() {
            return;
        }
        pieces.push(Piece { ends: [tip.at, next], radii: [tip.radius, radius] });
        (tip.at, tip.radius) = (next, radius);
    }
    if 0 < tip.n_splits {
        split(tip, rng, pieces);
    }
}

fn split(tip: Tip, rng: &mut SplitMix64, pieces: &mut Vec<Piece>) {
    let aside = tip.direction.cross(rng.in_ball()).try_normalize().unwrap_or(DVec3::X);
    for side in [aside, -aside] {
        let opening = 0.45 + 0.3 * rng.unit();
        let child = Tip {
            direction: (tip.direction + opening * side).normalize(),
            radius: (tip.radius * SPLIT).max(MIN_RADIUS),
            n_splits: tip.n_splits - 1,
            n_steps: 5 + (rng.unit() * 6.0) as u32,
            ..tip
        };
        grow(child, rng, pieces);
    }
}

/// Draws a piece, given in voxels, over what is there: the brighter wins.
fn draw(samples: &mut [u8], size: usize, piece: &Piece) {
    let reach = piece.radii[0].max(piece.radii[1]) + EDGE;
    let lo = (piece.ends[0].min(piece.ends[1]) - reach).max(DVec3::ZERO).ceil();
    let hi = (piece.ends[0].max(piece.ends[1]) + reach).min(DVec3::splat(size as f64 - 1.0));
    let range = |axis: usize| lo[axis] as usize..=hi[axis].max(0.0) as usize;
    for k in range(2) {
        for j in range(1) {
            let row = (k * size + j) * size;
            for i in range(0) {
                let depth = piece.depth_inside(DVec3::new(i as f64, j as f64, k as f64));
                let value = to_byte(smoothstep(0.5 + depth / EDGE));
                samples[row + i] = samples[row + i].max(value);
            }
        }
    }
}

impl Piece {
    /// How deep `point` lies under the surface; negative outside.
    fn depth_inside(&self, point: DVec3) -> f64 {
        let axis = self.ends[1] - self.ends[0];
        let along = (point - self.ends[0]).dot(axis) / axis.length_squared().max(1e-12);
        let along = along.clamp(0.0, 1.0);
        let radius = self.radii[0] + (self.radii[1] - self.radii[0]) * along;
        radius - point.distance(self.ends[0] + axis * along)
    }
}

/// Vigna's SplitMix64: eight lines that will never change under us, as a crate's generator may.
struct SplitMix64(u64);

impl SplitMix64 {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// From 0 up to, but not, 1.
    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A point of the unit ball, each as likely.
    fn in_ball(&mut self) -> DVec3 {
        loop {
            let point = DVec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0;
            if point.length_squared() <= 1.0 {
                return point;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin_volume;

    #[test]
    fn neuron_is_sparse_and_fills_its_box() {
        let volume = builtin_volume("neuron", None).unwrap();
        let grid = volume.grid();
        let set: Vec<usize> = (0..grid.n_voxels()).filter(|&v| 127.0 < volume.value(v)).collect();
        let share = set.len() as f64 / grid.n_voxels() as f64;
        assert!((0.002..0.05).contains(&share), "{share} of the voxels are set");
        for axis in 0..3 {
            let coords = || set.iter().map(|&v| grid.voxel_coords(v)[axis]);
            let (lo, hi) = (coords().min().unwrap(), coords().max().unwrap());
            assert!(70 < hi - lo, "the cell spans only {lo} to {hi} along axis {axis}");
        }
    }

    #[test]
    fn neuron_random_numbers_are_the_published_ones() {
        let mut rng = SplitMix64(1_234_567);
        assert_eq!(rng.next(), 6_457_827_717_110_365_317);
        assert_eq!(rng.next(), 3_203_168_211_198_807_973);
    }
}
