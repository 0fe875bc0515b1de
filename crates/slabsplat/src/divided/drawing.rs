//! A frame box by box, from the eye.

use super::ahead::{Ahead, BoxVoxels, LayerVoxels};
use super::painter::Painter;
use super::{DividedError, DividedScene, ShareCost};
use crate::{RenderError, frame_scene};
use rayon::prelude::*;
use slabsplat_backend::{Frame, FrameCost, FrameStats};
use slabsplat_core::glam::DVec3;
use slabsplat_core::{
    FrameHandle, Grid, Image, ImageDesc, PartBox, PartInView, Region, RegionInView, Scene, View,
    over,
};
use std::ops::Range;

impl DividedScene {
    /// Draws all boxes, before the background.
    pub(super) fn frame(
        &self,
        frame: &FrameHandle,
        heard: &mut dyn FnMut(&Image, usize),
    ) -> Result<Frame, DividedError> {
        let drawn = frame_scene(&self.opened.scene).map_err(RenderError::from)?;
        let behind = drawn.image.premultiplied_background();
        drop(drawn);
        let (Frame { mut image, stats, cost, .. }, _) = self.boxes_drawn(frame, heard)?;
        image.pixels_mut().iter_mut().for_each(|pixel| *pixel = over(*pixel, behind));
        Ok(Frame::new(image, stats, cost))
    }

    /// Draws the own boxes, one behind the other, before nothing. `heard` is given what is there after each,
    /// and of how many boxes nothing more is to come.
    pub(super) fn boxes_drawn(
        &self,
        frame: &FrameHandle,
        heard: &mut dyn FnMut(&Image, usize),
    ) -> Result<(Frame, ShareCost), DividedError> {
        let drawn = frame_scene(&self.opened.scene).map_err(RenderError::from)?;
        let ImageDesc { width, height, .. } = drawn.image;
        let mut scene = drawn.into_owned();
        scene.image.background = [0.0; 4];
        let mut image = Image::filled(width, height, [0.0; 4]);
        let (mut stats, mut cost) = (FrameStats::default(), ShareCost::default());
        let painter = Painter::new(&self.backend, self.n_threads);
        let mut painter = painter.with_cells(self.coarsest_cells());
        self.retained.begin_frame(self.room_bytes);
        let boxes = self.own_boxes();
        std::thread::scope(|threads| {
            let mut left = boxes.iter().copied().enumerate();
            let mut next = self.next_seen(&mut left, (&scene, &image), frame)?;
            let mut ahead = None;
            while let Some((idx, of)) = next {
                let begun = ahead.take().unwrap_or_else(|| Ahead::begin(self, of, threads));
                let voxels = cost.wait_for(begun)?;
                // What is hidden by then is read in vain.
                next = self.next_seen(&mut left, (&scene, &image), frame)?;
                ahead = next.map(|(_, of)| Ahead::begin(self, of, threads));
                let shares = [idx, idx + 1].map(|n| n as f32 / boxes.len() as f32);
                let of_box = frame.part(shares[0]..shares[1]);
                let drawn = draw_box(&mut scene, of, voxels, (&mut painter, &image), &of_box)?;
                add(&mut stats, &drawn.stats);
                image = drawn.image;
                cost.n_boxes[0] += 1;
                frame.reach(shares[1]);
                if let Some((_, of)) = next
                    && !self.is_to_be_seen(of, &scene, &image)?
                {
                    // Two of them would be too many.
                    drop(ahead.take().map(Ahead::voxels));
                    next = self.next_seen(&mut left, (&scene, &image), frame)?;
                }
                heard(&image, next.map_or(boxes.len(), |(idx, _)| idx));
            }
            Ok::<_, DividedError>(())
        })?;
        cost.n_boxes[1] = boxes.len() - cost.n_boxes[0];
        frame.reach(1.0);
        Ok((Frame::new(image, stats, FrameCost::default()), cost))
    }

    /// The first of the boxes left of which anything is to be seen.
    fn next_seen<'b>(
        &self,
        left: &mut impl Iterator<Item = (usize, &'b PartBox)>,
        (scene, image): (&Scene, &Image),
        frame: &FrameHandle,
    ) -> Result<Option<(usize, &'b PartBox)>, DividedError> {
        for (idx, of) in left {
            frame.check().map_err(RenderError::from)?;
            if self.is_to_be_seen(of, scene, image)? {
                return Ok(Some((idx, of)));
            }
        }
        Ok(None)
    }

