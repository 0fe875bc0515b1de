//! The logical device, which everything else is made with and holds on to.

use crate::choose::Candidate;
use crate::instance::Instance;
use ash::ext::debug_utils;
use ash::khr::pipeline_executable_properties;
use ash::vk;
use slabsplat_gpu::Unavailable;
use std::ffi::CString;

/// A device with one queue. It goes when the last object that was made with it has gone.
pub(crate) struct Context {
    /// The functions of the device.
    pub(crate) functions: ash::Device,
    pub(crate) queue: vk::Queue,
    pub(crate) candidate: Candidate,
    pub(crate) instance: Instance,
    /// How pipelines are made.
    pub(crate) pipeline_flags: vk::PipelineCreateFlags,
    labels: Option<debug_utils::Device>,
}

impl Context {
    pub(crate) fn new(instance: Instance, candidate: Candidate) -> Result<Self, Unavailable> {
        Self::with(instance, candidate, vk::PipelineCreateFlags::empty())
    }

    /// One whose pipelines tell what was compiled.
    pub(crate) fn telling(instance: Instance, candidate: Candidate) -> Result<Self, Unavailable> {
        Self::with(instance, candidate, TELLING)
    }

    fn with(
        instance: Instance,
        candidate: Candidate,
        pipeline_flags: vk::PipelineCreateFlags,
    ) -> Result<Self, Unavailable> {
        let functions = create(&instance, &candidate, pipeline_flags).map_err(|result| {
            let reason = format!("{} could not be opened: {result}", candidate.info.name);
            Unavailable { reason }
        })?;
        // SAFETY: the device was made with one queue of this family.
        let queue = unsafe { functions.get_device_queue(candidate.queue_family, 0) };
        let labels =
            instance.has_labels.then(|| debug_utils::Device::new(&instance.functions, &functions));
        Ok(Self { functions, queue, candidate, instance, pipeline_flags, labels })
    }

    /// Names an object for debuggers, if they are listening.
    pub(crate) fn name<T: vk::Handle>(&self, object: T, name: &str) {
        let Some(labels) = &self.labels else { return };
        let Ok(name) = CString::new(name) else { return };
        let info =
            vk::DebugUtilsObjectNameInfoEXT::default().object_handle(object).object_name(&name);
        // SAFETY: callers name what they have just made, and the extension is switched on. A name that
        // could not be kept is no loss.
        let _ = unsafe { labels.set_debug_utils_object_name(&info) };
    }

    /// Begins a label among commands, if debuggers are listening.
    pub(crate) fn begin_label(&self, commands: vk::CommandBuffer, label: &str) {
        let Some(labels) = &self.labels else { return };
        let label = CString::new(label).unwrap_or_default();
        let info = vk::DebugUtilsLabelEXT::default().label_name(&label);
        // SAFETY: the commands are being recorded, and the extension is switched on.
        unsafe { labels.cmd_begin_debug_utils_label(commands, &info) };
    }

    /// Ends the label that began last.
    pub(crate) fn end_label(&self, commands: vk::CommandBuffer) {
        let Some(labels) = &self.labels else { return };
        // SAFETY: the commands are being recorded, and the extension is switched on.
        unsafe { labels.cmd_end_debug_utils_label(commands) };
    }

    /// Waits for all that was submitted, or until the driver says that the device is lost.
    pub(crate) fn wait_idle(&self) {
        // SAFETY: the device is alive, and its queue is used by one thread at a time: whoever waits has
        // the only reference to the `AshDevice`. That a lost device says so changes nothing.
        let _ = unsafe { self.functions.device_wait_idle() };
    }
}

impl Drop for Context {
    fn drop(&mut self) {
        // SAFETY: whatever was made with the device holds it in an `Arc`, so it is gone, and it waited
        // for the queue before.
        unsafe { self.functions.destroy_device(None) };
    }
}

/// What pipelines are made with to tell what was compiled.
const TELLING: vk::PipelineCreateFlags = vk::PipelineCreateFlags::from_raw(
    vk::PipelineCreateFlags::CAPTURE_STATISTICS_KHR.as_raw()
        | vk::PipelineCreateFlags::CAPTURE_INTERNAL_REPRESENTATIONS_KHR.as_raw(),
);

fn create(
    instance: &Instance,
    candidate: &Candidate,
    pipeline_flags: vk::PipelineCreateFlags,
) -> Result<ash::Device, vk::Result> {
    let queues = [vk::DeviceQueueCreateInfo::default()
        .queue_family_index(candidate.queue_family)
        .queue_priorities(&[1.0])];
    // A shader that reads past a buffer's end would otherwise read what it likes.
    let features =
        vk::PhysicalDeviceFeatures::default().robust_buffer_access(candidate.has_robust_access);
    let mut newer = vk::PhysicalDeviceVulkan12Features::default().timeline_semaphore(true);
    let mut tells = vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default()
        .pipeline_executable_info(true);
    let extensions = [pipeline_executable_properties::NAME.as_ptr()];
    let mut info = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_features(&features)
        .push_next(&mut newer);
    if pipeline_flags.contains(TELLING) {
        info = info.enabled_extension_names(&extensions).push_next(&mut tells);
    }
    // SAFETY: the candidate is this instance's and has the queue and the features, see `choose`. A device
    // that lacks the extension or its feature is not made: the driver says so.
    unsafe { instance.functions.create_device(candidate.handle, &info, None) }
}
