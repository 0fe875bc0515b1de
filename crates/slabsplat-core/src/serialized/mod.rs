//! The feature `serde`: what a scene is made of, with the keys that it has in scene files.
//!
//! Volumes and meshes have none: a scene file names the files that they are in.
//!
//! Reading order: `settings` (tables of them), `camera`, `light`, `transfer`, `region`.

mod camera;
mod light;
mod region;
mod settings;
mod transfer;

pub(crate) use camera::CameraKeys;
pub(crate) use region::RegionKeys;
pub use settings::{deserialize_settings, serialize_settings};
pub(crate) use transfer::{IsosurfaceKeys, TransferKeys, white};

#[cfg(test)]
mod tests;
