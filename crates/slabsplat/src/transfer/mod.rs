//! Transfer functions and the volumes that they show: fitting one to the other, and a picture of both.
//!
//! Reading order: `fit`, `percentiles`, `values` (which values a volume has), `plot`.

#[cfg(feature = "files")]
mod fit;
#[cfg(feature = "files")]
mod percentiles;
mod values;

mod plot;

#[cfg(feature = "files")]
pub(crate) use fit::{Fitted, fitted};
pub use plot::{plot_transfer, plotted_range};
pub use values::ValueCounts;
#[cfg(feature = "files")]
pub(crate) use values::{Bins, VolumeValues};
