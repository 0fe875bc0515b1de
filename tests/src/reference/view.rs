//! Where things are in view space, and what a pixel covers there (model §§1, 5).

use rayon::prelude::*;
use slabsplat_core::glam::DVec3;
use slabsplat_core::{Camera, ImageDesc, Projection, ViewAxes};

/// A camera with its image.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    pub(super) axes: ViewAxes,
    eye: DVec3,
    projection: Projection,
    width: u32,
    height: u32,
}

impl View {
    pub(super) fn new(camera: &Camera, image: &ImageDesc) -> Self {
        Self {
            axes: camera.axes(),
            eye: camera.eye(),
            projection: camera.projection(),
            width: image.width,
            height: image.height,
        }
    }

    /// Right, up and depth of a point, in world units from the eye.
    pub(super) fn view_from_world(&self, point_in_world: DVec3) -> DVec3 {
        let d = point_in_world - self.eye;
        DVec3::new(d.dot(self.axes.right), d.dot(self.axes.up), d.dot(self.axes.forward))
    }

    /// World units that a pixel covers at `depth`.
    pub(super) fn pixel_size(&self, depth: f64) -> f64 {
        match self.projection {
            Projection::Orthographic { view_height } => view_height / f64::from(self.height),
            Projection::Perspective { fov_y_radians } => {
                2.0 * (0.5 * fov_y_radians).tan() * depth / f64::from(self.height)
            }
        }
    }

    /// Pixels in a row.
    pub(super) fn width(&self) -> u32 {
        self.width
    }

    /// Column and row of every pixel, row by row.
    pub(super) fn pixels(&self) -> impl IndexedParallelIterator<Item = [i64; 2]> + use<> {
        let [width, height] = [self.width, self.height].map(|side| side as usize);
        let pixel = move |idx: usize| [idx % width, idx / width].map(|coord| coord as i64);
        (0..width * height).into_par_iter().map(pixel)
    }

    /// Where the rays of column `x` are at `depth`, in world units right of the image's middle.
    pub(super) fn column_in_view(&self, x: u32, depth: f64) -> f64 {
        (f64::from(x) + 0.5 - 0.5 * f64::from(self.width)) * self.pixel_size(depth)
    }

    /// Where the rays of row `y` are at `depth`, in world units above the image's middle.
    pub(super) fn row_in_view(&self, y: u32, depth: f64) -> f64 {
        -(f64::from(y) + 0.5 - 0.5 * f64::from(self.height)) * self.pixel_size(depth)
    }

    /// How far the ray of the image's corner moves sideways per step in depth.
    pub(super) fn steepest_ray(&self) -> f64 {
        match self.projection {
            Projection::Orthographic { .. } => 0.0,
            Projection::Perspective { .. } => {
                0.5 * self.pixel_size(1.0) * f64::from(self.width).hypot(f64::from(self.height))
            }
        }
    }

    /// Where the ray of a pixel is at `depth`, right of and above the image's middle. The pixel may lie
    /// beside the image.
    pub(super) fn ray_in_view(&self, [x, y]: [i64; 2], depth: f64) -> [f64; 2] {
        let from_middle = [
            x as f64 + 0.5 - 0.5 * f64::from(self.width),
            0.5 * f64::from(self.height) - y as f64 - 0.5,
        ];
        from_middle.map(|pixels| pixels * self.pixel_size(depth))
    }

    /// The same in world space.
    pub(super) fn ray_in_world(&self, at: [i64; 2], depth: f64) -> DVec3 {
        self.point_in_world(at.map(|pixel| pixel as f64 + 0.5), depth)
    }

    /// Where the ray through a point of the image is at `depth`, in world space.
    pub(super) fn point_in_world(&self, [x, y]: [f64; 2], depth: f64) -> DVec3 {
        let from_middle = [x - 0.5 * f64::from(self.width), 0.5 * f64::from(self.height) - y];
        let [right, up] = from_middle.map(|pixels| pixels * self.pixel_size(depth));
        let axes = &self.axes;
        self.eye + right * axes.right + up * axes.up + depth * axes.forward
    }

    /// A perspective slab is projected at its middle, so that is what counts; of an orthographic one, all
    /// is drawn if any of it is behind the eye's plane.
    pub(super) fn draws_slab(&self, [front, back]: [f64; 2], unit: f64) -> bool {
        match self.projection {
            Projection::Orthographic { .. } => 0.0 < back,
            Projection::Perspective { .. } => self.near_depth(unit) <= 0.5 * (front + back),
        }
    }

    /// No whole footprint nearer is drawn: the eye's plane, or one `unit` before it in a perspective view.
    pub(super) fn near_depth(&self, unit: f64) -> f64 {
        match self.projection {
            Projection::Orthographic { .. } => 0.0,
            Projection::Perspective { .. } => unit,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view(projection: Projection) -> View {
        let camera = Camera::new(DVec3::Z * 10.0, DVec3::ZERO, DVec3::Y, projection).unwrap();
        View::new(&camera, &ImageDesc::new(40, 20))
    }

    #[test]
    fn view_pixels_of_both_projections_meet_at_target() {
        let fov_y_radians = 2.0 * 0.5_f64.atan();
        let perspective = view(Projection::Perspective { fov_y_radians });
        let orthographic = view(Projection::Orthographic { view_height: 10.0 });
        for (x, y) in [(0, 0), (39, 3), (20, 10)] {
            let right = perspective.column_in_view(x, 10.0) - orthographic.column_in_view(x, 77.0);
            let up = perspective.row_in_view(y, 10.0) - orthographic.row_in_view(y, 77.0);
            assert!(right.abs() < 1e-12 && up.abs() < 1e-12, "{right} {up}");
        }
        assert_eq!(orthographic.column_in_view(0, 0.0), -9.75);
        assert_eq!(orthographic.row_in_view(0, 0.0), 4.75, "row 0 is the top");
    }

    /// Where a ray is in the world, it is in the view.
    #[test]
    fn view_ray_in_world_is_that_in_view() {
        for projection in [
            Projection::Perspective { fov_y_radians: 0.8 },
            Projection::Orthographic { view_height: 10.0 },
        ] {
            let camera = Camera::new(DVec3::new(3.0, -7.0, 5.0), DVec3::ONE, DVec3::Y, projection);
            let image = ImageDesc::new(40, 20);
            let view = View::new(&camera.expect("up is not forward"), &image);
            for (at, depth) in [([0, 0], 3.0), ([39, 4], 0.0), ([-1, 20], 11.0)] {
                let [right, up] = view.ray_in_view(at, depth);
                let point = view.view_from_world(view.ray_in_world(at, depth));
                assert!(point.abs_diff_eq(DVec3::new(right, up, depth), 1e-12), "{point}");
            }
        }
    }

    #[test]
    fn view_depth_is_along_forward() {
        let view = view(Projection::Orthographic { view_height: 10.0 });
        let point = view.view_from_world(DVec3::new(1.0, 2.0, 3.0));
        assert_eq!(point, DVec3::new(1.0, 2.0, 7.0));
    }
}
