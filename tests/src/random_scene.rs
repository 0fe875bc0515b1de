//! Scenes at random: small volumes under every choice that a scene can make, one of them or several.
//!
//! They are meant to be ugly: noisy values next to smooth ones, NaN and infinite voxels, slab widths
//! that fit nothing, eyes inside the volume, volumes shrunk to a few pixels. What is left out is what
//! no tolerance can hold, because it depends on the last bit: slices that tie for the method
//! `axis-aligned`, and transfer functions with steps.

mod camera;
mod grid;
mod labels;
mod mesh;
mod region;
mod transfer_2d;
mod volume;

use crate::exact_settings;
use fastrand::Rng;
use slabsplat_core::glam::DVec3;
use slabsplat_core::{
    ColorSamples, Compositing, Grid, ImageDesc, KernelName, Layer, Light, LightSource, Method,
    Normalization, Phong, PiecewiseLinear, Scene, Shading, TransferFunction, Volume, VoxelColors,
};

pub use grid::GridKind;

/// What is not left to chance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SceneKind {
    /// What is added and what is composited.
    pub method: Method,
    /// `gaussian` or `crawfis-max`.
    pub kernel: &'static str,
    /// How sheets become pixels.
    pub compositing: Compositing,
    /// How thick sections are darkened.
    pub normalization: Normalization,
    /// How depth changes size.
    pub projection: ProjectionKind,
    /// How the grid lies in the world.
    pub grid: GridKind,
}

/// How depth changes size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProjectionKind {
    /// It does not.
    Orthographic,
    /// Rays leave the eye, which may be inside the volume.
    Perspective,
}

/// The kernels of model §2.
pub const KERNELS: [&str; 2] = ["gaussian", "crawfis-max"];

/// The slab widths drawn from: thinner than the base, between levels, on levels, and wide.
pub const SLAB_WIDTHS: [f64; 8] = [0.3, 0.5, 0.77, 1.0, 1.6, 2.0, 3.3, 50.0];

impl SceneKind {
    /// How many seeds it takes until each kind had its turn.
    pub const SHARES: u64 = 7;

    /// Every combination whose turn it is with a seed: a seventh of those that [`all`](Self::all) lists, each
    /// with another neighbour in methods, kernels and grids.
    pub fn share(seed: u64) -> impl Iterator<Item = Self> {
        let first = (seed % Self::SHARES) as usize;
        Self::all().into_iter().skip(first).step_by(Self::SHARES as usize)
    }

    /// Every combination. Only `image-aligned` knows normalisation, so the others come with none.
    pub fn all() -> Vec<Self> {
        let mut kinds = Vec::new();
        for &method in Method::ALL {
            for kernel in KERNELS {
                for &compositing in Compositing::ALL {
                    for &normalization in normalizations_of(method) {
                        for projection in
                            [ProjectionKind::Orthographic, ProjectionKind::Perspective]
                        {
                            kinds.extend(GridKind::ALL.map(|grid| Self {
                                method,
                                kernel,
                                compositing,
                                normalization,
                                projection,
                                grid,
                            }));
                        }
                    }
                }
            }
        }
        kinds
    }
}

fn normalizations_of(method: Method) -> &'static [Normalization] {
    match method {
        Method::ImageAligned => Normalization::ALL,
        Method::AxisAligned | Method::EverySample | Method::PostClassified => {
            &[Normalization::None]
        }
    }
}

