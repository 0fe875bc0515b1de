//! Separable footprints: a function of the column times one of the row, summed along rows last.
//!
//! All that there is to them is here: whoever deletes this folder, the arm that calls it in
//! `methods/slabs/advance.rs`, and the class of voxels that may be drawn so, has a slower renderer
//! and, to within the tolerance, the same pictures.
//!
//! Reading order: `footprint`, `b_spline`, `shear`, `slab`, `sections`.

pub(crate) mod b_spline;
mod footprint;
pub(crate) mod sections;
mod shear;
pub(crate) mod slab;
