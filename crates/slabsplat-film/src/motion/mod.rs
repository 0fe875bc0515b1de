//! Scenes at moments: key frames, and what is between them.
//!
//! Reading order: `film` (what a film is), `turn` (one without key frames); `track` (times, easing, and how a
//! number goes from key to key), `camera`, `transfer`, `isosurfaces`, `region` (how all else does, by
//! numbers).

mod camera;
mod film;
mod isosurfaces;
mod region;
mod track;
mod transfer;
mod turn;

pub use film::{Film, Key, LayerKey, MotionError};
pub use turn::Turn;
