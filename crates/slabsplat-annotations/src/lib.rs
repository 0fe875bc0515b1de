//! What is drawn onto a picture that is finished: text anywhere, and for a scene that has
//! [`Annotations`](slabsplat_core::Annotations) its title, axes, a scale bar, a colour bar and an orientation
//! marker.
//!
//! Everything is drawn onto an [`Image`](slabsplat_core::Image) of premultiplied floats, anti-aliased at
//! whatever size, and with a halo in the contrasting colour, so that it is legible before anything, also
//! where the picture is transparent. Sizes follow the picture's. Nothing is drawn outside of the picture,
//! what has no room in it is left out and told of, and nothing here reads a file or renders.
//!
//! The font is bundled: Latin, Greek and Cyrillic of DejaVu Sans, whose licence is in `fonts/`.
//!
//! ```
//! use slabsplat_annotations::{Ink, Label, draw_text, measure_text};
//! use slabsplat_core::Image;
//!
//! let mut image = Image::filled(200, 100, [0.0, 0.0, 0.0, 1.0]);
//! let [width, height] = measure_text("20 µm", 16.0);
//! assert!(width < 200.0 && height < 20.0);
//! let at = [100.0, 95.0];
//! let ink = Ink::LIGHT;
//! draw_text(&mut image, &Label::new("20 µm", at).anchor([0.5, 1.0]).ink(ink));
//! assert!(image.pixels().iter().any(|pixel| 0.9 < pixel[0]));
//! ```
//!
//! # Reading order
//!
//! `ink`, `coverage`, `text`, `shapes`; `screen` (where the world is in the picture), `lengths`, `sheet`
//! (what lies on nothing else in it); `axes`, `scale_bar`, `color_key` (what colours mean), `color_bar`,
//! `orientation_marker`; `room` (what a picture has room for), `annotate` (all of them).

#![deny(clippy::exhaustive_enums, clippy::exhaustive_structs)]

mod coverage;
mod ink;
mod shapes;
mod text;

mod lengths;
mod screen;
mod sheet;

mod axes;
mod color_bar;
mod color_key;
mod orientation_marker;
mod scale_bar;

mod room;

mod annotate;

pub use annotate::{annotate, draw_behind};
pub use axes::axes_box;
pub use ink::Ink;
pub use room::{Insets, insets};
pub use text::{FONT, Label, draw_text, lacks, measure_text, text_size};
