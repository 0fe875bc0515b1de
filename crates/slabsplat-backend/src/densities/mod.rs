//! What backends make of densities alike: values as sheets sum them, transfer functions as parts of rays are
//! classified by, and the numbers of model §§8 and 12.

mod value_scale;
mod weight_cells;

pub use value_scale::{ValueScale, finite_samples, finite_values};
pub use weight_cells::{WeightCell, steps, visible_densities, weight_cells};

/// Densities, scaled, lie between −1 and 1, and those between them not further outside than a third.
pub const END: f64 = 1.5;

/// Sums of 32-bit floats miss a density by less than this, scaled. A step of the transfer function that lies
/// on the value of a plateau must not be taken here and missed there, so that a density this far before a
/// step counts as on it.
pub const ROUNDING: f64 = 1.0 / (1 << 19) as f64;

/// Weights that no picture shows.
pub const NOTHING: f64 = 1e-9;

/// A gradient counts in full from this part of the range of values on, per `unit`: less is the noise of a
/// plateau, and a normal must not turn about within it.
pub const FAINT_GRADIENT: f64 = 1.0 / 256.0;

/// A sheet counts in full in a maximum or a minimum that holds this part of its thickness.
pub const FULL_PART: f64 = 1.0 / 16.0;

/// From where a sheet holds this part of its thickness, a surface begins to show, and counts in full from
/// where it holds that one: half way in between, half a voxel outside of the outermost ones, volumes end.
pub const FADING: [f64; 2] = [0.375, 0.625];
