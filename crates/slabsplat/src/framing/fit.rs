//! Where a camera has to be so that a picture is filled.

use slabsplat_core::glam::DVec3;
use slabsplat_core::{Camera, CameraError, ImageDesc, Projection};

use super::silhouette::{Axes, Seen};

/// The part of a picture that what is seen fills: how far from the picture's middle to the left, the right,
/// the lower and the upper edge it may reach, in parts of half of the picture's width and height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Window {
    x: [f64; 2],
    y: [f64; 2],
}

/// The share of a picture's side that what is seen fills if nothing else is to be there.
const FILLED: f64 = 0.95;

/// The least share that is left of it by what is beside a thing that turns.
const LEAST: f64 = 0.4;

impl Default for Window {
    fn default() -> Self {
        Self { x: [FILLED; 2], y: [FILLED; 2] }
    }
}

impl Window {
    /// That of a picture at whose edges something else takes parts of its width, at the left and the right,
    /// and of its height, at the bottom and the top.
    #[cfg(all(feature = "annotations", feature = "files"))]
    pub(crate) fn without(x: [f64; 2], y: [f64; 2]) -> Self {
        let reach = |parts: [f64; 2]| parts.map(|part| FILLED - 2.0 * part);
        Self { x: reach(x), y: reach(y) }
    }

    /// The largest with the picture's middle in its own, but no smaller than what is worth looking at: then
    /// it is not all within this one.
    fn about_middle(self) -> [f64; 2] {
        [self.x, self.y].map(|[a, b]| a.min(b).max(LEAST))
    }
}

/// How far an orthographic camera is from the middle, in sizes of what is seen: nothing is before it, also
/// when it turns.
const DISTANCE: f64 = 3.0;

/// A camera looking along `to_eye` backwards, that has all of `seen` in its picture.
///
/// An orthographic one fits the box around it. In a perspective view each of the four sides of the window is
/// a plane through the eye; the eye is as near as all four allow.
///
/// # Errors
/// If numbers do not suffice.
pub(super) fn fitting(
    seen: &[Seen],
    [right, up, forward]: [DVec3; 3],
    world_up: DVec3,
    projection: Projection,
    (image, window): (&ImageDesc, Window),
) -> Result<Camera, CameraError> {
    let nothing = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    let [min, max] = seen.iter().fold(nothing, |[min, max], seen| {
        [min.min(seen.middle - seen.reach), max.max(seen.middle + seen.reach)]
    });
    let middle = min.midpoint(max);
    let size = max - min;
    let aspect = f64::from(image.width) / f64::from(image.height);
    let in_world = |v: DVec3| right * v.x + up * v.y + forward * v.z;
    let (eye, target, projection) = match projection {
        Projection::Orthographic { .. } => {
            let sum = |[a, b]: [f64; 2]| a + b;
            let view_height = 2.0 * (size.y / sum(window.y)).max(size.x / aspect / sum(window.x));
            // The middle of the window is not that of the picture.
            let shift = |[a, b]: [f64; 2]| 0.25 * (b - a) * view_height;
            let target = middle - DVec3::new(shift(window.x) * aspect, shift(window.y), 0.0);
            let eye = target - DVec3::Z * (DISTANCE * size.length());
            (eye, target, Projection::Orthographic { view_height })
        }
        Projection::Perspective { fov_y_radians } => {
            let slope = (0.5 * fov_y_radians).tan();
            let x = Planes::around(seen, 0, window.x.map(|part| part * slope * aspect));
            let y = Planes::around(seen, 1, window.y.map(|part| part * slope));
            let z = x.depth().min(y.depth());
            let eye = DVec3::new(x.between_at(z), y.between_at(z), z);
            (eye, DVec3::new(eye.x, eye.y, middle.z.max(eye.z + 0.5 * size.z)), projection)
        }
    };
    Camera::new(in_world(eye), in_world(target), world_up, projection)
}

