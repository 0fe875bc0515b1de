//! What is drawn onto a picture that is finished: text, for now.
//!
//! Everything is drawn onto an [`Image`](slabsplat_core::Image) of premultiplied floats, anti-aliased at whatever
//! size, and with a halo in the contrasting colour, so that it is legible before anything, also where the picture
//! is transparent. Nothing is drawn outside of the picture, and nothing here reads a file or renders.
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
//! draw_text(&mut image, &Label { text: "20 µm", at, anchor: [0.5, 1.0], size_pixels: 16.0, ink });
//! assert!(image.pixels().iter().any(|pixel| 0.9 < pixel[0]));
//! ```
//!
//! # Reading order
//!
//! `ink`, `coverage`, `text`.

mod coverage;
mod ink;
mod text;

pub use ink::Ink;
pub use text::{Label, draw_text, lacks, measure_text, text_size};
