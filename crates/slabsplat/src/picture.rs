//! Frames made into pictures: what a scene's [`Finish`](slabsplat_core::Finish) says, done here for all
//! backends.
//!
//! A picture with several samples a pixel is drawn larger and averaged. What goes behind everything, a
//! gradient or the edges of axes, is put behind a frame that was drawn before nothing; where there is
//! neither, a frame has the bits that it always had.

use std::borrow::Cow;

use slabsplat_backend::Frame;
use slabsplat_core::{Acquisition, FinishError, FrameHandle, Image, Scene, over};

use crate::{RenderError, Renderer};

/// A frame that is finished.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Picture {
    /// The frame, with the image that it has become. What it drew and cost is that of all samples.
    pub frame: Frame,
    /// What is not drawn and why, and what people must know of what is, a line each.
    pub notes: Vec<String>,
    /// Whether the frame showed nothing but its background.
    pub is_blank: bool,
}

impl Renderer {
    /// Renders a frame of a scene and finishes it, as its [`finish`](Scene::finish) says. `acquisition` says
    /// how the first volume stands, and whether lengths are millimetres; annotations depend on it.
    ///
    /// ```
    /// use slabsplat::{Acquisition, Automatic, Finish, ImageDesc, RenderSettings, Renderer};
    ///
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let automatic = Automatic::new(slabsplat::io::builtin_volume("sphere", Some(16))?);
    /// let image = ImageDesc::new(32, 32);
    /// let finish = Finish::default().samples(4);
    /// let scene = automatic.scene(image, RenderSettings::default()).finish(finish);
    /// let picture = Renderer::open("cpu", |_| {})?.picture(&scene, Acquisition::default())?;
    /// assert_eq!((picture.frame.image.width(), picture.is_blank), (32, false));
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// As [`render`](Self::render), and if all samples are more than a frame has room for.
    pub fn picture(
        &mut self,
        scene: &Scene,
        acquisition: Acquisition,
    ) -> Result<Picture, RenderError> {
        self.picture_as(scene, acquisition, &FrameHandle::new())
    }

    /// The same by a handle, a clone of which watches the frame or cancels it from another thread.
    ///
    /// # Errors
    /// If the frame is cancelled, too.
    pub fn picture_as(
        &mut self,
        scene: &Scene,
        acquisition: Acquisition,
        frame: &FrameHandle,
    ) -> Result<Picture, RenderError> {
        let frame = self.render_as(&*frame_scene(scene)?, frame)?;
        Ok(finished(frame, scene, acquisition))
    }
}

/// The scene whose frame [`finished`] makes into a picture of `scene`, for who renders frames otherwise than
/// by [`Renderer::picture`].
///
/// # Errors
/// If all samples are more than a frame has room for.
pub fn frame_scene(scene: &Scene) -> Result<Cow<'_, Scene>, FinishError> {
    let sampled = scene.finish.sampled(&scene.image)?;
    let background = if has_behind(scene) { [0.0; 4] } else { sampled.background };
    let image = sampled.background(background);
    Ok(match image == scene.image {
        true => Cow::Borrowed(scene),
        false => Cow::Owned(scene.clone().image(image)),
    })
}

/// Makes the frame of [`frame_scene`] into a picture of `scene`.
///
/// # Panics
/// If the frame is of another size.
pub fn finished(frame: Frame, scene: &Scene, acquisition: Acquisition) -> Picture {
    let Frame { image, stats, cost, .. } = frame;
    let blank = if has_behind(scene) { [0.0; 4] } else { scene.image.premultiplied_background() };
    let is_blank = image.pixels().iter().all(|pixel| *pixel == blank);
    let mut image = averaged(image, scene.finish.samples_side());
    let size = [image.width(), image.height()];
    assert_eq!(size, [scene.image.width, scene.image.height], "the frame is of another scene");
    if has_behind(scene) {
        put_behind(&mut image, scene);
    }
    let notes = annotated(&mut image, scene, acquisition);
    Picture { frame: Frame::new(image, stats, cost), notes, is_blank }
}

/// Whether more than a colour is behind what the scene shows.
fn has_behind(scene: &Scene) -> bool {
    scene.finish.background_below.is_some() || scene.finish.annotations.axes
}

/// Each square of `side` × `side` pixels becomes one, their mean. They are premultiplied, so that what is
/// transparent has no part in colours.
fn averaged(image: Image, side: u32) -> Image {
    if side == 1 {
        return image;
    }
    let (width, side) = (image.width() as usize, side as usize);
    let mut averaged = Image::filled((width / side) as u32, image.height() / side as u32, [0.0; 4]);
    let share = 1.0 / (side * side) as f32;
    let rows = averaged.pixels_mut().chunks_exact_mut(width / side);
    for (row, samples) in rows.zip(image.pixels().chunks_exact(width * side)) {
        for row_of_samples in samples.chunks_exact(width) {
            for (pixel, samples) in row.iter_mut().zip(row_of_samples.chunks_exact(side)) {
                for sample in samples {
                    *pixel = [0, 1, 2, 3].map(|c| pixel[c] + share * sample[c]);
                }
            }
        }
    }
    averaged
}

/// Puts the background, and what of annotations lies behind all else, behind a picture.
fn put_behind(image: &mut Image, scene: &Scene) {
    let [width, height] = [image.width(), image.height()];
    let mut behind = Image::filled(width, height, [0.0; 4]);
    for (y, row) in behind.pixels_mut().chunks_exact_mut(width as usize).enumerate() {
        row.fill(scene.background_at((y as f32 + 0.5) / height as f32));
    }
    #[cfg(feature = "annotations")]
    slabsplat_annotations::draw_behind(&mut behind, scene);
    for (pixel, behind) in image.pixels_mut().iter_mut().zip(behind.pixels()) {
        *pixel = over(*pixel, *behind);
    }
}

#[cfg(feature = "annotations")]
fn annotated(image: &mut Image, scene: &Scene, acquisition: Acquisition) -> Vec<String> {
    slabsplat_annotations::annotate(image, scene, acquisition)
}

#[cfg(not(feature = "annotations"))]
fn annotated(_: &mut Image, scene: &Scene, _: Acquisition) -> Vec<String> {
    let note = || "this program was built without annotations: none are drawn".to_owned();
    if scene.finish.annotations.is_empty() { Vec::new() } else { vec![note()] }
}

#[cfg(test)]
mod tests;
