//! How sharp surfaces are, and whether they are where they belong, by method and kernel: a ball, a wall and a
//! thin shell, whose edges are known, are looked at from all sides, and the opacity across their edges says
//! where they seem to be and how soft.
//!
//! `cargo test --release -p slabsplat-tests --test renderer sharpness -- --nocapture` prints the table of
//! `docs/numerics.md`.

use slabsplat::glam::DVec3;
use slabsplat::{
    Camera, Grid, Image, ImageDesc, KERNEL_NAMES, KernelName, Layer, Method, Projection,
    RenderSettings, Samples, Scaling, Scene, Shading, TransferFunction, Volume,
};

use slabsplat_tests::render::render;
use std::sync::Arc;

/// Voxels along a side of the phantoms.
const N_VOXELS: usize = 56;

/// Pixels to a voxel.
const ZOOM: f64 = 10.0;

/// Where an edge seems to be, in voxels from the middle of the picture, and from where to where opacity is
/// between 90 and 10 % of the most.
#[derive(Clone, Copy, Debug, Default)]
struct Edge {
    position: f64,
    width: f64,
}

/// A volume whose density is a function of the position from the middle, in voxels.
fn phantom(density: impl Fn(DVec3) -> f64) -> Arc<Volume> {
    let grid = Grid::with_spacing([N_VOXELS; 3], [1.0; 3]).expect("the grid is not empty");
    let middle = DVec3::splat(0.5 * (N_VOXELS - 1) as f64);
    let value = |idx: usize| {
        let at = DVec3::from_array(grid.voxel_coords(idx).map(|c| c as f64)) - middle;
        density(at) as f32
    };
    let samples = Samples::F32((0..grid.n_voxels()).map(value).collect());
    Arc::new(Volume::new(grid, samples, Scaling::IDENTITY).expect("one sample a voxel"))
}

