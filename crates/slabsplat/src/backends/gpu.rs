//! The backends on graphics cards, as `auto` sees them: something to open, or to pass over.

use super::{FoundDevice, NoBackend, race};
use slabsplat_backend::Backend;
use std::pin::Pin;

/// A graphics interface.
pub(super) struct Gpu {
    /// The name of the backend.
    pub(super) name: &'static str,
    /// What it could open, the best first, or why there is nothing.
    pub(super) devices: fn() -> Result<Vec<FoundDevice>, String>,
    /// Opens the best.
    pub(super) open: fn() -> Opening,
}

/// What becomes a backend: at once, but in browsers.
pub(super) type Opening = Pin<Box<dyn Future<Output = Result<Opened, String>> + Send>>;

/// A backend on a device.
pub(super) struct Opened {
    pub(super) backend: Box<dyn Backend>,
    /// Whether it is faster than the CPU backend, if its kind says so.
    pub(super) is_fast: Option<bool>,
}

impl Opened {
    /// The backend, if it beats the CPU.
    fn if_fast(mut self) -> Option<Box<dyn Backend>> {
        let is_fast = self.is_fast.unwrap_or_else(|| race::is_won_by(&mut *self.backend));
        is_fast.then_some(self.backend)
    }
}

/// Those of this build, in the order in which `auto` tries them.
pub(super) const GPUS: &[Gpu] = &[
    #[cfg(feature = "ash")]
    super::interfaces::ASH,
    #[cfg(feature = "wgpu")]
    super::interfaces::WGPU,
];

impl Gpu {
    /// The backend on any device.
    pub(super) async fn open_named(&self) -> Result<Box<dyn Backend>, NoBackend> {
        let unavailable = |reason| NoBackend::Unavailable { name: self.name, reason };
        (self.open)().await.map(|opened| opened.backend).map_err(unavailable)
    }

    /// The backend on a device that beats the CPU; `None` if there is none.
    ///
    /// # Errors
    /// If there is one but it cannot be opened, with a sentence about it.
    pub(super) async fn open_if_fast(&self) -> Result<Option<Box<dyn Backend>>, String> {
        // Opening comes first: where it succeeds, which is where time counts, listing the devices would
        // only start the driver twice.
        let reason = match (self.open)().await {
            Ok(opened) => return Ok(opened.if_fast()),
            Err(reason) => reason,
        };
        let found = (self.devices)().unwrap_or_default();
        match found.iter().find(|device| device.is_fast) {
            Some(device) => Err(format!(
                "the backend \"{}\" could not open {}: {reason}",
                self.name, device.name
            )),
            None => Ok(None),
        }
    }
}