/// The camera moved so that the pictures of all `views`, which turn with it about its target, hold what each
/// of them sees. It looks in the same direction, at the middle of it all, which is in the middle of the
/// picture.
///
/// # Errors
/// If numbers do not suffice.
pub(super) fn around(
    camera: &Camera,
    views: &[(Axes, Vec<Seen>)],
    (image, window): (&ImageDesc, Window),
) -> Result<Camera, CameraError> {
    let [wide, high] = window.about_middle();
    let target = middle_of(camera, views);
    let aspect = f64::from(image.width) / f64::from(image.height);
    let forward = camera.axes().forward;
    let of_all = |needed: &dyn Fn(DVec3, DVec3) -> f64| {
        let of_view = |(axes, seen): &(Axes, Vec<Seen>)| {
            let middle = DVec3::from_array(axes.map(|axis| axis.dot(target)));
            let needed = seen.iter().map(|seen| needed(seen.middle - middle, seen.reach));
            needed.fold(f64::NEG_INFINITY, f64::max)
        };
        views.iter().map(of_view).fold(f64::NEG_INFINITY, f64::max)
    };
    let (distance, projection) = match camera.projection() {
        Projection::Orthographic { .. } => {
            let height = |at: DVec3, reach: DVec3| {
                let half = at.abs() + reach;
                2.0 * (half.y / high).max(half.x / aspect / wide)
            };
            let view_height = of_all(&height);
            let size = of_all(&|at, reach| 2.0 * (at.abs() + reach).length());
            (DISTANCE * size, Projection::Orthographic { view_height })
        }
        projection @ Projection::Perspective { fov_y_radians } => {
            let slope = (0.5 * fov_y_radians).tan();
            let distance = |at: DVec3, reach: DVec3| {
                let half = at.abs() + reach;
                (half.y / high).max(half.x / aspect / wide) / slope - (at.z - reach.z)
            };
            (of_all(&distance), projection)
        }
    };
    Camera::new(target - forward * distance, target, camera.up(), projection)
}

/// The middle of the box, along the camera's axes, around what any of the views sees.
fn middle_of(camera: &Camera, views: &[(Axes, Vec<Seen>)]) -> DVec3 {
    let own = camera.axes();
    let own = [own.right, own.up, own.forward];
    let along = |[right, up, forward]: Axes, v: DVec3| right * v.x + up * v.y + forward * v.z;
    let nothing = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    let [min, max] = views.iter().fold(nothing, |ends, (axes, seen)| {
        seen.iter().fold(ends, |[min, max], seen| {
            let point = along(*axes, seen.middle);
            let at = DVec3::from_array(own.map(|axis| axis.dot(point)));
            [min.min(at), max.max(at)]
        })
    });
    along(own, min.midpoint(max))
}

/// Two planes through an eye, along an axis of the picture, between which all that is seen lies.
struct Planes {
    /// How far the eye is at least to the lesser and to the greater side where its depth is 0; by as much as
    /// its slope more for each unit that it is deeper.
    least: [f64; 2],
    slopes: [f64; 2],
}

impl Planes {
    /// Those of slopes towards the lesser and the greater side.
    fn around(seen: &[Seen], axis: usize, [lesser, greater]: [f64; 2]) -> Self {
        let offset = |sign: f64, slope: f64| {
            let of = |seen: &Seen| {
                sign * seen.middle[axis] + seen.reach[axis] - slope * (seen.middle.z - seen.reach.z)
            };
            seen.iter().map(of).fold(f64::NEG_INFINITY, f64::max)
        };
        Self { least: [offset(-1.0, lesser), offset(1.0, greater)], slopes: [lesser, greater] }
    }

    /// The depth of the nearest eye.
    fn depth(&self) -> f64 {
        -(self.least[0] + self.least[1]) / (self.slopes[0] + self.slopes[1])
    }

    /// Where an eye of that depth is in the middle of where it may be.
    fn between_at(&self, depth: f64) -> f64 {
        let [lesser, greater] = [0, 1].map(|side| self.least[side] + self.slopes[side] * depth);
        0.5 * (greater - lesser)
    }
}
