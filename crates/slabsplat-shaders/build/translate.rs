//! One stage through naga: parsed, validated, turned into SPIR-V.

use crate::assemble::Stage;
use crate::reflect::{Reflected, reflect};
use anyhow::{Result, anyhow};
use naga::back::spv;
use naga::valid::{Capabilities, ValidationFlags, Validator};

pub(crate) fn translate(stage: &Stage) -> Result<Reflected> {
    let module = naga::front::wgsl::parse_str(&stage.wgsl)
        .map_err(|error| anyhow!("{}", error.emit_to_string(&stage.wgsl)))?;
    // Nothing beyond what every WebGPU device has.
    let info = Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .map_err(|error| anyhow!("{}", error.emit_to_string(&stage.wgsl)))?;
    let spirv = spv::write_vec(&module, &info, &options(&module), None)?;
    reflect(stage, &module, spirv)
}

fn options(module: &naga::Module) -> spv::Options<'static> {
    let bindings = module.global_variables.iter().filter_map(|(_, variable)| variable.binding);
    let in_place = |at: naga::ResourceBinding| spv::BindingInfo {
        descriptor_set: at.group,
        binding: at.binding,
        binding_array_size: None,
    };
    spv::Options {
        lang_version: (1, 3),
        flags: spv::WriterFlags::empty(),
        fake_missing_bindings: false,
        binding_map: bindings.map(|at| (at, in_place(at))).collect(),
        // The shaders read nothing that they did not write, and to clear it first costs more than to use it.
        zero_initialize_workgroup_memory: spv::ZeroInitializeWorkgroupMemoryMode::None,
        force_loop_bounding: false,
        use_storage_input_output_16: false,
        ..spv::Options::default()
    }
}
