//! All that a viewer knows without a window: what is open and what becomes of it.
//!
//! Reading order: `history`, `document`, `layers`, `channels`, `presets`,
//! `seen`; `camera_moves`, `touch`, `pick`; `curve`, `cut`;
//! `frame_budget`, `pacing`, `thinned`,
//! `thumbnails`.

mod camera_moves;
mod channels;
mod curve;
mod cut;
mod document;
mod frame_budget;
mod history;
mod layers;
mod pacing;
mod pick;
mod presets;
mod seen;
mod thinned;
mod thumbnails;
mod touch;

pub use camera_moves::{
    ViewPoint, centered_on, height_at_target, orbited, panned, ray, rolled, seen_at, slid,
    with_projection_switched, zoomed,
};
pub use channels::Channel;
pub use curve::{Curve, span, stretched, with_result};
pub use cut::Cut;
pub use document::{Document, State};
pub use frame_budget::FrameBudget;
pub use history::History;
#[cfg(target_arch = "wasm32")]
pub(crate) use layers::Bytes;
pub use layers::are_apart;
pub use pacing::{Asked, Pacing};
pub use pick::{Picked, picked};
pub use presets::NoteIdx;
pub use thumbnails::{THUMBNAIL_SIDE, Thumbnails, thumbnail};
pub use touch::{Touch, touched};