/// A volume of 5 to 9 voxels a side in a picture of 20 to 32 pixels a side.
pub fn random_scene(rng: &mut Rng, kind: &SceneKind) -> Scene {
    let grid = grid::random_grid(rng, kind.grid);
    let (volume, value_range) = volume::random_volume(rng, grid);
    let image = ImageDesc::new(rng.u32(20..=32), rng.u32(20..=32)).background(if rng.bool() {
        [0.0; 4]
    } else {
        [0; 4].map(|_| rng.f32())
    });
    let layer = random_layer(rng, kind.method, volume, value_range);
    let camera = camera::random_camera(rng, &grid, kind.projection, image.height);
    let settings = exact_settings()
        .method(kind.method)
        .kernel(KernelName(kind.kernel.into()))
        .slab_width(SLAB_WIDTHS[rng.usize(..SLAB_WIDTHS.len())])
        .mode(kind.compositing.into())
        .normalization(kind.normalization)
        .base_slab_width([0.5, 0.5, 0.4][rng.usize(..3)]);
    let lights = vec![random_light(rng)];
    let mut scene = Scene::new(layer, camera).lights(lights).image(image).settings(settings);
    without_a_jump(&mut scene);
    scene
}

/// The same with up to two layers more, if the method draws more than one, on grids of any kind that overlap
/// the first and whose steps differ by up to a factor of 3. Regions cut most of them.
pub fn random_layers(rng: &mut Rng, kind: &SceneKind) -> Scene {
    let mut scene = random_scene(rng, kind);
    let n_more = if kind.method == Method::ImageAligned { rng.usize(..=2) } else { 0 };
    add_layers(rng, &mut scene, n_more);
    scene
}

/// The same with one or two layers more, whatever the method.
pub fn random_several_layers(rng: &mut Rng, kind: &SceneKind) -> Scene {
    let mut scene = random_scene(rng, kind);
    let n_more = rng.usize(1..=2);
    add_layers(rng, &mut scene, n_more);
    without_a_jump(&mut scene);
    scene
}

/// Adds so many around the first, and cuts most of all.
fn add_layers(rng: &mut Rng, scene: &mut Scene, n_more: usize) {
    let first = *scene.layers[0].volume.grid();
    for _ in 0..n_more {
        let grid = grid::random_grid_around(rng, &first);
        let (volume, value_range) = volume::random_volume(rng, grid);
        scene.layers.push(random_layer(rng, scene.settings.method, volume, value_range));
    }
    let axes = scene.camera.axes();
    for layer in &mut scene.layers {
        if rng.u32(..4) != 0 {
            layer.region =
                region::random_region(rng, &axes, first.center_in_world(), radius(&first));
        }
    }
}

/// Makes opacities of some layers depend on gradients, which are as steep as values are far apart.
pub fn add_gradient_opacity(rng: &mut Rng, scene: &mut Scene) {
    for layer in &mut scene.layers {
        if rng.u32(..4) == 0 {
            continue;
        }
        let [lo, hi] = layer.volume.summary().range.unwrap_or([0.0, 1.0]);
        let steepest = if (hi - lo).is_finite() { hi - lo } else { 1.0 };
        let mut at: Vec<f64> = (0..rng.usize(1..4)).map(|_| steepest * rng.f64()).collect();
        at.sort_by(f64::total_cmp);
        let factor = at
            .into_iter()
            .map(|x| (x, [[0.0, 1.0, rng.f64()][rng.usize(..3)]]))
            .collect::<Vec<_>>();
        let factor = PiecewiseLinear::new("factor", factor).expect("sorted points within 0 to 1");
        layer.gradient_opacity = Some(factor);
    }
}

/// Makes values and gradients decide together in some layers: in boxes that overlap, or as a picture says.
pub fn add_transfer_2d(rng: &mut Rng, scene: &mut Scene) {
    for layer in &mut scene.layers {
        if rng.u32(..4) != 0 {
            let [lo, hi] = layer.volume.summary().range.unwrap_or([0.0, 1.0]);
            layer.transfer_2d = Some(transfer_2d::random_transfer_2d(rng, [lo, hi]));
        }
    }
}

