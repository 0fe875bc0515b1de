//! Finding the devices and opening one. Devices are chosen by what they can do, never by their names.

use crate::{WgpuDevice, gpu::Gpu, ready};
use slabsplat_gpu::{DeviceInfo, DeviceKind, OpenOptions, Unavailable};

/// All devices that can run the shaders, the best first.
///
/// # Errors
/// If there is none.
pub fn devices() -> Result<Vec<DeviceInfo>, Unavailable> {
    let adapters = ready::at_once(adapters(&OpenOptions::default())).ok_or_else(would_wait)??;
    Ok(adapters.iter().map(device_info).collect())
}

/// Opens the first of [`devices`].
///
/// With [`OpenOptions::validation`], wgpu switches on the layers of the interface below it. It hands their
/// messages to the `log` crate, with targets that begin with `wgpu_hal`, and only those of the level that
/// `log` had when the device was opened: so who wants to see them installs a logger first. What is called
/// with every message from here are wgpu's own errors.
///
/// # Errors
/// If there is none, or it does not open.
pub fn open(options: &OpenOptions) -> Result<WgpuDevice, Unavailable> {
    ready::at_once(open_async(options)).ok_or_else(would_wait)?
}

/// [`open`] for where opening a device needs waiting: in a browser.
///
/// # Errors
/// If there is none, or it does not open.
pub async fn open_async(options: &OpenOptions) -> Result<WgpuDevice, Unavailable> {
    let adapters = adapters(options).await?;
    let best = &adapters[0];
    let descriptor = wgpu::DeviceDescriptor {
        label: Some("slabsplat"),
        required_features: features(best),
        required_limits: limits(&best.limits()),
        ..wgpu::DeviceDescriptor::default()
    };
    let (device, queue) = best.request_device(&descriptor).await.map_err(|error| Unavailable {
        reason: format!("wgpu cannot open {}: {error}", best.get_info().name),
    })?;
    Ok(WgpuDevice::new(Gpu::new(device, queue, device_info(best), options.validation)))
}

fn would_wait() -> Unavailable {
    Unavailable { reason: "wgpu has to wait for its device here, and nobody waits".to_owned() }
}

/// The adapters that can run the shaders, the best first: at least one.
async fn adapters(options: &OpenOptions) -> Result<Vec<wgpu::Adapter>, Unavailable> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        // Not OpenGL: its compute shaders are not as able everywhere.
        backends: wgpu::Backends::PRIMARY,
        // Without `DEBUG` nobody hears what the validation says. It also puts the shaders' sources into
        // their SPIR-V, which some versions of Vulkan's validation layer complain of.
        flags: match options.validation {
            Some(_) => wgpu::InstanceFlags::VALIDATION | wgpu::InstanceFlags::DEBUG,
            None => wgpu::InstanceFlags::empty(),
        },
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    let mut adapters = instance.enumerate_adapters(wgpu::Backends::PRIMARY).await;
    let n_found = adapters.len();
    adapters.retain(|adapter| is_able(&adapter.limits()));
    adapters.sort_by_key(|adapter| device_kind(adapter.get_info().device_type));
    match (n_found, adapters.is_empty()) {
        (_, false) => Ok(adapters),
        (0, true) => Err(Unavailable { reason: "wgpu finds no graphics device".to_owned() }),
        (1.., true) => Err(Unavailable {
            reason: format!("of {n_found} graphics devices that wgpu finds, none runs the shaders"),
        }),
    }
}

/// Whether a device with these limits can run the shaders.
fn is_able(limits: &wgpu::Limits) -> bool {
    256 <= limits.max_compute_invocations_per_workgroup
        && 256 <= limits.max_compute_workgroup_size_x
        && 65535 <= limits.max_compute_workgroups_per_dimension
        && 8 <= limits.max_storage_buffers_per_shader_stage
        && (16 << 10) <= limits.max_compute_workgroup_storage_size
}

/// What is asked for: large buffers, finely cut, and else no more than WebGPU promises.
fn limits(adapter: &wgpu::Limits) -> wgpu::Limits {
    wgpu::Limits {
        max_buffer_size: adapter.max_buffer_size,
        max_storage_buffer_binding_size: adapter.max_storage_buffer_binding_size,
        min_storage_buffer_offset_alignment: adapter.min_storage_buffer_offset_alignment,
        min_uniform_buffer_offset_alignment: adapter.min_uniform_buffer_offset_alignment,
        // A device may fall short of WebGPU where we do not care, with textures for instance.
        ..wgpu::Limits::default().or_worse_values_from(adapter)
    }
}

fn features(adapter: &wgpu::Adapter) -> wgpu::Features {
    adapter.features() & wgpu::Features::TIMESTAMP_QUERY
}

fn device_info(adapter: &wgpu::Adapter) -> DeviceInfo {
    let (about, limits) = (adapter.get_info(), adapter.limits());
    let alignment =
        limits.min_storage_buffer_offset_alignment.max(limits.min_uniform_buffer_offset_alignment);
    let whole_words = |bytes: u64| bytes & !3;
    DeviceInfo {
        // Browsers do not say.
        name: if about.name.is_empty() { "WebGPU".to_owned() } else { about.name },
        driver: format!("{} {}", about.driver, about.driver_info).trim().to_owned(),
        kind: device_kind(about.device_type),
        max_binding_bytes: whole_words(limits.max_storage_buffer_binding_size),
        max_buffer_bytes: whole_words(limits.max_buffer_size),
        offset_alignment: u64::from(alignment),
        memory_bytes: None,
        has_timestamps: features(adapter).contains(wgpu::Features::TIMESTAMP_QUERY),
    }
}

fn device_kind(kind: wgpu::DeviceType) -> DeviceKind {
    match kind {
        wgpu::DeviceType::DiscreteGpu => DeviceKind::Discrete,
        wgpu::DeviceType::IntegratedGpu => DeviceKind::Integrated,
        wgpu::DeviceType::VirtualGpu => DeviceKind::Virtual,
        wgpu::DeviceType::Other => DeviceKind::Other,
        wgpu::DeviceType::Cpu => DeviceKind::Software,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn open_asks_for_what_webgpu_promises() {
        let promised = wgpu::Limits::default();
        assert!(is_able(&promised));
        assert!(limits(&promised).check_limits(&promised));
        let few = wgpu::Limits { max_storage_buffers_per_shader_stage: 4, ..promised.clone() };
        assert!(!is_able(&few));
    }

    #[test]
    fn open_asks_for_no_more_than_there_is() {
        let modest = wgpu::Limits { max_texture_dimension_2d: 4096, ..wgpu::Limits::default() };
        assert!(limits(&modest).check_limits(&modest));
    }
}