/// By what a phantom is looked at.
type Look = (Method, &'static str);

/// A picture in which opacity rises from 0 to 0.9 between the densities 90 and 110.
fn picture(
    volume: &Arc<Volume>,
    (method, kernel): Look,
    from: DVec3,
    up: DVec3,
    reach: f64,
) -> Image {
    let side = (2.0 * (reach + 0.5) * ZOOM) as u32;
    let middle = DVec3::splat(0.5 * (N_VOXELS - 1) as f64);
    let projection = Projection::Orthographic { view_height: f64::from(side) / ZOOM };
    let camera = Camera::new(middle + 200.0 * from, middle, up, projection);
    let opacity = vec![(90.0, [0.0]), (110.0, [0.9])];
    let transfer = TransferFunction::new(opacity, vec![(0.0, [1.0; 3])]).expect("it rises");
    let settings = RenderSettings::default().method(method).kernel(KernelName(kernel.into()));
    let layer = Layer::new(volume.clone(), transfer).shading(Shading::None);
    let scene = Scene::new(layer, camera.expect("it looks somewhere"))
        .image(ImageDesc::new(side, side))
        .settings(settings);
    render("cpu", &scene)
}

/// Opacity at a position in voxels to the right of and above the middle of a picture, between pixels.
fn opacity(image: &Image, [right, up]: [f64; 2]) -> f64 {
    let side = f64::from(image.width());
    let [x, y] = [0.5 * side + ZOOM * right - 0.5, 0.5 * side - ZOOM * up - 0.5];
    let (column, row) = (x.floor(), y.floor());
    let at = |dx: u32, dy: u32| f64::from(image.pixel(column as u32 + dx, row as u32 + dy)[3]);
    let [s, t] = [x - column, y - row];
    let [above, below] = [0, 1].map(|dy| (1.0 - s) * at(0, dy) + s * at(1, dy));
    (1.0 - t) * above + t * below
}

/// The outermost edge along a line from the middle, which must end outside.
fn edge(image: &Image, angle: f64, [from, to]: [f64; 2]) -> Edge {
    let n_steps = ((to - from) * 4.0 * ZOOM) as usize;
    let position = |step: usize| to + (from - to) * step as f64 / n_steps as f64;
    let at =
        |step: usize| opacity(image, [position(step) * angle.cos(), position(step) * angle.sin()]);
    let profile: Vec<f64> = (0..=n_steps).map(at).collect();
    let most = profile.iter().copied().fold(0.0, f64::max);
    // From outside, the first position at which opacity is so much.
    let first = |share: f64| {
        let step = profile.iter().position(|a| share * most <= *a).expect("the most is there");
        let [before, behind] = [step.saturating_sub(1), step].map(|step| profile[step]);
        let t = if before < behind { (share * most - before) / (behind - before) } else { 0.0 };
        position(step) + (1.0 - t) * (position(0) - position(1))
    };
    Edge { position: first(0.5), width: first(0.1) - first(0.9) }
}

/// The mean edge of a round phantom, seen from two sides.
fn round_edge(volume: &Arc<Volume>, look: Look, ends: [f64; 2]) -> Edge {
    let mut edges = Vec::new();
    for from in [DVec3::X, DVec3::new(1.0, 0.7, 0.4).normalize()] {
        let image = picture(volume, look, from, DVec3::new(0.2, 0.9, 0.3), ends[1]);
        let angle = |idx: u32| std::f64::consts::TAU * f64::from(idx) / 48.0;
        edges.extend((0..48).map(|idx| edge(&image, angle(idx), ends)));
    }
    let mean = |of: fn(&Edge) -> f64| edges.iter().map(of).sum::<f64>() / edges.len() as f64;
    Edge { position: mean(|edge| edge.position), width: mean(|edge| edge.width) }
}

/// The edge of a wall that faces to the right of the picture, seen exactly along.
fn wall_edge(volume: &Arc<Volume>, look: Look) -> Edge {
    let from = WALL.any_orthonormal_vector();
    let image = picture(volume, look, from, from.cross(WALL), 6.0);
    edge(&image, 0.0, [-5.0, 6.0])
}

/// What the wall faces.
const WALL: DVec3 = DVec3::new(0.48, 0.6, 0.64);

#[test]
fn densities_are_sharp_and_where_they_belong() {
    let ball = phantom(|at| 200.0 * (0.5 + 20.5 - at.length()).clamp(0.0, 1.0));
    let shell = phantom(|at| 200.0 * (1.5 - (at.length() - 18.0).abs()).clamp(0.0, 1.0));
    let wall = phantom(|at| 200.0 * (0.5 - 0.1 * at.dot(WALL)).clamp(0.0, 1.0));
    println!("| kernel | method | ball | shell | wall |");
    for (&kernel, &method) in
        KERNEL_NAMES.iter().flat_map(|k| Method::ALL.iter().map(move |m| (k, m)))
    {
        let look = (method, kernel);
        let mut edges = [
            round_edge(&ball, look, [14.0, 24.0]),
            round_edge(&shell, look, [15.0, 22.0]),
            wall_edge(&wall, look),
        ];
        // Round phantoms end where their density is half of the most. Rays through the wall are some 50
        // voxels long, so that it ends where opacity begins.
        for (edge, truth) in edges.iter_mut().zip([20.5, 19.0, 0.5]) {
            edge.position -= truth;
        }
        let [ball, shell, wall] =
            edges.map(|Edge { position, width }| format!("{position:.2}, {width:.2}"));
        println!("| `{kernel}` | `{method}` | {ball} | {shell} | {wall} |");
        for Edge { position, width } in edges {
            if method == Method::PostClassified {
                assert!(position.abs() < 0.1 && width < 0.35, "{kernel}: {edges:?}");
            } else {
                // Voxels that are classified first are as soft as their kernels.
                assert!(0.4 < position && 0.4 < width, "{kernel} {method}: {edges:?}");
            }
        }
    }
}
