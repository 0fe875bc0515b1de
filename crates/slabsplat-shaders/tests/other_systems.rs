//! What becomes of the stages where there is neither Vulkan nor a browser: wgpu has them translated to HLSL
//! for Direct3D 12 and to MSL for Metal. Nobody here runs those, but that each stage has such a translation,
//! and what it must hold, can be told.

use naga::ShaderStage;
use naga::back::{hlsl, msl};
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use slabsplat_shaders::{ALL, Shader};

fn module_of(shader: &Shader) -> (naga::Module, ModuleInfo) {
    let module = naga::front::wgsl::parse_str(shader.wgsl).expect("it was read when it was built");
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
    let info = validator.validate(&module).expect("it was valid when it was built");
    (module, info)
}

/// Whether its threads wait for each other anywhere.
fn waits(shader: &Shader) -> bool {
    ["workgroupBarrier()", "workgroupUniformLoad("].iter().any(|call| shader.wgsl.contains(call))
}

/// As shader model 5.1, for the oldest compiler that wgpu uses.
#[test]
fn stages_have_a_translation_to_hlsl() {
    for shader in ALL {
        let (module, info) = module_of(shader);
        let entry_point = Some((ShaderStage::Compute, shader.name.to_owned()));
        let (options, of_pipeline) =
            (hlsl::Options::default(), hlsl::PipelineOptions { entry_point });
        let mut text = String::new();
        let mut writer = hlsl::Writer::new(&mut text, &options, &of_pipeline);
        let written = writer.write(&module, &info, None);
        let reflection = written.unwrap_or_else(|error| panic!("{}: {error}", shader.name));
        let names: Result<Vec<_>, _> = reflection.entry_point_names.into_iter().collect();
        assert_eq!(names.expect("its bindings are known").len(), 1, "{}", shader.name);
        let [x, y, z] = shader.workgroup_size;
        let n_threads = format!("[numthreads({x}, {y}, {z})]");
        assert!(text.contains(&n_threads), "{}: {n_threads}", shader.name);
        assert_eq!(text.contains("GroupMemoryBarrierWithGroupSync"), waits(shader));
    }
}

/// As MSL 2.0, of macOS 10.13 and iOS 11.
#[test]
fn stages_have_a_translation_to_msl() {
    for shader in ALL {
        let (module, info) = module_of(shader);
        let entry_point = Some((ShaderStage::Compute, shader.name.to_owned()));
        let of_pipeline = msl::PipelineOptions { entry_point, ..msl::PipelineOptions::default() };
        let options = msl::Options { lang_version: (2, 0), ..msl::Options::default() };
        let written = msl::write_string(&module, &info, &options, &of_pipeline);
        let (text, _) = written.unwrap_or_else(|error| panic!("{}: {error}", shader.name));
        assert!(text.contains("kernel void"), "{}", shader.name);
        assert_eq!(text.contains("threadgroup_barrier"), waits(shader));
    }
}
