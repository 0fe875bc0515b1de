//! A compute pipeline for each shader, made when the shader is first run.

use slabsplat_shaders::{Binding, BindingKind, Shader};
use std::collections::HashMap;

/// A shader, ready to run.
#[derive(Debug)]
pub(crate) struct Pipeline {
    pub(crate) pipeline: wgpu::ComputePipeline,
    pub(crate) layout: wgpu::BindGroupLayout,
}

/// All shaders that were run, by name.
#[derive(Debug, Default)]
pub(crate) struct Pipelines {
    by_name: HashMap<&'static str, Pipeline>,
}

impl Pipelines {
    pub(crate) fn get(&mut self, device: &wgpu::Device, shader: &'static Shader) -> &Pipeline {
        self.by_name.entry(shader.name).or_insert_with(|| make(device, shader))
    }
}

fn make(device: &wgpu::Device, shader: &Shader) -> Pipeline {
    let label = Some(shader.name);
    // Checked against leaving its buffers: a mistake in a shader may cost a frame, not the system.
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label,
        source: wgpu::ShaderSource::Wgsl(shader.wgsl.into()),
    });
    let entries: Vec<_> = (0..).zip(shader.bindings).map(layout_entry).collect();
    let layout = device
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label, entries: &entries });
    let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label,
        bind_group_layouts: &[Some(&layout)],
        immediate_size: 0,
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label,
        layout: Some(&pipeline_layout),
        module: &module,
        entry_point: Some(shader.name),
        compilation_options: wgpu::PipelineCompilationOptions {
            // The shaders read nothing that they did not write, and some drivers take a second to compile the
            // zeroing.
            zero_initialize_workgroup_memory: false,
            ..wgpu::PipelineCompilationOptions::default()
        },
        cache: None,
    });
    Pipeline { pipeline, layout }
}

fn layout_entry((number, binding): (u32, &Binding)) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding: number,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty: match binding.kind {
                BindingKind::Uniform => wgpu::BufferBindingType::Uniform,
                BindingKind::Read => wgpu::BufferBindingType::Storage { read_only: true },
                BindingKind::Written => wgpu::BufferBindingType::Storage { read_only: false },
            },
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    }
}
