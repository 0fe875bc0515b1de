//! How soon a cancelled frame ends: `cargo bench -p slabsplat-tests --bench cancel -- [N [SCENE]]`.
//!
//! Each of N frames is the first one of a fresh renderer, with all that is listed and made for it, and is
//! cancelled at another moment, from its beginning to shortly before its end. What counts is from there until
//! the renderer returns: the time that passes, and the processor time that all threads take, which other work
//! on the machine does not lengthen.

use slabsplat::glam::DVec3;
use slabsplat::{
    Automatic, Camera, FrameHandle, Grid, ImageDesc, LabelMap, LabelStyle, Labels, Mesh, MeshLayer,
    MeshParts, Method, Mode, Normalization, Projection, RenderSettings, Renderer, Scene,
    TransferFunction, Volume, io,
};
use std::fs;
use std::thread;
use std::time::{Duration, Instant};

/// Frames of a scene, unless the command says how many.
const N_FRAMES: u32 = 40;

/// Milliseconds in which a frame should be over.
const GOAL_MS: f64 = 10.0;

/// Voxels a side of the larger volume, 134 million in all.
const LARGE: usize = 512;

fn main() {
    let args: Vec<String> = std::env::args().skip(1).filter(|arg| arg != "--bench").collect();
    let n_frames = args.first().and_then(|n| n.parse().ok()).unwrap_or(N_FRAMES);
    let is_wanted = |name: &str| args.get(1).is_none_or(|part| name.contains(part));
    println!(
        "| first frame | ms, whole | ms, p50 | p99 | max | processor ms, p50 | p99 | max | over |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    for (name, scene) in SCENES {
        if is_wanted(name) {
            measure(name, &scene(), n_frames);
        }
    }
}

type MakeScene = fn() -> Scene;

const SCENES: &[(&str, MakeScene)] = &[
    ("image-aligned", || of_method(Method::ImageAligned)),
    ("axis-aligned", || of_method(Method::AxisAligned)),
    ("every-sample", || of_method(Method::EverySample)),
    ("post-classified", || of_method(Method::PostClassified)),
    ("maximum", || of_mode(Mode::Maximum)),
    ("average", || of_mode(Mode::Average)),
    ("isosurfaces", || of_mode(Mode::Isosurfaces)),
    ("normalised sections, 64 steps wide", || {
        let settings = RenderSettings::default().normalization(Normalization::Product);
        found(neuron(), settings.slab_width(64.0))
    }),
    ("labels", labelled),
    ("two million triangles", || of_triangles(1000)),
    ("134 million voxels, a haze", || large(512, 0.01)),
    ("the same, cells", || large(96, 0.01)),
    ("the same, opaque", || large(512, 0.9)),
    ("the same, densities", || {
        let scene = large(256, 0.01);
        let settings = scene.settings.clone().method(Method::PostClassified);
        scene.settings(settings)
    }),
];

fn neuron() -> Volume {
    io::builtin_volume("neuron", Some(256)).expect("the name is listed")
}

fn found(volume: Volume, settings: RenderSettings) -> Scene {
    Automatic::new(volume).scene(ImageDesc::new(512, 512), settings)
}

fn of_method(method: Method) -> Scene {
    found(neuron(), RenderSettings::default().method(method))
}

fn of_mode(mode: Mode) -> Scene {
    let mut scene = found(neuron(), RenderSettings::default().mode(mode));
    if mode == Mode::Isosurfaces {
        let surface = slabsplat::Isosurface::new(128.0, 1.0, None).expect("it is opaque");
        scene.layers[0].isosurfaces = vec![surface];
    }
    scene
}

fn labelled() -> Scene {
    let scene = of_method(Method::ImageAligned);
    let grid = *scene.layers[0].volume.grid();
    let label_of = |[x, y, z]: [usize; 3]| ((x / 16 + y / 16 + z / 16) % 40) as u8;
    let map = Volume::from_fn(grid, label_of);
    let map = LabelMap::new(&map, &grid).expect("labels are whole numbers");
    let style = |label: i64| LabelStyle::default().color([label as f64 / 40.0, 0.5, 0.2]);
    let labels = Labels::new(map, (0..40).map(|label| (label, style(label))));
    let layer = scene.layers[0].clone().labels(labels.expect("colours are from 0 to 1"));
    scene.layers(vec![layer])
}

