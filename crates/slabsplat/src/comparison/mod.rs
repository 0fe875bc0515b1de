//! Pictures of one scene by several settings, side by side, and by how much they differ.
//!
//! `vary` says which settings there are, `difference_picture` shows where two pictures differ, and with the
//! feature `annotations` `sheet` puts all of them into one.

mod difference_picture;
#[cfg(feature = "annotations")]
mod sheet;
mod vary;

pub use difference_picture::{difference_picture, gain_for};
#[cfg(feature = "annotations")]
pub use sheet::{Pane, Sheet, SheetDesc};
pub use vary::{MAX_VARIANTS, Variant, Vary, VaryError, variants};
