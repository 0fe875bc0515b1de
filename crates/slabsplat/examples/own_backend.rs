//! A backend of one's own: `cargo run --release -p slabsplat --example own_backend [PICTURE]`.
//!
//! It draws each voxel as a point, the nearest over all others: a preview, and nothing like the picture that
//! the contract of backends promises. What it shows is all that a backend is given, and what it gives back.

use slabsplat::backend::LayerPlan;
use slabsplat::{
    Automatic, Backend, BackendError, Caps, Frame, FrameCost, FrameHandle, FramePlan, FrameStats,
    Image, ImageDesc, Method, RenderSettings, Renderer, glam::DVec3, io,
};
use std::error::Error;
use std::path::{Path, PathBuf};
use std::task::Poll;

fn main() -> Result<(), Box<dyn Error>> {
    let picture = std::env::args().nth(1).unwrap_or_else(|| "own-backend.png".to_owned());
    draw(&PathBuf::from(picture))
}

/// Draws a volume as points.
pub(crate) fn draw(picture: &Path) -> Result<(), Box<dyn Error>> {
    let automatic = Automatic::new(io::builtin_volume("neuron", Some(64))?);
    let scene = automatic.scene(ImageDesc::default(), RenderSettings::default());
    let mut renderer = Renderer::new(Box::new(Points::default()));
    io::write_picture(picture, &renderer.render(&scene)?.image)?;
    Ok(())
}

#[derive(Debug)]
struct Points {
    caps: Caps,
    done: Vec<(FrameHandle, Frame)>,
}

impl Default for Points {
    fn default() -> Self {
        Self { caps: Caps::new("points", "one thread", Method::ALL), done: Vec::new() }
    }
}

impl Backend for Points {
    fn caps(&self) -> &Caps {
        &self.caps
    }

    fn submit(&mut self, plan: &FramePlan<'_>, frame: &FrameHandle) -> Result<(), BackendError> {
        let ImageDesc { width, height, .. } = plan.image;
        let mut image = Image::filled(width, height, plan.image.premultiplied_background());
        let mut nearest = vec![f64::INFINITY; plan.image.n_pixels()];
        let mut stats = FrameStats::default();
        for layer in &plan.layers {
            frame.check()?;
            stats.n_voxels += draw_layer(layer, &mut image, &mut nearest);
        }
        // What nobody can take any more is not kept.
        self.done.retain(|(frame, _)| !frame.is_abandoned());
        self.done.push((frame.clone(), Frame::new(image, stats, FrameCost::default())));
        Ok(())
    }

    fn poll_image(&mut self, frame: &FrameHandle) -> Result<Poll<Frame>, BackendError> {
        let idx = self.done.iter().position(|(done, _)| done == frame);
        let (frame, picture) = self.done.swap_remove(idx.ok_or(BackendError::UnknownFrame)?);
        frame.check()?;
        Ok(Poll::Ready(picture))
    }
}

/// Draws the relevant voxels of a layer where nothing is nearer, and counts them.
fn draw_layer(layer: &LayerPlan<'_>, image: &mut Image, nearest: &mut [f64]) -> u64 {
    let grid = layer.volume.grid();
    let view_from_index = layer.view.from_index(grid);
    let [width, height] = layer.view.image_size();
    let mut n_voxels = 0;
    for voxel_idx in 0..grid.n_voxels() {
        let value = layer.volume.value(voxel_idx);
        if !layer.relevant.iter().any(|range| range.lo <= value && value <= range.hi) {
            continue;
        }
        n_voxels += 1;
        let index = DVec3::from_array(grid.voxel_coords(voxel_idx).map(|c| c as f64));
        let DVec3 { x, y, z: depth } = view_from_index.transform(index);
        if depth < layer.view.near_depth() {
            continue;
        }
        let pixels = layer.view.pixels_per_world(depth);
        let column = 0.5 * f64::from(width) + pixels * x;
        let row = 0.5 * f64::from(height) - pixels * y;
        let is_inside =
            (0.0..f64::from(width)).contains(&column) && (0.0..f64::from(height)).contains(&row);
        if !is_inside {
            continue;
        }
        let pixel = row as usize * width as usize + column as usize;
        if depth < nearest[pixel] {
            nearest[pixel] = depth;
            let [r, g, b] = layer.transfer.color(value).map(|channel| channel as f32);
            image.pixels_mut()[pixel] = [r, g, b, 1.0];
        }
    }
    n_voxels
}
