//! Which of the machine's devices can do the work, by what they are able to do, and which is best.

use crate::instance::Instance;
use ash::vk;
use slabsplat_gpu::{DeviceInfo, DeviceKind, Unavailable};
use std::cmp::Reverse;
use std::ffi::CStr;

/// A device that can do the work.
#[derive(Clone, Debug)]
pub(crate) struct Candidate {
    pub(crate) handle: vk::PhysicalDevice,
    pub(crate) info: DeviceInfo,
    /// A family of queues that run compute shaders.
    pub(crate) queue_family: u32,
    /// How its timestamps count, if it has them.
    pub(crate) clock: Option<Clock>,
    /// Most bytes of a uniform buffer that a shader sees.
    pub(crate) max_uniform_bytes: u64,
    /// If reads and writes beyond a buffer's end can be made harmless.
    pub(crate) has_robust_access: bool,
}

/// How a device's timestamps count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Clock {
    pub(crate) ns_per_tick: f64,
    /// Bits that count; the others are to be ignored.
    pub(crate) mask: u64,
}

/// What every WebGPU device has, and the shaders therefore ask for.
const MIN_INVOCATIONS: u32 = 256;
const MIN_STORAGE_BUFFERS: u32 = 8;
const MIN_WORKGROUP_BYTES: u32 = 16 << 10;

/// All devices that can do the work, best first.
pub(crate) fn candidates(instance: &Instance) -> Result<Vec<Candidate>, Unavailable> {
    // SAFETY: the instance is alive.
    let handles = unsafe { instance.functions.enumerate_physical_devices() }.unwrap_or_default();
    let judged = handles.into_iter().map(|handle| judge(instance, handle));
    let (fit, unfit): (Vec<_>, Vec<_>) = judged.partition(Result::is_ok);
    let mut fit: Vec<Candidate> = fit.into_iter().flatten().collect();
    fit.sort_by_key(|candidate| (candidate.info.kind, Reverse(candidate.info.memory_bytes)));
    if fit.is_empty() {
        let reasons: Vec<String> = unfit.into_iter().filter_map(Result::err).collect();
        return Err(Unavailable { reason: nothing_fits(&reasons) });
    }
    Ok(fit)
}

fn nothing_fits(reasons: &[String]) -> String {
    if reasons.is_empty() {
        return "Vulkan finds no device on this machine".to_owned();
    }
    format!("no Vulkan device of this machine can do the work: {}", reasons.join("; "))
}

/// The device with its limits, or its name and what it lacks.
fn judge(instance: &Instance, handle: vk::PhysicalDevice) -> Result<Candidate, String> {
    // SAFETY: the handle is the instance's.
    let properties = unsafe { instance.functions.get_physical_device_properties(handle) };
    let name = text(properties.device_name_as_c_str());
    let lacks = |what: &str| format!("{name} lacks {what}");
    if properties.api_version < vk::API_VERSION_1_2 {
        return Err(lacks("Vulkan 1.2"));
    }
    check_limits(&properties.limits).map_err(lacks)?;
    let has_robust_access = check_features(instance, handle).map_err(lacks)?;
    let (queue_family, valid_bits) =
        queue_family(instance, handle).ok_or_else(|| lacks("a queue for compute shaders"))?;
    let clock = clock(properties.limits.timestamp_period, valid_bits);
    let more = MoreProperties::of(instance, handle, properties.api_version);
    let heap_bytes = device_heap_bytes(instance, handle);
    let limits = &properties.limits;
    let info = DeviceInfo {
        driver: more.driver,
        kind: kind(properties.device_type),
        max_binding_bytes: u64::from(limits.max_storage_buffer_range) & !3,
        max_buffer_bytes: more.max_buffer_bytes.min(heap_bytes) & !3,
        offset_alignment: limits
            .min_storage_buffer_offset_alignment
            .max(limits.min_uniform_buffer_offset_alignment)
            .max(4),
        memory_bytes: Some(heap_bytes),
        has_timestamps: clock.is_some(),
        name,
    };
    let max_uniform_bytes = u64::from(limits.max_uniform_buffer_range);
    Ok(Candidate { handle, info, queue_family, clock, max_uniform_bytes, has_robust_access })
}

fn check_limits(limits: &vk::PhysicalDeviceLimits) -> Result<(), &'static str> {
    if limits.max_compute_work_group_invocations < MIN_INVOCATIONS
        || limits.max_compute_work_group_size[0] < MIN_INVOCATIONS
    {
        return Err("workgroups of 256");
    }
    if limits.max_per_stage_descriptor_storage_buffers < MIN_STORAGE_BUFFERS {
        return Err("8 storage buffers in a shader");
    }
    if limits.max_compute_shared_memory_size < MIN_WORKGROUP_BYTES {
        return Err("16 KiB of workgroup memory");
    }
    Ok(())
}

