//! The scenes behind the paper's figures and the model's numbers: a binary cube and a single voxel.
//!
//! The paper leaves much of its set-up unsaid. What it does not say is decided here, and is what the numbers
//! of [model §§2–4](crate::model) were taken with.

use slabsplat_core::glam::DVec3;
use slabsplat_core::{
    Camera, Grid, ImageDesc, Layer, Method, Mode, Normalization, Phong, Projection, RenderSettings,
    Samples, Scaling, Scene, Shading, TransferFunction, Volume,
};

/// How to look at the cube of figures 2, 6 and 7.
#[derive(Clone, Debug, PartialEq)]
#[expect(clippy::exhaustive_structs, reason = "the paper has no more of these scenes")]
pub struct CubeView {
    /// How far the camera is turned about the vertical axis; at 0 it sees one face alone.
    pub angle_degrees: f64,
    /// Opacity of the cube's voxels. The figures have 1, model §3's table of brightness ½.
    pub opacity: f64,
    /// `k_a` of the white cube, whose `k_d` is the rest of 1. The figures have 0, the table 0.1.
    pub ambient: f64,
    /// How it is rendered.
    pub settings: RenderSettings,
}

/// Voxels along a side of the volume.
pub const CUBE_GRID: usize = 28;

/// The cube's first and last voxel along each axis.
pub const CUBE_EXTENT: [usize; 2] = [6, 21];

/// Pixels along a voxel step of the cube. At 45° a face is then 34 pixels wide and 48 high, both to
/// within a tenth of a pixel.
pub const CUBE_PIXELS_PER_VOXEL: f64 = 3.2;

/// Pixels along a side of the cube's picture.
pub const CUBE_IMAGE_SIDE: u32 = 90;

/// Width and height in pixels of a face seen at 45°, from the centres of its first voxels to those
/// of its last.
pub const FACE_PIXELS: [u32; 2] = [34, 48];

/// Pixels along a voxel step of the single voxel: 65 pixels span 9 steps. The model's sums
/// over the image are sums over these pixels.
pub const VOXEL_PIXELS_PER_VOXEL: f64 = 65.0 / 9.0;

/// The settings of the paper: its kernel, slabs of one voxel step, `separate`, and every section drawn.
pub fn settings() -> RenderSettings {
    RenderSettings::default()
        .method(Method::ImageAligned)
        .slab_width(1.0)
        .mode(Mode::Separate)
        .normalization(Normalization::None)
        .opacity_cutoff(1.0)
        .tolerance(0.0)
}

/// The binary cube: 255 inside, 0 outside, 16 of 28 voxels a side, lit by a diffuse headlight.
pub fn cube(view: &CubeView) -> Scene {
    let grid = Grid::with_spacing([CUBE_GRID; 3], [1.0; 3]).expect("the grid is not empty");
    let [first, last] = CUBE_EXTENT;
    let is_inside = |c: usize| first <= c && c <= last;
    let value = |i: usize| if grid.voxel_coords(i).into_iter().all(is_inside) { 255 } else { 0 };
    let samples = Samples::U8((0..grid.n_voxels()).map(value).collect());
    let volume = Volume::new(grid, samples, Scaling::IDENTITY).expect("one sample a voxel");

    let headlight = Phong::default()
        .ambient(view.ambient)
        .diffuse(1.0 - view.ambient)
        .zero_gradient(0.0)
        .specular(0.0)
        .shininess(1.0)
        .two_sided(false);
    let view_height = f64::from(CUBE_IMAGE_SIDE) / CUBE_PIXELS_PER_VOXEL;
    let layer = Layer::new(volume, white(view.opacity)).shading(Shading::Phong(headlight));
    Scene::new(layer, orthographic(&grid, view.angle_degrees, view_height))
        .image(square_image(CUBE_IMAGE_SIDE))
        .settings(view.settings.clone())
}

/// One white voxel of opacity ½ (`paper`'s and `product`'s α), unshaded, in the middle of a picture
/// of 65 × 65 pixels.
pub fn single_voxel(settings: RenderSettings) -> Scene {
    let grid = Grid::with_spacing([1; 3], [1.0; 3]).expect("the grid is not empty");
    let volume = Volume::new(grid, Samples::U8(vec![255]), Scaling::IDENTITY)
        .expect("one sample, one voxel");
    let layer = Layer::new(volume, white(0.5)).shading(Shading::None);
    Scene::new(layer, orthographic(&grid, 0.0, 65.0 / VOXEL_PIXELS_PER_VOXEL))
        .image(square_image(65))
        .settings(settings)
}

/// White, and of opacity 0 at value 0 and `opacity` at 255.
fn white(opacity: f64) -> TransferFunction {
    let points = vec![(0.0, [0.0]), (255.0, [opacity])];
    TransferFunction::new(points, vec![(0.0, [1.0; 3])]).expect("an opacity lies within 0 to 1")
}

fn orthographic(grid: &Grid, angle_degrees: f64, view_height: f64) -> Camera {
    let target = grid.center_in_world();
    let projection = Projection::Orthographic { view_height };
    let camera = Camera::new(target + 100.0 * DVec3::Z, target, DVec3::Y, projection);
    camera.expect("the view is level").orbited(angle_degrees.to_radians())
}

fn square_image(side: u32) -> ImageDesc {
    ImageDesc::new(side, side)
}
