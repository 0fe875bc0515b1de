//! Which way things stand in the world: where their front is, and their top.

use slabsplat_core::glam::DVec3;
use slabsplat_core::{Grid, Orientation, Viewpoint};

/// The front and the top of what is seen, at right angles, and where people look at it from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facing {
    front: DVec3,
    top: DVec3,
    orientation: Orientation,
    /// Whether it is a head, which stands on its neck.
    is_head: bool,
}

/// The elevation from which three axes at right angles look equally long: the sine is 1/√3.
const ISOMETRIC_DEGREES: f64 = 35.264_389_682_754_654;

impl Default for Facing {
    /// That of what nobody knows anything of.
    fn default() -> Self {
        Self {
            front: DVec3::NEG_Y,
            top: DVec3::Z,
            orientation: Orientation::Unknown,
            is_head: false,
        }
    }
}

impl Facing {
    /// That of a volume on `grid`, whose world is as `orientation` says.
    ///
    /// Of an unknown one the front is where y comes from, as in drawings and, mostly, in tables of samples.
    pub fn of(orientation: Orientation, grid: &Grid) -> Self {
        let steps = grid.world_from_index().matrix3;
        // A reader may have turned the world of a file that says nothing (MetaImage counts in LPS).
        let sign = |along: f64| if along < 0.0 { -1.0 } else { 1.0 };
        let (front, top) = match orientation {
            Orientation::Anatomical => (DVec3::Y, DVec3::Z),
            Orientation::Pictures => (DVec3::NEG_Z, DVec3::NEG_Y),
            Orientation::Unknown => {
                (DVec3::NEG_Y * sign(steps.y_axis.y), DVec3::Z * sign(steps.z_axis.z))
            }
        };
        Self { front, top, orientation, is_head: false }
    }

    /// Whether nobody says which way up it is.
    pub(crate) fn is_guessed(&self) -> bool {
        self.orientation == Orientation::Unknown
    }

    /// The same of a head, which stands on the narrower of two ends that are cut.
    pub(crate) fn on_neck(self) -> Self {
        Self { is_head: true, ..self }
    }

    pub(super) fn is_head(&self) -> bool {
        self.is_head
    }

    /// The same the other way up.
    pub(crate) fn upside_down(self) -> Self {
        Self { top: -self.top, ..self }
    }

    /// Where its front is, of length 1.
    pub fn front(&self) -> DVec3 {
        self.front
    }

    /// Where its top is, of length 1.
    pub fn top(&self) -> DVec3 {
        self.top
    }

    /// Towards the eye of who looks from there, of length 1, and what is upwards in the picture.
    pub fn seen_from(&self, viewpoint: Viewpoint) -> [DVec3; 2] {
        let is_body = self.orientation == Orientation::Anatomical;
        // A body's right is on the left of who faces it.
        let right = if is_body { -90.0 } else { 90.0 };
        // The front of a body is upwards in pictures of its top, and of its bottom; that of a drawing is
        // towards who looks.
        let flat = if is_body { self.front } else { -self.front };
        match viewpoint {
            Viewpoint::Front => self.standing_at(0.0, 0.0),
            Viewpoint::Back => self.standing_at(180.0, 0.0),
            Viewpoint::Right => self.standing_at(right, 0.0),
            Viewpoint::Left => self.standing_at(-right, 0.0),
            Viewpoint::Top => [self.top, flat],
            Viewpoint::Bottom => [-self.top, if is_body { flat } else { -flat }],
            Viewpoint::Iso => self.standing_at(45.0, ISOMETRIC_DEGREES),
        }
    }

    /// The same for who has no wish: before it, a little to the side and above.
    pub fn usual(&self) -> [DVec3; 2] {
        match self.orientation {
            Orientation::Anatomical => self.standing_at(30.0, 12.0),
            Orientation::Pictures => self.standing_at(25.0, 20.0),
            Orientation::Unknown => self.standing_at(30.0, 22.0),
        }
    }

    fn standing_at(&self, azimuth_degrees: f64, elevation_degrees: f64) -> [DVec3; 2] {
        let right = (-self.front).cross(self.top);
        let [azimuth, elevation] = [azimuth_degrees, elevation_degrees].map(f64::to_radians);
        let level = self.front * azimuth.cos() + right * azimuth.sin();
        [level * elevation.cos() + self.top * elevation.sin(), self.top]
    }
}
