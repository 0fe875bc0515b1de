//! The graphics interfaces of this build: how their devices are listed and opened.

use super::FoundDevice;
use super::gpu::{Gpu, Opened};
use slabsplat_gpu::{Device, DeviceInfo, DeviceKind, GpuBackend, OpenOptions, Unavailable};

#[cfg(feature = "ash")]
pub(super) const ASH: Gpu = Gpu {
    name: "ash",
    devices: || found(slabsplat_ash::devices()),
    open: || Box::pin(async { opened("ash", slabsplat_ash::open(&OpenOptions::default())) }),
};

#[cfg(feature = "wgpu")]
pub(super) const WGPU: Gpu = Gpu {
    name: "wgpu",
    devices: || found(slabsplat_wgpu::devices()),
    open: || {
        Box::pin(async {
            opened("wgpu", slabsplat_wgpu::open_async(&OpenOptions::default()).await)
        })
    },
};

fn opened<D: Device + 'static>(
    name: &'static str,
    device: Result<D, Unavailable>,
) -> Result<Opened, String> {
    let device = device.map_err(|unavailable| unavailable.reason)?;
    let is_fast = known_to_be_fast(device.info().kind);
    Ok(Opened { backend: Box::new(GpuBackend::new(name, device)), is_fast })
}

fn found(devices: Result<Vec<DeviceInfo>, Unavailable>) -> Result<Vec<FoundDevice>, String> {
    let devices = devices.map_err(|unavailable| unavailable.reason)?;
    Ok(devices.into_iter().map(found_device).collect())
}

fn found_device(info: DeviceInfo) -> FoundDevice {
    FoundDevice {
        name: info.name,
        driver: Some(info.driver),
        kind: kind_name(info.kind),
        is_fast: is_fast(info.kind),
        max_binding_bytes: Some(info.max_binding_bytes),
        memory_bytes: info.memory_bytes,
        is_timed: info.has_timestamps,
    }
}

/// Whether it may beat the CPU.
pub(crate) fn is_fast(kind: DeviceKind) -> bool {
    known_to_be_fast(kind) != Some(false)
}

/// Whether it beats the CPU, if that is known.
fn known_to_be_fast(kind: DeviceKind) -> Option<bool> {
    match kind {
        DeviceKind::Discrete => Some(true),
        // Browsers say nothing of a card, give a program one thread, and cannot wait for a race.
        DeviceKind::Integrated | DeviceKind::Virtual | DeviceKind::Other => {
            cfg!(target_family = "wasm").then_some(true)
        }
        DeviceKind::Software => Some(false),
    }
}

fn kind_name(kind: DeviceKind) -> &'static str {
    match kind {
        DeviceKind::Discrete => "discrete",
        DeviceKind::Integrated => "integrated",
        DeviceKind::Virtual => "virtual",
        DeviceKind::Other => "other",
        DeviceKind::Software => "software",
    }
}
