//! Small frames whose instructions are counted: `cargo xtask bench instructions`.
//!
//! Each workload renders a frame that does not count, and then one that does, in which one stage or two do
//! most of the work. They are whole frames through the facade, so that the crates below may be rebuilt
//! freely, and valgrind counts what [`counted_frame`] does and nothing else.
//!
//! This is no test of its own: without arguments, as `cargo test` runs it, it only draws all frames.

use slabsplat::glam::{DAffine3, DVec3};
use slabsplat::{
    Camera, Frame, Grid, ImageDesc, Layer, Method, Projection, RenderSettings, Renderer, Scene,
    TransferFunction, Volume, backend_named, io,
};

/// A frame that is counted, and how to come there.
struct Workload {
    name: &'static str,
    method: Method,
    /// A built-in volume, and voxels along its side.
    volume: (&'static str, usize),
    /// By what its steps are longer.
    stretch: DVec3,
    /// Where it is seen from, in sides of the volume.
    eye: DVec3,
    /// Opacity of the largest value.
    opacity: f64,
    image_side: u32,
    /// What differs in the frame that counts.
    change: fn(&mut Scene),
}

const ASLANT: DVec3 = DVec3::new(3.0, 2.0, 1.0);

/// A pixel covers nearly three voxels of a haze: cells stand for these, which the frame before has made.
const CELLS: Workload = Workload {
    name: "cells",
    method: Method::ImageAligned,
    volume: ("sphere", 96),
    stretch: DVec3::ONE,
    eye: ASLANT,
    opacity: 0.02,
    image_side: 40,
    change: orbit,
};

const WORKLOADS: &[Workload] = &[
    // A new transfer function while the camera looks past the volume: list, shade, project. The picture
    // has as many pixels as the volume voxels: with fewer, cells stand for these, and what is not seen is not
    // listed.
    Workload {
        name: "classify",
        method: Method::ImageAligned,
        volume: ("sphere", 64),
        stretch: DVec3::ONE,
        eye: ASLANT,
        opacity: 0.5,
        image_side: 64,
        change: |scene| {
            look_past(scene);
            scene.layers[0].transfer = transfer(0.7, 100.0);
        },
    },
    // Seen at its face, the first voxels of a solid cube hide all others: toss, and pass over.
    Workload {
        name: "toss",
        method: Method::ImageAligned,
        volume: ("cube", 64),
        stretch: DVec3::ONE,
        eye: DVec3::new(3.0, 0.0, 0.0),
        opacity: 1.0,
        image_side: 64,
        change: orbit,
    },
    // Where most is occluded.
    Workload {
        name: "opaque",
        method: Method::ImageAligned,
        volume: ("neuron", 64),
        stretch: DVec3::ONE,
        eye: ASLANT,
        opacity: 0.8,
        image_side: 96,
        change: orbit,
    },
    // Where every section counts.
    Workload {
        name: "haze",
        method: Method::ImageAligned,
        volume: ("sphere", 32),
        stretch: DVec3::ONE,
        eye: ASLANT,
        opacity: 0.02,
        image_side: 96,
        change: orbit,
    },
    CELLS,
    // And made anew, for another transfer function.
    Workload {
        name: "cells-anew",
        change: |scene| scene.layers[0].transfer = transfer(0.025, 90.0),
        ..CELLS
    },
    // Where slabs are tilted, and footprints sheared.
    Workload {
        name: "tilted",
        method: Method::ImageAligned,
        volume: ("sphere", 32),
        stretch: DVec3::new(1.0, 1.2, 1.5),
        eye: ASLANT,
        opacity: 0.9,
        image_side: 96,
        change: orbit,
    },
    // Where densities are summed and then classified, two sheets to a slab.
    Workload {
        name: "densities",
        method: Method::PostClassified,
        volume: ("neuron", 64),
        stretch: DVec3::ONE,
        eye: ASLANT,
        opacity: 0.8,
        image_side: 96,
        change: orbit,
    },
    // A few voxels in slabs of a new width, all of whose sections are made anew.
    Workload {
        name: "section-table",
        method: Method::ImageAligned,
        volume: ("cube", 4),
        stretch: DVec3::ONE,
        eye: ASLANT,
        opacity: 0.5,
        image_side: 8,
        change: |scene| scene.settings.slab_width = 1.25,
    },
];

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    // All is done on this thread: work of another would not be counted.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread();
    pool.build_global().expect("there is no pool yet");
    match args[..] {
        [] => WORKLOADS.iter().for_each(run),
        ["--workloads"] => WORKLOADS.iter().for_each(|workload| println!("{}", workload.name)),
        ["--count", name] => run(named(name)),
        // A filter for tests, of which there are none here.
        _ => {}
    }
}

fn named(name: &str) -> &'static Workload {
    let found = WORKLOADS.iter().find(|workload| workload.name == name);
    found.unwrap_or_else(|| panic!("there is no workload called {name}"))
}

fn run(workload: &Workload) {
    let (name, size) = workload.volume;
    let volume = io::builtin_volume(name, Some(size)).expect("the volume is built in");
    let stretch = DAffine3::from_scale(workload.stretch);
    let grid = Grid::new(volume.grid().dims(), stretch * volume.grid().world_from_index());
    let volume = volume.with_grid(grid.expect("no step is 0")).expect("there are as many voxels");
    let backend = backend_named("cpu").expect("the CPU is always there");
    let mut renderer = Renderer::new(backend);
    let mut scene = scene(workload, volume);
    renderer.render(&scene).expect("the scene can be drawn");
    (workload.change)(&mut scene);
    let frame = counted_frame(&mut renderer, &scene);
    assert!(0 < frame.stats.n_voxels, "{} draws nothing", workload.name);
}

/// Known to `xtask` by its name. Not inlined, as there would be nothing to count then.
#[inline(never)]
fn counted_frame(renderer: &mut Renderer, scene: &Scene) -> Frame {
    renderer.render(scene).expect("the scene can be drawn")
}

fn scene(workload: &Workload, volume: Volume) -> Scene {
    let side = workload.volume.1 as f64;
    let projection = Projection::Orthographic { view_height: 1.2 * side };
    let camera = Camera::new(workload.eye * side, DVec3::ZERO, DVec3::Z, projection)
        .expect("the eye is off the axis");
    let (width, height) = (workload.image_side, workload.image_side);
    Scene::new(Layer::new(volume, transfer(workload.opacity, 90.0)), camera)
        .image(ImageDesc::new(width, height))
        .settings(RenderSettings::default().method(workload.method))
}

fn transfer(opacity: f64, foot: f64) -> TransferFunction {
    TransferFunction::new(
        vec![(foot, [0.0]), (255.0, [opacity])],
        vec![(0.0, [0.9, 0.5, 0.4]), (255.0, [1.0, 0.9, 0.8])],
    )
    .expect("the points are sorted")
}

fn orbit(scene: &mut Scene) {
    scene.camera = scene.camera.orbited(1_f64.to_radians());
}

fn look_past(scene: &mut Scene) {
    let camera = &scene.camera;
    let aside = camera.target() + 10.0 * camera.eye().length() * camera.axes().right;
    let moved = Camera::new(camera.eye() + aside, aside, DVec3::Z, camera.projection());
    scene.camera = moved.expect("the eye is off the axis");
}
