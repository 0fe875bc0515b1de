//! The feature `serde`: what a scene is made of, with the keys that it has in scene files.
//!
//! Volumes and meshes have none: a scene file names the files that they are in.
//!
//! Reading order: `settings` (tables of them), `angle`, `camera`, `light`, `transfer`, `transfer_2d`,
//! `curve`, `region`, `label_style`.

mod angle;
mod camera;
mod curve;
mod label_style;
mod light;
mod region;
mod settings;
mod transfer;
mod transfer_2d;

pub use angle::exact_degrees;
pub(crate) use camera::CameraKeys;
pub(crate) use label_style::LabelStyleKeys;
pub(crate) use region::RegionKeys;
pub use settings::{deserialize_settings, serialize_settings};
pub(crate) use transfer::{IsosurfaceKeys, TransferKeys, opaque, white};
pub(crate) use transfer_2d::{TransferBoxKeys, TransferImageKeys};

#[cfg(test)]
mod tests;
