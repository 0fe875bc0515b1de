//! Vectors that have length 1 already.

use glam::DVec3;

/// How far the square of a length may be from 1 after a vector was made one of length 1: twice the rounding
/// of its division by its largest component, its length, and the division by that.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Whether the vector has length 1 but for rounding. Such a one is left as it is, so that directions are the
/// same bits when they are written and read.
pub(crate) fn is_unit(vector: DVec3) -> bool {
    (vector.length_squared() - 1.0).abs() <= ROUNDING
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Light, Plane};

    /// Many directions, some of them nearly along an axis.
    fn directions() -> impl Iterator<Item = DVec3> {
        (1..2000_i32).map(|n| {
            let x = f64::from(n);
            DVec3::new((0.7 * x).sin(), (1.3 * x).cos(), (0.1 * x).sin() * 1e-3) * (0.1 + x)
        })
    }

    #[test]
    fn unit_vectors_stay_as_they_are() {
        for direction in directions() {
            let light = Light::towards(direction).unwrap();
            let crate::LightSource::Direction(towards) = light.source else { panic!("{light:?}") };
            assert_eq!(Light::towards(towards.get()).unwrap(), light, "{direction}");
            let plane = Plane::new(direction, 3.25).unwrap();
            assert_eq!(Plane::new(plane.normal(), plane.distance()).unwrap(), plane, "{direction}");
        }
    }
}