/// Gives the voxels of most layers colours of their own, of 8 or 16 bits.
pub fn add_colors(rng: &mut Rng, scene: &mut Scene) {
    for layer in &mut scene.layers {
        if rng.u32(..4) == 0 {
            continue;
        }
        let grid = layer.volume.grid();
        let voxels = 0..grid.n_voxels();
        let samples = if rng.bool() {
            ColorSamples::U8(voxels.map(|_| [0; 3].map(|_| rng.u8(..))).collect())
        } else {
            ColorSamples::U16(voxels.map(|_| [0; 3].map(|_| rng.u16(..))).collect())
        };
        let colors = VoxelColors::new(grid.dims(), samples).expect("there is one for each voxel");
        layer.colors = Some(colors);
    }
}

/// Gives the voxels of each layer labels, from a volume of its own grid or of another around it.
pub fn add_labels(rng: &mut Rng, scene: &mut Scene) {
    for layer in &mut scene.layers {
        let grid = *layer.volume.grid();
        let of_labels = if rng.bool() { grid } else { grid::random_grid_around(rng, &grid) };
        let volume = labels::random_label_volume(rng, of_labels);
        let values = layer.transfer.positions();
        let (lo, hi) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), value| {
            (value.min(lo), value.max(hi))
        });
        layer.labels = Some(labels::random_labels(rng, &volume, &grid, [lo, hi]));
    }
}

/// The same with opaque meshes among them, where the method has any.
pub fn random_meshes(rng: &mut Rng, kind: &SceneKind) -> Scene {
    let mut scene = random_layers(rng, kind);
    let first = *scene.layers[0].volume.grid();
    let axes = scene.camera.axes();
    scene.meshes = mesh::random_meshes(rng, &axes, first.center_in_world(), radius(&first));
    scene
}

fn random_layer(rng: &mut Rng, method: Method, volume: Volume, value_range: [f64; 2]) -> Layer {
    let transfer = if method == Method::PostClassified {
        gentle_transfer(rng, value_range)
    } else {
        random_transfer(rng, value_range)
    };
    Layer::new(volume, transfer).shading(random_shading(rng))
}

/// The radius of a sphere about the centres of the grid's voxels.
fn radius(grid: &Grid) -> f64 {
    let center = grid.center_in_world();
    grid.corners_in_world().map(|corner| corner.distance(center)).fold(grid.unit(), f64::max)
}

/// A number between `lo` and `hi`.
fn between(rng: &mut Rng, lo: f64, hi: f64) -> f64 {
    lo + (hi - lo) * rng.f64()
}

/// A direction, any as likely as any other.
fn random_direction(rng: &mut Rng) -> DVec3 {
    loop {
        let v = DVec3::from_array([0; 3].map(|_| between(rng, -1.0, 1.0)));
        if 0.01 < v.length() && v.length() < 1.0 {
            return v.normalize();
        }
    }
}

fn random_transfer(rng: &mut Rng, [lo, hi]: [f64; 2]) -> TransferFunction {
    let positions = |rng: &mut Rng| {
        let n_points = rng.usize(1..=4);
        let mut positions: Vec<f64> = (0..n_points).map(|_| between(rng, lo, hi)).collect();
        positions.sort_by(f64::total_cmp);
        positions
    };
    let densest = [0.1, 0.6, 1.0][rng.usize(..3)];
    let opacity = |rng: &mut Rng| if rng.u32(..4) == 0 { 0.0 } else { densest * rng.f64() };
    let mut opacities: Vec<_> = positions(rng).into_iter().map(|x| (x, [opacity(rng)])).collect();
    // Something is always to be seen, and now and then it is as opaque as can be.
    let peak = rng.usize(..opacities.len());
    opacities[peak].1 = [densest];
    let colors =
        positions(rng).into_iter().map(|x| (x, [0; 3].map(|_| rng.f64()))).collect::<Vec<_>>();
    TransferFunction::new(opacities, colors).expect("sorted points within 0 to 1")
}

