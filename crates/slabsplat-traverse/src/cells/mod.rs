//! Cells, each of which may stand for 2³, 4³ or 8³ voxels (model §16): what is retained of them, how they are
//! made of voxels, and when.
//!
//! ```text
//! when a brick of 8³ cells is first seen:
//!     for each brick of voxels in it: list, classify; add what each voxel has to the sums of its cell
//!     a cell = Σμ, Σμ·colour, Σμ·normal, each over Σμ, in 8 bytes
//!     where cells are so opaque that a pixel sees few: Σμ·normal·normalᵀ over Σμ, in 8 bytes more
//! ```
//!
//! Nothing of a cell depends on the view or on light, so that a brick of them serves until the transfer
//! function changes.
//!
//! Reading order: `record`, `moments`, `sums`, `brick`, `cells16`, `lazy_bricks`, `retained`, `on_demand`.

mod brick;
mod cells16;
mod lazy_bricks;
mod moments;
mod on_demand;
mod record;
mod retained;
mod sums;

pub use brick::CellBrick;
pub use cells16::Cells16;
pub use moments::Moments;
pub(crate) use moments::along;
pub use on_demand::{BrickMaker, BrickRoom, BricksOnDemand, CELL_LEVELS};
pub use record::{CellRecord, CellValues};
