//! Where a density that goes from one node to the next passes a value (model §12).
//!
//! ```text
//! d(t) = d₀ + Δ·(t + t(1 − t)·((1 − t)·(a₀ − 1) − t·(a₁ − 1))),   Δ = d₁ − d₀
//! ```
//!
//! With slopes `a` of 0 to 3 that rises from 0 to 1 without turning back (Fritsch & Carlson, "Monotone
//! Piecewise Cubic Interpolation", SIAM J. Numer. Anal. 17(2), 1980), so that it passes each value once, and
//! several values in their order.

/// The way of a density between two nodes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Way {
    start: f64,
    change: f64,
    /// `a₀ − 1` and `a₁ − 1`.
    bends: [f64; 2],
}

/// Steps of Newton's method that converge, or of halving, which would need as many.
const MOST_STEPS: usize = 24;

/// How exact positions are.
const EXACT: f64 = 1e-6;

impl Way {
    /// From one density to another, with those slopes per sheet at both.
    pub(super) fn new([start, end]: [f32; 2], slopes: [f32; 2]) -> Self {
        let [start, end] = [start, end].map(f64::from);
        let change = end - start;
        let bends = slopes.map(|slope| (f64::from(slope) / change).clamp(0.0, 3.0) - 1.0);
        Self { start, change, bends }
    }

    /// The position, from 0 to 1, at which it passes a value between its ends.
    pub(super) fn position_of(&self, value: f32) -> f32 {
        let part = ((f64::from(value) - self.start) / self.change).clamp(0.0, 1.0);
        let [mut least, mut most] = [0.0, 1.0];
        let mut position = part;
        for _ in 0..MOST_STEPS {
            let [risen, slope] = self.risen(position);
            if risen < part {
                least = position;
            } else {
                most = position;
            }
            let next = position + (part - risen) / slope;
            let next = if least < next && next < most { next } else { 0.5 * (least + most) };
            let step = (next - position).abs();
            position = next;
            if step < EXACT {
                break;
            }
        }
        position as f32
    }

    /// The part of its change that lies before a position, and the slope of that.
    fn risen(&self, t: f64) -> [f64; 2] {
        let ([p, q], left) = (self.bends, 1.0 - t);
        [
            t + t * left * (left * p - t * q),
            1.0 + p * left * (1.0 - 3.0 * t) - q * t * (2.0 - 3.0 * t),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_seeds::for_each_seed;

    #[test]
    fn crossing_is_where_the_way_has_the_value() {
        for_each_seed(1, |mut rng| {
            for _ in 0..20_000 {
                let number = |rng: &mut fastrand::Rng| 2.0 * rng.f32() - 1.0;
                let ends = [number(&mut rng), number(&mut rng)];
                let steep = [0.0, 0.1, 1.0, 10.0][rng.usize(..4)];
                let way = Way::new(ends, [0; 2].map(|_| steep * number(&mut rng)));
                let t = [rng.f64(), 0.0, 1.0, 1e-5][rng.usize(..4)];
                let [risen, slope] = way.risen(t);
                assert!(-1e-12 <= slope, "{way:?} falls at {t}");
                let value = (way.start + risen * way.change) as f32;
                let position = way.position_of(value);
                let back = way.start + way.risen(position.into())[0] * way.change;
                // A way is at most three times as steep as it is long.
                assert!((back - f64::from(value)).abs() < 8e-6, "{way:?} at {t}: {position}");
            }
        });
    }

    /// Slopes are those of a straight line, or of parabolas and cubics, which it finds again.
    #[test]
    fn crossing_of_a_polynomial() {
        for way in [|t: f64| 3.0 * t - 1.0, |t: f64| t * (1.0 + t), |t: f64| -t * t * t - t] {
            let slope = |t: f64| ((way(t + 1e-4) - way(t - 1e-4)) / 2e-4) as f32;
            let ends = [0.0, 1.0].map(|t| way(t) as f32);
            for t in [0.1, 0.5, 0.8] {
                let position = Way::new(ends, [slope(0.0), slope(1.0)]).position_of(way(t) as f32);
                assert!((f64::from(position) - t).abs() < 1e-5, "{t}: {position}");
            }
        }
    }

    /// A density that hardly changes, or of which slopes say nothing.
    #[test]
    fn crossing_lies_between_its_ends() {
        let least = f32::MIN_POSITIVE;
        for ends in [[0.0, least], [1.0, 1.0 + f32::EPSILON], [-1.0, 1.0], [0.5, -0.5]] {
            for slope in [0.0, least, -1e30, 1e30, f32::INFINITY] {
                for value in ends {
                    let position = Way::new(ends, [slope; 2]).position_of(value);
                    assert!(
                        (0.0..=1.0).contains(&position),
                        "{ends:?} {slope} {value}: {position}"
                    );
                }
            }
        }
    }
}
