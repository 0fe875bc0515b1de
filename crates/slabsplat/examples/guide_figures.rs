//! The figures of the guide: `cargo run --release -p slabsplat --example guide_figures [DIR]`.

use slabsplat::kernel::{Gaussian, SectionDesc};
use slabsplat::{
    Automatic, Camera, Image, ImageDesc, Kernel, Method, Normalization, Plane, Projection, Region,
    RenderSettings, Renderer, Scene, io,
};
use std::error::Error;
use std::path::{Path, PathBuf};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Between two panels, in pixels.
const GAP: u32 = 6;

fn main() -> Result<()> {
    let dir = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| "figures".to_owned()));
    std::fs::create_dir_all(&dir)?;
    draw(&dir)
}

/// Writes all figures into `dir`.
pub(crate) fn draw(dir: &Path) -> Result<()> {
    io::write_picture(dir.join("sections.png"), &row(&sections()))?;
    io::write_picture(dir.join("sheets.png"), &row(&sheets()?))?;
    io::write_picture(dir.join("popping.png"), &column(&popping()?))?;
    Ok(())
}

/// The sections of one voxel by slabs half a voxel step thick, from front to back, and their sum.
fn sections() -> Vec<Image> {
    let (width, n_pixels, n_slabs) = (0.5, 88, 8);
    let desc = SectionDesc {
        kernel: &Gaussian,
        width,
        kappa: 1.0,
        normalization: Normalization::None,
        base_width: width,
    };
    let radius = Gaussian.radius();
    let brightest = desc.weight(0.0, -0.5 * width);
    let panel = |gray: &dyn Fn(f64) -> f64| {
        let mut image = Image::filled(n_pixels, n_pixels, [0.0; 4]);
        let position = |pixel: usize| (pixel as f64 + 0.5) / f64::from(n_pixels) * 2.0 - 1.0;
        for (idx, pixel) in image.pixels_mut().iter_mut().enumerate() {
            let (x, y) = (idx % n_pixels as usize, idx / n_pixels as usize);
            let gray = gray(radius * position(x).hypot(position(y))) as f32;
            *pixel = [gray, gray, gray, 1.0];
        }
        image
    };
    let front = |slab: i32| -radius + width * f64::from(slab);
    let section = |slab: i32| panel(&|rho| desc.weight(rho, front(slab)) / brightest);
    let whole = panel(&|rho| Gaussian.footprint(rho) / Gaussian.footprint(0.0));
    (0..n_slabs).map(section).chain([whole]).collect()
}

/// What thick slabs through the middle of a volume hold, from front to back, and the picture of all.
fn sheets() -> Result<Vec<Image>> {
    let n_slabs = 5;
    let volume = io::builtin_volume("neuron", Some(64))?;
    let image = ImageDesc::new(176, 176).background([0.0, 0.0, 0.0, 1.0]);
    let scene = Automatic::new(volume).scene(image, RenderSettings::default());
    let scene = turned(&scene, 30.0)?;
    let mut renderer = Renderer::open("cpu", |_| ())?;
    let forward = scene.camera.axes().forward;
    let grid = *scene.layers[0].volume.grid();
    let (middle, reach) = (grid.center_in_world().dot(forward), 18.0 * grid.unit());
    let depth = |share: f64| middle + reach * (2.0 * share - 1.0);
    let mut panels = Vec::new();
    for slab in 0..n_slabs {
        let faces = [slab, slab + 1].map(|face| depth(f64::from(face) / f64::from(n_slabs)));
        let [front, back] = faces;
        let slab = Region::new(vec![Plane::new(forward, back)?, Plane::new(-forward, -front)?]);
        let layer = scene.layers[0].clone().region(slab);
        panels.push(renderer.render(&scene.clone().layers(vec![layer]))?.image);
    }
    panels.push(renderer.render(&scene)?.image);
    Ok(panels)
}

/// Two frames that are a fifth of a degree apart, where slices of the grid change direction, and their
/// difference, ten times as bright: by slabs parallel to the image, and by slices.
fn popping() -> Result<Vec<Image>> {
    let volume = io::builtin_volume("neuron", Some(64))?;
    let image = ImageDesc::new(288, 288).background([0.0, 0.0, 0.0, 1.0]);
    let scene = Automatic::new(volume).scene(image, RenderSettings::default());
    let mut renderer = Renderer::open("cpu", |_| ())?;
    let mut rows = Vec::new();
    for method in [Method::ImageAligned, Method::AxisAligned] {
        let mut frame = |degrees: f64| -> Result<Image> {
            let settings = RenderSettings::default().method(method).tolerance(0.0);
            let seen = turned(&scene, degrees)?.settings(settings);
            Ok(renderer.render(&seen)?.image)
        };
        let [before, after] = [frame(44.9)?, frame(45.1)?];
        let mut difference = before.clone();
        for (pixel, other) in difference.pixels_mut().iter_mut().zip(after.pixels()) {
            let [r, g, b] = [0, 1, 2].map(|channel| 10.0 * (pixel[channel] - other[channel]).abs());
            *pixel = [r, g, b, 1.0];
        }
        rows.push(row(&[before, after, difference]));
    }
    Ok(rows)
}

/// The scene seen from beside its volume, at an angle to the grid.
fn turned(scene: &Scene, degrees: f64) -> Result<Scene> {
    let grid = scene.layers[0].volume.grid();
    let center = grid.center_in_world().to_array();
    let (sin, cos) = degrees.to_radians().sin_cos();
    let distance = 200.0;
    let eye = [center[0] + distance * cos, center[1] + distance * sin, center[2] + 0.3 * distance];
    let view_height = grid.unit() * 76.0;
    let camera =
        Camera::new(eye, center, [0.0, 0.0, 1.0], Projection::Orthographic { view_height })?;
    Ok(scene.clone().camera(camera))
}

/// Panels of one height side by side.
fn row(panels: &[Image]) -> Image {
    let width = panels.iter().map(|panel| panel.width() + GAP).sum::<u32>() - GAP;
    let mut image = Image::filled(width, panels[0].height(), [0.0; 4]);
    let mut left = 0;
    for panel in panels {
        paste(&mut image, panel, [left, 0]);
        left += panel.width() + GAP;
    }
    image
}

/// Panels of one width, one below the other.
fn column(panels: &[Image]) -> Image {
    let height = panels.iter().map(|panel| panel.height() + GAP).sum::<u32>() - GAP;
    let mut image = Image::filled(panels[0].width(), height, [0.0; 4]);
    let mut top = 0;
    for panel in panels {
        paste(&mut image, panel, [0, top]);
        top += panel.height() + GAP;
    }
    image
}

fn paste(image: &mut Image, panel: &Image, [left, top]: [u32; 2]) {
    let (width, panel_width) = (image.width() as usize, panel.width() as usize);
    for (y, pixels) in panel.pixels().chunks_exact(panel_width).enumerate() {
        let start = (top as usize + y) * width + left as usize;
        image.pixels_mut()[start..start + panel_width].copy_from_slice(pixels);
    }
}
