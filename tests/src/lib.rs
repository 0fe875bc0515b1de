//! What the tests of slabsplat measure against: a [`mod@reference`] renderer in 64-bit floats that uses no
//! tables, and scenes at random over every choice a scene can make ([`random_scene`]), judged by [`parity`];
//! [`render`] draws with every backend, and [`spy_device`] stands between a backend and its device, on which
//! [`on_devices`] runs tests; [`caller`] is somebody who has a device of wgpu's already.
//!
//! Nothing here is fast, and nothing here shares code with the renderer under test beyond the types
//! of `slabsplat-core`. The tests themselves are in `tests/tests/`.

pub mod reference;
pub mod render;

#[cfg(doctest)]
mod guide;

pub mod caller;

mod lent_device;
pub mod on_devices;
pub mod spy_device;

pub mod parity;
pub mod random_scene;

use slabsplat_core::RenderSettings;

/// Nothing is culled that is more than rounding, for tests that measure the rest: every section is splatted,
/// and only what lies behind 0.99999 is occluded.
pub fn exact_settings() -> RenderSettings {
    RenderSettings::default().opacity_cutoff(1.0 - 1e-5).tolerance(0.0)
}
