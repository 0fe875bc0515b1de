//! Everything that decides a pixel, but for the volume itself (SPEC §8).

use crate::{Camera, ImageDesc, RenderSettings, Shading, TransferFunction};

/// A picture to be made of some volume.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Which values are visible, and in which colour.
    pub transfer: TransferFunction,
    /// What light does to them.
    pub shading: Shading,
    /// Where they are seen from.
    pub camera: Camera,
    /// Size and background of the picture.
    pub image: ImageDesc,
    /// How it is made.
    pub settings: RenderSettings,
}
