//! What this machine has for each backend to run on.

use super::CPU;
use super::gpu::{GPUS, Gpu};

/// A backend of this build.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct FoundBackend {
    /// Its name.
    pub name: &'static str,
    /// What it can run on, the best first, or why there is nothing.
    pub devices: Result<Vec<FoundDevice>, String>,
}

/// Something that a backend can run on.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct FoundDevice {
    /// Its name, for people.
    pub name: String,
    /// The driver's name and version, if there is a driver.
    pub driver: Option<String>,
    /// `discrete`, `integrated`, `virtual` or `other` graphics card; `software` that plays one; `cpu`.
    pub kind: &'static str,
    /// Whether `auto` may take it. Software that plays a graphics card is slower than the CPU backend.
    pub is_fast: bool,
    /// Most bytes of a buffer that a shader sees at once, if there are shaders.
    pub max_binding_bytes: Option<u64>,
    /// Bytes of memory, if known.
    pub memory_bytes: Option<u64>,
    /// Whether frames tell how long their stages took.
    pub is_timed: bool,
}

impl FoundBackend {
    /// A backend, and what it can run on.
    pub fn new(name: &'static str, devices: Result<Vec<FoundDevice>, String>) -> Self {
        Self { name, devices }
    }
}

impl FoundDevice {
    /// A device that `auto` may take and of which no more is known.
    pub fn new(name: impl Into<String>, kind: &'static str) -> Self {
        Self {
            name: name.into(),
            driver: None,
            kind,
            is_fast: true,
            max_binding_bytes: None,
            memory_bytes: None,
            is_timed: false,
        }
    }
}

/// All backends of this build, in the order in which `auto` tries them, and what they can run on.
/// It asks every driver, which may take a tenth of a second each.
pub fn found_backends() -> Vec<FoundBackend> {
    let found = |gpu: &Gpu| FoundBackend::new(gpu.name, (gpu.devices)());
    GPUS.iter().map(found).chain(cpu()).collect()
}

fn cpu() -> Option<FoundBackend> {
    let backend = CPU?();
    let caps = backend.caps();
    let device = FoundDevice { is_timed: true, ..FoundDevice::new(caps.device.clone(), "cpu") };
    Some(FoundBackend::new(caps.name, Ok(vec![device])))
}
