//! Pixels: how a tile of the image and a sheet over it are stored, and how a sheet goes behind what is there.
//!
//! Reading order: `rectangle`, `quad`, `blocks`, `sheet`, `compositing`, `surfaces`, `tile`,
//! `ended_rays`, `tile_region`, `tiles`.

pub(crate) mod blocks;
mod compositing;
pub(crate) mod ended_rays;
pub(crate) mod quad;
pub(crate) mod rectangle;
pub(crate) mod sheet;
pub(crate) mod surfaces;
pub(crate) mod tile;
pub(crate) mod tile_region;
pub(crate) mod tiles;
