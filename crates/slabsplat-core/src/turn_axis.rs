//! What a camera goes around in a film.

use crate::choices::named;
use crate::{Camera, ViewAxes};
use glam::DVec3;

/// What a camera goes around, through what it looks at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum TurnAxis {
    /// The camera's up vector.
    #[default]
    Up,
    /// What is to the right in the picture.
    Right,
    /// The world's first axis.
    X,
    /// The world's second axis.
    Y,
    /// The world's third axis.
    Z,
}

named!(TurnAxis { Up = "up", Right = "right", X = "x", Y = "y", Z = "z" });

impl TurnAxis {
    /// The axis in the world, of length 1.
    pub fn direction(self, camera: &Camera) -> DVec3 {
        let ViewAxes { right, .. } = camera.axes();
        match self {
            Self::Up => camera.up().normalize(),
            Self::Right => right,
            Self::X => DVec3::X,
            Self::Y => DVec3::Y,
            Self::Z => DVec3::Z,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Projection;

    #[test]
    fn turn_axis_by_name_and_direction() {
        let view = Projection::Orthographic { view_height: 4.0 };
        let camera = Camera::new([0.0, -9.0, 0.0], [0.0; 3], [0.0, 1.0, 5.0], view).unwrap();
        let [up, right] = ["up", "right"].map(|name| name.parse::<TurnAxis>().unwrap());
        assert_eq!(up.direction(&camera), DVec3::new(0.0, 1.0, 5.0).normalize());
        assert!(right.direction(&camera).abs_diff_eq(DVec3::X, 1e-15));
        assert_eq!(TurnAxis::Y.direction(&camera), DVec3::Y);
        assert!("down".parse::<TurnAxis>().is_err());
    }
}
