//! Where points of the world are in the picture (model §3), in pixels from its upper left corner.

use slabsplat_core::glam::{DVec2, DVec3};
use slabsplat_core::{Camera, ImageDesc, Projection};

/// A camera and the picture that it takes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Screen {
    camera: Camera,
    size: DVec2,
}

/// What is nearer to the eye than this part of the target's distance is not drawn in a perspective view.
const NEAREST: f64 = 1e-4;

impl Screen {
    pub(crate) fn new(camera: &Camera, image: &ImageDesc) -> Self {
        let size = DVec2::new(f64::from(image.width), f64::from(image.height));
        Self { camera: *camera, size }
    }

    /// Width and height.
    pub(crate) fn size(&self) -> DVec2 {
        self.size
    }

    pub(crate) fn is_perspective(&self) -> bool {
        matches!(self.camera.projection(), Projection::Perspective { .. })
    }

    /// How long a unit of the world is as deep as the camera's target.
    pub(crate) fn pixels_per_world(&self) -> f64 {
        self.pixels_per_world_at(self.target_depth())
    }

    /// The direction from the eye to a point, or of all rays.
    pub(crate) fn ray_to(&self, point: DVec3) -> DVec3 {
        if self.is_perspective() { point - self.camera.eye() } else { self.camera.axes().forward }
    }

    /// Steps to the right and upwards in the picture, and away from the eye.
    pub(crate) fn in_view(&self, step: DVec3) -> DVec3 {
        let axes = self.camera.axes();
        DVec3::new(step.dot(axes.right), step.dot(axes.up), step.dot(axes.forward))
    }

    /// A line of the world, as far as it lies before the eye; `None` if none of it does.
    pub(crate) fn line(&self, [from, to]: [DVec3; 2]) -> Option<[DVec2; 2]> {
        let [from, to] = [from, to].map(|point| self.in_view(point - self.camera.eye()));
        let nearest = if self.is_perspective() { NEAREST * self.target_depth() } else { f64::MIN };
        if from.z < nearest && to.z < nearest {
            return None;
        }
        let cut = |end: DVec3, other: DVec3| match nearest <= end.z {
            true => end,
            false => end + (other - end) * ((nearest - end.z) / (other.z - end.z)),
        };
        Some([cut(from, to), cut(to, from)].map(|point| self.pixel(point)))
    }

    /// A point of the world, if it lies before the eye.
    pub(crate) fn point(&self, point: DVec3) -> Option<DVec2> {
        self.line([point, point]).map(|[point, _]| point)
    }

    /// The axis of the world that comes nearest to the camera's up vector, which stays as it goes around.
    pub(crate) fn upright_axis(&self) -> usize {
        let up = self.camera.up().normalize().abs();
        // Of equal ones z, as that is upwards in most worlds.
        let is_least = |axis: &usize| up[*axis] + 1e-9 < up.max_element();
        (0..3).rev().find(|axis| !is_least(axis)).unwrap_or(2)
    }

    fn target_depth(&self) -> f64 {
        self.camera.eye().distance(self.camera.target())
    }

    fn pixels_per_world_at(&self, depth: f64) -> f64 {
        match self.camera.projection() {
            Projection::Orthographic { view_height } => self.size.y / view_height,
            Projection::Perspective { fov_y_radians } => {
                self.size.y / (2.0 * (0.5 * fov_y_radians).tan() * depth)
            }
        }
    }

    /// Of a point by its steps from the eye.
    fn pixel(&self, in_view: DVec3) -> DVec2 {
        let from_middle = DVec2::new(in_view.x, -in_view.y) * self.pixels_per_world_at(in_view.z);
        0.5 * self.size + from_middle
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::{Grid, View};

    /// Backends project by the view of a grid.
    #[test]
    fn screen_is_where_backends_draw() {
        let grid = Grid::centered([9, 9, 9], [1.0; 3]).unwrap();
        let image = ImageDesc::new(60, 40);
        for projection in [
            Projection::Orthographic { view_height: 20.0 },
            Projection::Perspective { fov_y_radians: 0.6 },
        ] {
            let camera = Camera::new([30.0, 20.0, 10.0], [1.0, 2.0, 0.0], DVec3::Z, projection);
            let camera = camera.unwrap();
            let (screen, view) =
                (Screen::new(&camera, &image), View::new(&grid, &camera, &image).unwrap());
            for pixel in [[0.0, 0.0], [60.0, 13.0], [31.0, 40.0]] {
                let ray = view.ray(pixel);
                for depth in [-3.0, 4.0] {
                    let point = view.world_from_view(ray.start + ray.step * depth);
                    let found = screen.point(point).unwrap();
                    assert!(found.distance(DVec2::from_array(pixel)) < 1e-9, "{found} {pixel:?}");
                }
            }
        }
    }

    #[test]
    fn screen_has_nothing_behind_the_eye() {
        let projection = Projection::Perspective { fov_y_radians: 0.6 };
        let camera = Camera::new([10.0, 0.0, 0.0], DVec3::ZERO, DVec3::Z, projection).unwrap();
        let screen = Screen::new(&camera, &ImageDesc::default());
        assert_eq!(screen.point(DVec3::X * 11.0), None);
        let [near, far] =
            screen.line([DVec3::new(20.0, 0.0, 1.0), DVec3::new(0.0, 0.0, 1.0)]).unwrap();
        assert!(near.is_finite() && near.y < far.y && far.y < 256.0, "{near} {far}");
    }
}