/// A wavy surface, two triangles for each of n² squares.
fn of_triangles(n: u32) -> Scene {
    let at = |idx: u32| f64::from(idx) / f64::from(n) - 0.5;
    let height = |x: f64, y: f64| 0.1 * (20.0 * x).sin() * (15.0 * y).cos();
    let vertex = |x: f64, y: f64| DVec3::new(x, y, height(x, y));
    let positions = (0..=n).flat_map(|y| (0..=n).map(move |x| vertex(at(x), at(y)))).collect();
    let corner = |x: u32, y: u32| y * (n + 1) + x;
    let square = |x: u32, y: u32| {
        let [a, b, c, d] = [corner(x, y), corner(x + 1, y), corner(x, y + 1), corner(x + 1, y + 1)];
        [[a, b, c], [b, d, c]]
    };
    let triangles = (0..n).flat_map(|y| (0..n).flat_map(move |x| square(x, y))).collect();
    let parts = MeshParts::new(positions).triangles(triangles);
    let mesh = MeshLayer::new(Mesh::new(parts).expect("all corners are there"));
    let projection = Projection::Orthographic { view_height: 1.2 };
    let camera = Camera::new([1.0, 1.5, 2.0], [0.0; 3], [0.0, 0.0, 1.0], projection);
    let scene = Scene::of_meshes(vec![mesh], camera.expect("it looks at the middle"));
    scene.image(ImageDesc::new(512, 512))
}

/// A ball with a texture, in a picture of so many pixels a side.
fn large(side: u32, opacity: f64) -> Scene {
    let grid = Grid::with_spacing([LARGE; 3], [1.0; 3]).expect("steps are positive");
    let half = LARGE as f64 / 2.0;
    let value = |voxel: [usize; 3]| {
        let radius = DVec3::from_array(voxel.map(|idx| idx as f64 - half)).length() / half;
        let texture = (voxel[0] * 7 + voxel[1] * 13 + voxel[2] * 29) % 64;
        if radius < 1.0 { (160.0 * (1.0 - radius)) as u8 + texture as u8 } else { 0 }
    };
    let volume = Volume::from_fn(grid, value);
    let points = [(20.0, 0.0), (30.0, opacity)];
    let transfer = TransferFunction::new(points, [(0.0, [1.0, 0.5, 0.2]), (255.0, [1.0; 3])]);
    let mut scene = found(volume, RenderSettings::default());
    scene.layers[0].transfer = transfer.expect("an opacity is from 0 to 1");
    scene.image(ImageDesc::new(side, side))
}

fn measure(name: &str, scene: &Scene, n_frames: u32) {
    let whole = times(scene, None).wall_ms;
    let mut ends: Vec<Times> = (0..n_frames)
        .map(|nth| {
            let part = (f64::from(nth) + 0.5) / f64::from(n_frames);
            times(scene, Some(Duration::from_secs_f64(1e-3 * whole * part)))
        })
        .filter(|times| times.is_cancelled)
        .collect();
    let n_over = ends.iter().filter(|times| GOAL_MS < times.processor_ms).count();
    let mut row = format!("| {name} | {whole:.0}");
    for of in [|times: &Times| times.wall_ms, |times: &Times| times.processor_ms] {
        ends.sort_by(|a, b| of(a).total_cmp(&of(b)));
        let at = |part: f64| ends.get(((ends.len() as f64 * part) as usize).min(ends.len() - 1));
        for part in [0.5, 0.99, 1.0] {
            row += &format!(" | {:.1}", at(part).map_or(f64::NAN, of));
        }
    }
    println!("{row} | {n_over} of {} |", ends.len());
}

/// What a frame took, from when it was cancelled or else from its beginning.
struct Times {
    is_cancelled: bool,
    wall_ms: f64,
    processor_ms: f64,
}

fn times(scene: &Scene, cancelled_after: Option<Duration>) -> Times {
    let mut renderer = Renderer::open("cpu", |_| ()).expect("the CPU is always there");
    let frame = FrameHandle::new();
    let mut from = (Instant::now(), processor_ms());
    let (is_cancelled, at_end) = thread::scope(|scope| {
        let drawing = scope.spawn(|| {
            let drawn = renderer.render_as(scene, &frame);
            // What this thread took is no longer told of once it is over.
            (drawn.is_err(), (Instant::now(), processor_ms()))
        });
        if let Some(after) = cancelled_after {
            thread::sleep(after);
            from = (Instant::now(), processor_ms());
            frame.cancel();
        }
        drawing.join().expect("nothing panics")
    });
    let wall_ms = 1e3 * at_end.0.saturating_duration_since(from.0).as_secs_f64();
    Times { is_cancelled, wall_ms, processor_ms: at_end.1 - from.1 }
}

/// What all threads of this process have taken; 0 where the system has no such files.
fn processor_ms() -> f64 {
    let threads = fs::read_dir("/proc/self/task").into_iter().flatten().flatten();
    let texts = threads.filter_map(|entry| fs::read_to_string(entry.path().join("schedstat")).ok());
    let nanoseconds = texts.filter_map(|text| text.split(' ').next()?.parse::<f64>().ok());
    1e-6 * nanoseconds.sum::<f64>()
}