/// Says if there is robust access to buffers.
fn check_features(instance: &Instance, handle: vk::PhysicalDevice) -> Result<bool, &'static str> {
    let mut newer = vk::PhysicalDeviceVulkan12Features::default();
    let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut newer);
    // SAFETY: the device has Vulkan 1.2, which its caller checked.
    unsafe { instance.functions.get_physical_device_features2(handle, &mut features) };
    let has_robust_access = features.features.robust_buffer_access == vk::TRUE;
    if newer.timeline_semaphore == vk::FALSE {
        return Err("timeline semaphores");
    }
    Ok(has_robust_access)
}

/// The first family that runs compute shaders, with the number of bits of its timestamps; one that has
/// timestamps goes first.
fn queue_family(instance: &Instance, handle: vk::PhysicalDevice) -> Option<(u32, u32)> {
    let families =
        // SAFETY: the handle is the instance's.
        unsafe { instance.functions.get_physical_device_queue_family_properties(handle) };
    (0..)
        .zip(&families)
        .filter(|(_, family)| family.queue_flags.contains(vk::QueueFlags::COMPUTE))
        .map(|(family_idx, family)| (family_idx, family.timestamp_valid_bits))
        .min_by_key(|(_, valid_bits)| *valid_bits == 0)
}

fn clock(ns_per_tick: f32, valid_bits: u32) -> Option<Clock> {
    if valid_bits == 0 || ns_per_tick <= 0.0 {
        return None;
    }
    let mask = u64::MAX >> 64_u32.saturating_sub(valid_bits);
    Some(Clock { ns_per_tick: f64::from(ns_per_tick), mask })
}

fn kind(device_type: vk::PhysicalDeviceType) -> DeviceKind {
    match device_type {
        vk::PhysicalDeviceType::DISCRETE_GPU => DeviceKind::Discrete,
        vk::PhysicalDeviceType::INTEGRATED_GPU => DeviceKind::Integrated,
        vk::PhysicalDeviceType::VIRTUAL_GPU => DeviceKind::Virtual,
        vk::PhysicalDeviceType::CPU => DeviceKind::Software,
        _ => DeviceKind::Other,
    }
}

/// The greatest heap of the device's own memory, which buffers are in.
fn device_heap_bytes(instance: &Instance, handle: vk::PhysicalDevice) -> u64 {
    // SAFETY: the handle is the instance's.
    let memory = unsafe { instance.functions.get_physical_device_memory_properties(handle) };
    let heaps = memory.memory_heaps_as_slice().iter();
    let own = heaps.filter(|heap| heap.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL));
    own.map(|heap| heap.size).max().unwrap_or(0)
}

/// What newer versions of Vulkan tell.
struct MoreProperties {
    driver: String,
    max_buffer_bytes: u64,
}

impl MoreProperties {
    fn of(instance: &Instance, handle: vk::PhysicalDevice, device_version: u32) -> Self {
        let mut driver = vk::PhysicalDeviceDriverProperties::default();
        let mut allocations = vk::PhysicalDeviceMaintenance3Properties::default();
        let mut buffers = vk::PhysicalDeviceMaintenance4Properties::default();
        let mut all = vk::PhysicalDeviceProperties2::default()
            .push_next(&mut driver)
            .push_next(&mut allocations);
        let tells_of_buffers = vk::API_VERSION_1_3 <= device_version.min(instance.version);
        if tells_of_buffers {
            all = all.push_next(&mut buffers);
        }
        // SAFETY: the device has Vulkan 1.2, which its caller checked, or 1.3 for the last struct.
        unsafe { instance.functions.get_physical_device_properties2(handle, &mut all) };
        let name = text(driver.driver_name_as_c_str());
        let version = text(driver.driver_info_as_c_str());
        let max_allocation = allocations.max_memory_allocation_size;
        Self {
            driver: format!("{name} {version}").trim().to_owned(),
            max_buffer_bytes: if tells_of_buffers {
                max_allocation.min(buffers.max_buffer_size)
            } else {
                max_allocation
            },
        }
    }
}

fn text<E>(from_driver: Result<&CStr, E>) -> String {
    from_driver.unwrap_or_default().to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clock_ignores_bits_that_do_not_count() {
        assert_eq!(clock(1.0, 0), None);
        assert_eq!(clock(0.0, 64), None);
        assert_eq!(clock(2.0, 36).map(|clock| clock.mask), Some((1 << 36) - 1));
        assert_eq!(clock(2.0, 64).map(|clock| clock.mask), Some(u64::MAX));
    }

    #[test]
    fn choose_says_why_nothing_fits() {
        assert_eq!(nothing_fits(&[]), "Vulkan finds no device on this machine");
        let reason = nothing_fits(&["a lacks Vulkan 1.2".to_owned(), "b lacks x".to_owned()]);
        assert!(reason.ends_with(": a lacks Vulkan 1.2; b lacks x"));
    }
}
