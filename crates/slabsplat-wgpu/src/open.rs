//! Finding the devices and opening one. Devices are chosen by what they can do, never by their names.

use crate::{WgpuDevice, gpu::Gpu, needs, ready};
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
        required_features: needs::features(best.features()),
        required_limits: needs::limits(&best.limits()),
        ..wgpu::DeviceDescriptor::default()
    };
    let (device, queue) = best.request_device(&descriptor).await.map_err(|error| Unavailable {
        reason: format!("wgpu cannot open {}: {error}", best.get_info().name),
    })?;
    Ok(WgpuDevice::new(Gpu::of_our_own(device, queue, device_info(best), options.validation)))
}

/// A device that its owner has opened, and uses for more than frames: their windows, for instance.
/// [`device_descriptor`](crate::device_descriptor) says how it is asked for.
///
/// It stays its owner's: no handler of errors or of the loss of the device is set or replaced. What goes
/// wrong here is caught by error scopes, which are of this thread alone, and errors of the owner's pass by.
/// The owner may submit and poll meanwhile, on other threads too; the owner's callbacks may be called by a
/// poll from here, as by any.
///
/// # Errors
/// If the shaders do not run on it, with all that it lacks.
pub fn on(device: wgpu::Device, queue: wgpu::Queue) -> Result<WgpuDevice, Unavailable> {
    let (about, limits) = (device.adapter_info(), device.limits());
    if let Some(lacks) = needs::missing(&limits) {
        let reason = format!(
            "the device on {} was requested without what frames need: {lacks}; \
             `device_descriptor` adds it, where the adapter has it",
            about.name
        );
        return Err(Unavailable { reason });
    }
    let info = info_of(about, &limits, device.features());
    Ok(WgpuDevice::new(Gpu::of_a_caller(device, queue, info)))
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
    adapters.retain(|adapter| needs::missing(&adapter.limits()).is_none());
    adapters.sort_by_key(|adapter| device_kind(adapter.get_info().device_type));
    match (n_found, adapters.is_empty()) {
        (_, false) => Ok(adapters),
        (0, true) => Err(Unavailable { reason: "wgpu finds no graphics device".to_owned() }),
        (1.., true) => Err(Unavailable {
            reason: format!("of {n_found} graphics devices that wgpu finds, none runs the shaders"),
        }),
    }
}

fn device_info(adapter: &wgpu::Adapter) -> DeviceInfo {
    info_of(adapter.get_info(), &adapter.limits(), adapter.features())
}

fn info_of(
    about: wgpu::AdapterInfo,
    limits: &wgpu::Limits,
    features: wgpu::Features,
) -> DeviceInfo {
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
        has_timestamps: features.contains(wgpu::Features::TIMESTAMP_QUERY),
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
