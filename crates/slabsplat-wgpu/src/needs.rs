//! What the shaders need of a device, and how a program that opens one for more than them asks for it.

use wgpu::Limits;

/// A limit that the shaders would run into.
struct Need {
    /// What it is of.
    what: &'static str,
    least: u64,
    of: fn(&Limits) -> u64,
}

/// WebGPU promises all of them; what browsers without it have, and old devices, does not.
const NEEDS: &[Need] = &[
    Need {
        what: "storage buffers in a shader stage",
        least: 8,
        of: |limits| limits.max_storage_buffers_per_shader_stage.into(),
    },
    Need {
        what: "invocations in a workgroup",
        least: 256,
        of: |limits| limits.max_compute_invocations_per_workgroup.into(),
    },
    Need {
        what: "invocations in a row of a workgroup",
        least: 256,
        of: |limits| limits.max_compute_workgroup_size_x.into(),
    },
    Need {
        what: "workgroups in a row",
        least: 65535,
        of: |limits| limits.max_compute_workgroups_per_dimension.into(),
    },
    Need {
        what: "bytes that a workgroup shares",
        least: 16 << 10,
        of: |limits| limits.max_compute_workgroup_storage_size.into(),
    },
    Need {
        what: "bytes of a uniform buffer",
        least: 16 << 10,
        of: |limits| limits.max_uniform_buffer_binding_size,
    },
    Need {
        what: "bytes of a storage buffer",
        least: 1 << 20,
        of: |limits| limits.max_storage_buffer_binding_size,
    },
];

/// What a device with these limits lacks, as the end of a sentence; `None` if it runs the shaders.
pub(crate) fn missing(limits: &Limits) -> Option<String> {
    let too_low = NEEDS.iter().filter(|need| (need.of)(limits) < need.least);
    let lacks: Vec<String> = too_low
        .map(|need| format!("{} {} (it has {})", need.least, need.what, (need.of)(limits)))
        .collect();
    (!lacks.is_empty()).then(|| lacks.join(", "))
}

/// The caller's descriptor of a device, and all that frames take added, as far as the adapter has it: limits
/// of what shaders use, buffers as large as they come, and timestamps. Nothing that it asks for already is
/// taken back.
///
/// A device that was requested without it may do, too: WebGPU's default limits have room for volumes of 128
/// MiB, and frames are not timed then.
///
/// ```
/// # async fn request(adapter: &wgpu::Adapter) -> Result<(), wgpu::RequestDeviceError> {
/// # use slabsplat_wgpu::wgpu;
/// let own = wgpu::DeviceDescriptor { label: Some("window"), ..Default::default() };
/// let descriptor = slabsplat_wgpu::device_descriptor(adapter, own);
/// let (device, queue) = adapter.request_device(&descriptor).await?;
/// # Ok(())
/// # }
/// ```
pub fn device_descriptor<'a>(
    adapter: &wgpu::Adapter,
    own: wgpu::DeviceDescriptor<'a>,
) -> wgpu::DeviceDescriptor<'a> {
    wgpu::DeviceDescriptor {
        required_features: own.required_features | features(adapter.features()),
        required_limits: own.required_limits.or_better_values_from(&limits(&adapter.limits())),
        ..own
    }
}

/// What frames ask for: large buffers, finely cut, and else no more than WebGPU promises.
pub(crate) fn limits(adapter: &Limits) -> Limits {
    Limits {
        max_buffer_size: adapter.max_buffer_size,
        max_storage_buffer_binding_size: adapter.max_storage_buffer_binding_size,
        min_storage_buffer_offset_alignment: adapter.min_storage_buffer_offset_alignment,
        min_uniform_buffer_offset_alignment: adapter.min_uniform_buffer_offset_alignment,
        // A device may fall short of WebGPU where we do not care, with textures for instance.
        ..Limits::default().or_worse_values_from(adapter)
    }
}

/// What of these features frames use.
pub(crate) fn features(of_adapter: wgpu::Features) -> wgpu::Features {
    of_adapter & wgpu::Features::TIMESTAMP_QUERY
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn needs_are_what_webgpu_promises() {
        let promised = Limits::default();
        assert_eq!(missing(&promised), None);
        assert!(limits(&promised).check_limits(&promised));
    }

    #[test]
    fn needs_are_named_if_they_are_missing() {
        let few = Limits { max_storage_buffers_per_shader_stage: 4, ..Limits::default() };
        let sentence = "8 storage buffers in a shader stage (it has 4)";
        assert_eq!(missing(&few).as_deref(), Some(sentence));
        for old in [Limits::downlevel_defaults(), Limits::downlevel_webgl2_defaults()] {
            assert!(missing(&old).is_some(), "{old:?}");
        }
    }

    #[test]
    fn limits_are_no_more_than_there_are() {
        let modest = Limits { max_texture_dimension_2d: 4096, ..Limits::default() };
        assert!(limits(&modest).check_limits(&modest));
    }
}
