//! What a viewer shows while a scene is drawn box by box.
//!
//! Boxes come from the eye: what is on the canvas is as it will be, and what lies behind it is missing. There
//! the overview is shown of the boxes that are still to come, and of no others: of those that are drawn it
//! would be seen twice.
//!
//! ```text
//! group the boxes, in the order in which they are seen, into at most eight parts of the world
//! for each group, from the farthest: draw its overview, lay it before those behind it, and retain that
//! show the one of all groups
//! after each group of boxes: show the canvas before the overviews of the groups that are left
//! ```

use super::painter::Painter;
use super::{DividedError, DividedScene};
use crate::{Picture, RenderError, frame_scene};
use slabsplat_backend::{Frame, FrameCost, FrameStats};
use slabsplat_core::{FrameHandle, Image, Part, over};

/// Groups of boxes, at most: each takes four bytes a pixel.
pub(super) const MOST_GROUPS: usize = 8;

/// The share of a frame that the first picture is, for its progress.
const OF_FIRST: f32 = 0.05;

/// What there is of a scene while it is drawn, for who shows it.
#[derive(Debug)]
pub struct Refinement<'a> {
    scene: &'a DividedScene,
    drawn: &'a Image,
    behind: &'a Backdrop,
    share: f32,
}

/// A premultiplied picture of 8 bits: it is seen for a moment.
#[derive(Debug)]
struct Backdrop(Vec<[u8; 4]>);

impl Backdrop {
    fn of(image: &Image) -> Self {
        let byte = |value: f32| (value.clamp(0.0, 1.0) * 255.0).round() as u8;
        Self(image.pixels().iter().map(|pixel| pixel.map(byte)).collect())
    }

    /// What is in front of it, before a background.
    fn behind(&self, front: &Image, background: [f32; 4]) -> Image {
        let mut image = front.clone();
        for (pixel, behind) in image.pixels_mut().iter_mut().zip(&self.0) {
            let behind = behind.map(|byte| f32::from(byte) / 255.0);
            *pixel = over(*pixel, over(behind, background));
        }
        image
    }
}

impl Refinement<'_> {
    /// The share of the boxes that are drawn, 0 … 1: 0 for the first picture, which is all of overviews.
    pub fn share(&self) -> f32 {
        self.share
    }

    /// Makes the picture, finished as the last one will be. It takes some milliseconds, so that who has no
    /// time for it may leave it.
    pub fn picture(&self) -> Picture {
        let scene = &self.scene.opened.scene;
        let drawn = frame_scene(scene).expect("it is being drawn");
        let image = self.behind.behind(self.drawn, drawn.image.premultiplied_background());
        self.scene.finished(Frame::new(image, FrameStats::default(), FrameCost::default()))
    }
}

impl DividedScene {
    /// Draws the scene as [`picture`](Self::picture) does, and hands out what can be shown until then: at
    /// first a coarse picture of the overviews, within moments; then, up to seven times, what is drawn. Boxes
    /// come from the eye, so that what is in front is as it will be; behind it overviews are seen of what is
    /// still to come, which have longer voxel steps, and so are softer.
    ///
    /// A clone of `frame` cancels it, also within `hear`.
    ///
    /// ```
    /// use slabsplat::{DividedDesc, DividedScene, FrameHandle, io};
    ///
    /// let folder = tempfile::tempdir()?;
    /// let path = folder.path().join("ball.npy");
    /// io::write_volume(&path, &io::builtin_volume("sphere", Some(64))?)?;
    /// let file = io::SceneFile::of_volume(io::VolumeSource::File(path));
    ///
    /// let desc = DividedDesc::new(200 << 20).refined();
    /// let scene = DividedScene::open_as(&file, &desc)?;
    /// let mut shares = Vec::new();
    /// let picture = scene.refined(&FrameHandle::new(), &mut |shown| {
    ///     shares.push(shown.share());
    ///     assert!(!shown.picture().is_blank);
    /// })?;
    /// assert!(shares[0] == 0.0 && !picture.is_blank);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`picture`](Self::picture), and if the scene was not opened for it ([`DividedDesc::refined`]).
    ///
    /// [`DividedDesc::refined`]: super::DividedDesc::refined
    pub fn refined(
        &self,
        frame: &FrameHandle,
        hear: &mut dyn FnMut(&Refinement<'_>),
    ) -> Result<Picture, DividedError> {
        if !self.is_refined {
            return Err(DividedError::NotRefined);
        }
        let groups = self.boxes.groups_seen_by(&self.opened.scene.camera, MOST_GROUPS);
        let parts: Vec<&Part> = groups.iter().map(|(part, _)| part).collect();
        let (blank, backdrops) = self.backdrops(&parts, &frame.part(0.0..OF_FIRST))?;
        let mut n_before = 0;
        let ends = groups.iter().map(|(_, boxes)| {
            n_before += boxes.len();
            n_before
        });
        let ends: Vec<usize> = ends.collect();
        let mut show = |drawn: &Image, n_groups: usize, n_boxes: usize| {
            let share = n_boxes as f32 / n_before as f32;
            hear(&Refinement { scene: self, drawn, behind: &backdrops[n_groups], share });
        };
        show(&blank, 0, 0);
        drop(blank);
        let mut n_shown = 0;
        let drawn = self.frame(&frame.part(OF_FIRST..1.0), &mut |drawn, n_boxes| {
            let n_groups = ends.iter().filter(|end| **end <= n_boxes).count();
            if n_shown < n_groups && n_groups < ends.len() {
                n_shown = n_groups;
                show(drawn, n_groups, n_boxes);
            }
        })?;
        Ok(self.finished(drawn))
    }

    /// Nothing, and for each group the overviews of it and of all behind it.
    fn backdrops(
        &self,
        parts: &[&Part],
        frame: &FrameHandle,
    ) -> Result<(Image, Vec<Backdrop>), DividedError> {
        let mut scene = frame_scene(&self.opened.scene).map_err(RenderError::from)?.into_owned();
        scene.image.background = [0.0; 4];
        let blank = Image::filled(scene.image.width, scene.image.height, [0.0; 4]);
        let (mut painter, mut behind) =
            (Painter::new(&self.backend, self.n_threads), blank.clone());
        let mut backdrops = Vec::with_capacity(parts.len());
        for (idx, part) in parts.iter().rev().enumerate() {
            let [first, last] = [idx, idx + 1].map(|n| n as f32 / parts.len() as f32);
            let of = frame.part(first..last);
            let drawn = painter.draw(&scene, part, &blank, &of)?;
            let pixels = behind.pixels_mut().iter_mut().zip(drawn.image.pixels());
            pixels.for_each(|(behind, front)| *behind = over(*front, *behind));
            backdrops.push(Backdrop::of(&behind));
        }
        backdrops.reverse();
        Ok((blank, backdrops))
    }
}