/// A function of bounded slope, as a pixel that is classified is as sensitive to its density as that slope is
/// steep (model §8).
fn gentle_transfer(rng: &mut Rng, [lo, hi]: [f64; 2]) -> TransferFunction {
    let positions = |rng: &mut Rng| {
        let first = between(rng, 0.0, 0.3);
        let step = between(rng, 0.2, 0.4);
        let n_points = rng.usize(1..=4);
        (0..n_points).map(|i| lo + (hi - lo) * (first + step * i as f64)).collect::<Vec<_>>()
    };
    let densest = [0.1, 0.6, 0.95][rng.usize(..3)];
    let opacity = |rng: &mut Rng| if rng.u32(..3) == 0 { 0.0 } else { densest * rng.f64() };
    let mut opacities: Vec<_> = positions(rng).into_iter().map(|x| (x, [opacity(rng)])).collect();
    let peak = rng.usize(..opacities.len());
    opacities[peak].1 = [densest];
    let colors =
        positions(rng).into_iter().map(|x| (x, [0; 3].map(|_| rng.f64()))).collect::<Vec<_>>();
    TransferFunction::new(opacities, colors).expect("sorted points within 0 to 1")
}

/// Where a surface turns away from a light, a highlight may end all at once. Once a voxel that is harmless; a
/// pixel would be on either side.
fn without_a_jump(scene: &mut Scene) {
    let is_pixelwise = scene.settings.method == Method::PostClassified;
    if is_pixelwise && scene.lights.iter().any(|light| light.source != LightSource::Headlight) {
        for layer in &mut scene.layers {
            if let Shading::Phong(phong) = &mut layer.shading {
                phong.two_sided = true;
            }
        }
    }
}

fn random_light(rng: &mut Rng) -> Light {
    if rng.bool() {
        return Light::default();
    }
    Light::towards(random_direction(rng)).expect("the direction is not zero")
}

/// Up to four lights in any colours.
pub fn add_lights(rng: &mut Rng, scene: &mut Scene) {
    let brightest = [0.3, 1.0][rng.usize(..2)];
    let mut light = || random_light(rng).color([0; 3].map(|_| brightest * rng.f64()));
    scene.lights = (0..4).map(|_| light()).collect();
    scene.lights.truncate(rng.usize(..=4));
    without_a_jump(scene);
}

fn random_shading(rng: &mut Rng) -> Shading {
    if rng.u32(..4) == 0 {
        return Shading::None;
    }
    let phong = Phong::default()
        .ambient(between(rng, 0.0, 0.4))
        .diffuse(between(rng, 0.2, 1.0))
        .specular(between(rng, 0.0, 0.5))
        .zero_gradient(between(rng, 0.0, 1.0))
        .shininess(between(rng, 1.0, 40.0))
        .two_sided(rng.bool());
    Shading::Phong(phong)
}

/// Balls of even stuff and of noise, and nothing between them, on up to 150³ voxels: where a pixel covers
/// more than ten voxels, some bricks are drawn by the coarsest cells and others by what is finer (model §16).
pub fn layer_of_all_levels(rng: &mut Rng) -> Layer {
    let dims = [0; 3].map(|_| rng.usize(72..150));
    let grid = Grid::centered(dims, [0; 3].map(|_| between(rng, 0.8, 1.2)));
    let balls = [0; 6].map(|_| {
        let middle = DVec3::from_array(dims.map(|n| rng.f64() * n as f64));
        (middle, between(rng, 12.0, 42.0), rng.u8(..3) == 0)
    });
    let volume = Volume::from_fn(grid.expect("its steps are positive"), |at| {
        let at = DVec3::from_array(at.map(|at| at as f64));
        let ball = balls.iter().find(|(middle, radius, _)| middle.distance(at) < *radius);
        ball.map_or(0, |(.., is_even)| if *is_even { 100 } else { 200 * rng.u8(..2) })
    });
    let opacity = [0.05, 0.4, 0.9][rng.usize(..3)];
    let transfer = TransferFunction::new(
        vec![(0.0, [0.0]), (100.0, [opacity])],
        vec![(0.0, [0.9, 0.1, 0.2]), (200.0, [0.1, 0.5, 0.9])],
    );
    Layer::new(volume, transfer.expect("the points rise"))
}
