//! Shaders, compiled by the driver when they are first used.

use crate::context::Context;
use crate::error::{Fault, during};
use ash::vk;
use slabsplat_shaders::{Binding, BindingKind, Shader};
use std::collections::HashMap;
use std::ffi::CString;
use std::sync::Arc;

/// Which shader: its address, for a comparison of shaders would compare their source.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct ShaderId(usize);

impl ShaderId {
    pub(crate) fn of(shader: &'static Shader) -> Self {
        Self(std::ptr::from_ref(shader).addr())
    }
}

/// What the driver made of a shader.
pub(crate) struct Pipeline {
    pub(crate) handle: vk::Pipeline,
    pub(crate) layout: vk::PipelineLayout,
    pub(crate) set_layout: vk::DescriptorSetLayout,
    context: Arc<Context>,
}

/// The pipelines of all shaders that were used.
pub(crate) struct Pipelines {
    by_shader: HashMap<ShaderId, Arc<Pipeline>>,
    /// Lets the driver find what shaders have in common.
    cache: vk::PipelineCache,
    context: Arc<Context>,
}

impl Pipelines {
    pub(crate) fn new(context: &Arc<Context>) -> Result<Self, Fault> {
        let info = vk::PipelineCacheCreateInfo::default();
        // SAFETY: the device is alive.
        let cache = unsafe { context.functions.create_pipeline_cache(&info, None) }
            .map_err(during("vkCreatePipelineCache"))?;
        Ok(Self { by_shader: HashMap::new(), cache, context: Arc::clone(context) })
    }

    /// The pipeline of a shader; the first time takes as long as the driver takes to compile it.
    pub(crate) fn get(&mut self, shader: &'static Shader) -> Result<Arc<Pipeline>, Fault> {
        if let Some(pipeline) = self.by_shader.get(&ShaderId::of(shader)) {
            return Ok(Arc::clone(pipeline));
        }
        let pipeline = Arc::new(Pipeline::new(&self.context, self.cache, shader)?);
        self.by_shader.insert(ShaderId::of(shader), Arc::clone(&pipeline));
        Ok(pipeline)
    }
}

impl Drop for Pipelines {
    fn drop(&mut self) {
        // SAFETY: nothing is being compiled with it any more.
        unsafe { self.context.functions.destroy_pipeline_cache(self.cache, None) };
    }
}

impl Pipeline {
    fn new(
        context: &Arc<Context>,
        cache: vk::PipelineCache,
        shader: &'static Shader,
    ) -> Result<Self, Fault> {
        // From here on, dropping it cleans up.
        let mut pipeline = Self {
            handle: vk::Pipeline::null(),
            layout: vk::PipelineLayout::null(),
            set_layout: vk::DescriptorSetLayout::null(),
            context: Arc::clone(context),
        };
        pipeline.set_layout = create_set_layout(context, shader.bindings)?;
        pipeline.layout = create_layout(context, pipeline.set_layout)?;
        let module = create_module(context, shader)?;
        let compiled = create_pipeline(context, cache, module, pipeline.layout, shader);
        // SAFETY: pipelines do not need their modules once they are made.
        unsafe { context.functions.destroy_shader_module(module, None) };
        pipeline.handle = compiled?;
        context.name(pipeline.handle, shader.name);
        Ok(pipeline)
    }
}

impl Drop for Pipeline {
    fn drop(&mut self) {
        let functions = &self.context.functions;
        // SAFETY: an `AshDevice` waits for the queue before it drops its parts; what was not made is
        // null, which is allowed.
        unsafe { functions.destroy_pipeline(self.handle, None) };
        // SAFETY: as above.
        unsafe { functions.destroy_pipeline_layout(self.layout, None) };
        // SAFETY: as above.
        unsafe { functions.destroy_descriptor_set_layout(self.set_layout, None) };
    }
}

/// How Vulkan calls what a shader does with a buffer.
pub(crate) fn descriptor_type(binding: &Binding) -> vk::DescriptorType {
    match binding.kind {
        BindingKind::Uniform => vk::DescriptorType::UNIFORM_BUFFER,
        BindingKind::Read | BindingKind::Written => vk::DescriptorType::STORAGE_BUFFER,
    }
}

fn create_set_layout(
    context: &Context,
    bindings: &[Binding],
) -> Result<vk::DescriptorSetLayout, Fault> {
    let bindings: Vec<_> = (0..)
        .zip(bindings)
        .map(|(number, binding)| {
            vk::DescriptorSetLayoutBinding::default()
                .binding(number)
                .descriptor_type(descriptor_type(binding))
                .descriptor_count(1)
                .stage_flags(vk::ShaderStageFlags::COMPUTE)
        })
        .collect();
    let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
    // SAFETY: the numbers differ, and are no more than every device has.
    unsafe { context.functions.create_descriptor_set_layout(&info, None) }
        .map_err(during("vkCreateDescriptorSetLayout"))
}

fn create_layout(
    context: &Context,
    set_layout: vk::DescriptorSetLayout,
) -> Result<vk::PipelineLayout, Fault> {
    let set_layouts = [set_layout];
    let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&set_layouts);
    // SAFETY: the set layout was made with this device.
    unsafe { context.functions.create_pipeline_layout(&info, None) }
        .map_err(during("vkCreatePipelineLayout"))
}

fn create_module(context: &Context, shader: &Shader) -> Result<vk::ShaderModule, Fault> {
    let info = vk::ShaderModuleCreateInfo::default().code(shader.spirv);
    // SAFETY: the code is valid SPIR-V: naga translated what it had validated.
    unsafe { context.functions.create_shader_module(&info, None) }
        .map_err(during("vkCreateShaderModule"))
}

fn create_pipeline(
    context: &Context,
    cache: vk::PipelineCache,
    module: vk::ShaderModule,
    layout: vk::PipelineLayout,
    shader: &Shader,
) -> Result<vk::Pipeline, Fault> {
    let entry_point = CString::new(shader.name).expect("names of shaders are names of files");
    let stage = vk::PipelineShaderStageCreateInfo::default()
        .stage(vk::ShaderStageFlags::COMPUTE)
        .module(module)
        .name(&entry_point);
    let info = vk::ComputePipelineCreateInfo::default()
        .flags(context.pipeline_flags)
        .stage(stage)
        .layout(layout);
    // SAFETY: module and layout come from the same shader and are alive; the device has the features
    // that the module asks for, see `choose`.
    let made = unsafe { context.functions.create_compute_pipelines(cache, &[info], None) };
    match made {
        Ok(pipelines) => Ok(pipelines[0]),
        // The one that was not made is null.
        Err((_, result)) => Err(during("vkCreateComputePipelines")(result)),
    }
}