    /// Whether any pixel that is not saturated may show anything of a box.
    fn is_to_be_seen(
        &self,
        of: &PartBox,
        scene: &Scene,
        image: &Image,
    ) -> Result<bool, DividedError> {
        let cutoff = scene.settings.opacity_cutoff as f32;
        let [width, height] = [image.width(), image.height()].map(|n| n as usize);
        for (grid, support) in self.grids.iter().zip(&self.supports) {
            let view = View::about(of.part.center(), grid, &scene.camera, &scene.image)
                .map_err(slabsplat_backend::PlanError::from)?;
            // Bricks of cells are read whole, but no more of them is seen.
            let near = self.boxes.voxels_near(of, grid, &support.with_cells(0));
            let steps = &support.steps;
            let ends = [
                near.each_ref().map(|range| range.start as f64 - steps_around(steps)),
                near.each_ref().map(|range| range.end as f64 + steps_around(steps)),
            ];
            let Ok(extent) = Region::in_index_box(grid, ends) else { return Ok(true) };
            let (extent, part) =
                (RegionInView::new(&extent, &view), PartInView::new(&of.part, &view));
            let shows = |[x, y]: [usize; 2]| {
                if cutoff <= image.pixels()[y * width + x][3] {
                    return false;
                }
                let ray = view.ray([x, y].map(|p| p as f64 + 0.5));
                let [[a, b], [c, d]] = [extent.interval(&ray), part.interval(&ray)];
                a.max(c) < b.min(d)
            };
            let [columns, rows] = pixels_around(&view, grid, ends, [width, height]);
            if rows.into_par_iter().any(|y| columns.clone().any(|x| shows([x, y]))) {
                return Ok(true);
            }
        }
        Ok(false)
    }
}

/// The columns and rows of pixels that may show anything of what lies between two corners in the index space
/// of `grid`: all of them where that reaches before the eye.
fn pixels_around(
    view: &View,
    grid: &Grid,
    ends: [[f64; 3]; 2],
    n_pixels: [usize; 2],
) -> [Range<usize>; 2] {
    let from_index = view.from_index(grid);
    let [mut least, mut most] = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    for corner in 0..8_usize {
        let at = [0, 1, 2].map(|axis| ends[corner >> axis & 1][axis]);
        let point = from_index.transform(DVec3::from_array(at));
        if point.z < view.near_depth() {
            return n_pixels.map(|n| 0..n);
        }
        let pixels_per_world = view.pixels_per_world(point.z);
        let from_middle = [point.x, -point.y].map(|world| world * pixels_per_world);
        for axis in 0..2 {
            let pixel = 0.5 * n_pixels[axis] as f64 + from_middle[axis];
            (least[axis], most[axis]) = (least[axis].min(pixel), most[axis].max(pixel));
        }
    }
    [0, 1].map(|axis| {
        let end = (most[axis].ceil().max(0.0) as usize).min(n_pixels[axis]);
        (least[axis].floor().max(0.0) as usize).min(end)..end
    })
}

/// How far around the voxels that are read anything of them may be seen, generously.
fn steps_around(steps: &[f64; 3]) -> f64 {
    steps.iter().copied().fold(0.0, f64::max)
}

/// Draws a box behind what is there; its voxels are in memory no longer than that.
fn draw_box(
    scene: &mut Scene,
    of: &PartBox,
    voxels: BoxVoxels,
    (painter, in_front): (&mut Painter<'_>, &Image),
    frame: &FrameHandle,
) -> Result<Frame, DividedError> {
    let layers = scene.layers.iter_mut().zip(voxels.layers);
    let overviews = layers.map(|(layer, of)| {
        let volume = std::mem::replace(&mut layer.volume, of.volume);
        let colors = std::mem::replace(&mut layer.colors, of.colors);
        let labels = std::mem::replace(&mut layer.labels, of.labels);
        // They look as they do in the scene, which may be of another moment.
        if let (Some(here), Some(labels)) = (&mut layer.labels, &labels) {
            *here = here.with_styles(labels.styles().clone()).expect("they are of a scene");
        }
        LayerVoxels { volume, colors, labels }
    });
    let overviews: Vec<LayerVoxels> = overviews.collect();
    let drawn = painter.draw(scene, &of.part, in_front, frame);
    painter.forget();
    let layers = scene.layers.iter_mut().zip(overviews);
    layers.for_each(|(layer, overview)| {
        let LayerVoxels { volume, colors, labels } = overview;
        (layer.volume, layer.colors, layer.labels) = (volume, colors, labels);
    });
    drawn
}

/// Counts what a box drew, whose voxels around it are counted by others, too.
fn add(all: &mut FrameStats, of: &FrameStats) {
    all.n_voxels += of.n_voxels;
    all.n_occluded += of.n_occluded;
    all.n_splats += of.n_splats;
    all.n_culled += of.n_culled;
    all.n_tiles += of.n_tiles;
    all.n_saturated_tiles += of.n_saturated_tiles;
}
