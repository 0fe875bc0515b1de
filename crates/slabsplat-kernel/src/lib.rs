//! Reconstruction kernels, what a slab cuts out of them, and tables of that.
//!
//! A voxel is a 3D [`Kernel`], a ball of finite radius in index space. A slab parallel to the image
//! cuts a *section* out of it, whose line integrals ([`SectionDesc`]) are what the paper sums in a
//! sheet (§3.2). Exact integrals are slow, so they are sampled once a slab width into a
//! [`SectionTable`]; the two traditional methods use the [`FootprintTable`] of the whole kernel.
//! [`FootprintShape`] says how a grid that is neither cubic nor upright bends all this.
//!
//! Nothing here knows voxels, images or colours. A new kernel implements [`Kernel`]. It is added to the
//! [`Kernels`] of who draws with it; a built-in one joins the list in `kernel.rs`, and nothing else changes.
//!
//! # Reading order
//!
//! `kernel`, `gaussian`, `crawfis_max`, `kernels`; `section`, `hierarchy`; `error_budget`, `split_levels`,
//! `detail_levels`;
//! `section_table`, `cubic_section_table`, `footprint_table`, `radial_polynomials`, `separable_sections`,
//! `separable_shapes`, `tilted_sections`; `footprint_shape`.
//!
//! ```
//! use slabsplat_core::{Lookup, Normalization};
//! use slabsplat_kernel::{SectionDesc, SectionTable, TableDesc, kernel_named};
//!
//! let kernel = kernel_named("gaussian")?;
//! let desc = SectionDesc {
//!     kernel: &*kernel,
//!     width: 1.0,
//!     kappa: 1.0,
//!     normalization: Normalization::None,
//!     base_width: 0.5,
//! };
//! let table = TableDesc { sections: 128, radial_samples: 128, lookup: Lookup::Linear };
//! let table = SectionTable::new(&desc, table);
//! let (rho, front) = (0.3, -0.5);
//! let exact = desc.weight(rho, front);
//! let sampled = table.sample(rho as f32, front as f32, (front + 1.0) as f32);
//! assert!((f64::from(sampled) - exact).abs() < 1e-4);
//! # Ok::<(), slabsplat_kernel::UnknownKernel>(())
//! ```

mod kernel;

mod crawfis_max;
mod gaussian;
mod kernels;

mod hierarchy;
mod section;

mod detail_levels;
mod error_budget;
mod split_levels;

mod cubic_section_table;
mod footprint_table;
mod radial_polynomials;
mod section_table;
mod separable_sections;
mod separable_shapes;
mod tilted_sections;

mod footprint_shape;

pub use crawfis_max::CrawfisMax;
pub use cubic_section_table::CubicSectionTable;
pub use detail_levels::{CellDifferences, CellLimits, DetailLevels, LitDifferences, ShareByCells};
pub use error_budget::ErrorBudget;
pub use footprint_shape::FootprintShape;
pub use footprint_table::FootprintTable;
pub use gaussian::Gaussian;
pub use kernel::{KERNEL_NAMES, Kernel, MAX_RADIUS, UnknownKernel, kernel_named};
pub use kernels::{KernelError, Kernels};
pub use radial_polynomials::{Degree, MAX_COEFFICIENTS, RadialPolynomials, chord_units_per_index};
pub use section::SectionDesc;
pub use section_table::{RowMap, SectionTable, TableDesc, lerp_radial};
pub use separable_sections::SeparableSections;
pub use separable_shapes::SeparableShapes;
pub use split_levels::{KernelTails, SlabSplit, SplitLevels, SplitView};
pub use tilted_sections::TiltedSections;
