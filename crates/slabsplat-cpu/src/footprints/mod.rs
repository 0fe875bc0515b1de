//! Footprints: where they lie, how they weigh pixels, and the inner loop that adds them to a sheet.
//!
//! Reading order: `raster`, `polynomials`, `weights`, `tilted`, `splat`, `whole`.

pub(crate) mod polynomials;
pub(crate) mod raster;
pub(crate) mod splat;
pub(crate) mod tilted;
pub(crate) mod weights;
pub(crate) mod whole;
