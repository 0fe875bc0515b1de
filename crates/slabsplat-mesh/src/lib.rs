//! Opaque meshes as a camera sees them: the depth and the lit colour at which each sample of a pixel ends
//! (model §14).
//!
//! ```text
//! for each vertex, in parallel: where it is in the view and in the image            (vertices.rs)
//! for each triangle, line and point, in parallel: cut it off at the near depth (clip.rs), toss it onto tiles
//! for each tile, in parallel:                                                       (tile.rs)
//!     for each triangle there: for each sample that it covers (coverage.rs): keep the nearest
//!     for each line and point there: likewise for each sample whose ray meets it (tube.rs)
//!     colour and light of what is kept                                              (surface.rs)
//! ```
//!
//! 1. Whether a triangle covers a sample is exact: two that share an edge leave no crack between them,
//!    however large, small or thin they are.
//! 2. Only what a ray ends at is shaded.
//! 3. Of a triangle between samples no edge is looked at: the rectangle around it holds none.
//! 4. The nearest hit is kept, and at one depth the least colour, so that neither the order of triangles nor
//!    that of meshes matters.
//!
//! What a hit is to a picture, and what becomes of volumes before and behind it, is not decided here.
//!
//! Reading order: `samples`; `vertices`, `clip`; `coverage`; `surface`, `tube`; `elements`, `tile`,
//! `rasterizer`; `seen`.

mod samples;

mod clip;
mod vertices;

mod coverage;

mod surface;
mod tube;

mod elements;
mod rasterizer;
mod seen;
mod tile;

#[cfg(test)]
mod tests;

pub use rasterizer::{HitsOnTile, Rasterizer};
pub use samples::N_SAMPLES;
pub use seen::SeenMeshes;
pub use tile::Hit;
