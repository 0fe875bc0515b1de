//! The sections that a slab cuts out of kernels (paper §3.2): from eight voxels at a time to the inner loop.
//!
//! Reading order: `span`, `shared`, `cut`, `band`, `batch`, `splat`.

mod band;
pub(crate) mod batch;
pub(crate) mod cut;
pub(crate) mod shared;
pub(crate) mod span;
pub(crate) mod splat;
