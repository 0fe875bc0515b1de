//! Pictures on their way from the buffers that they are drawn in to a texture of the caller's.

use crate::WgpuDevice;
use crate::bind_groups::BindGroups;
use crate::buffers::Buffers;
use crate::gpu::Gpu;
use crate::target::PixelFormat;
use slabsplat_gpu::{BufferId, DeviceError, Picture, PictureBand, Slice};
use std::collections::HashMap;

/// Bytes from the parameters of one band to those of the next: every device can bind there.
const STRIDE: u64 = 256;

/// `present.wgsl`, `Params`.
type Params = [u32; 4];

const PARAMS_BYTES: u64 = size_of::<Params>() as u64;

/// What is used again from picture to picture.
#[derive(Debug, Default)]
pub(crate) struct Presenter {
    shader: Option<Shader>,
    pipelines: HashMap<PixelFormat, wgpu::RenderPipeline>,
    params: Option<BufferId>,
    written: Vec<Params>,
}

#[derive(Debug)]
struct Shader {
    module: wgpu::ShaderModule,
    group_layout: wgpu::BindGroupLayout,
    pipeline_layout: wgpu::PipelineLayout,
}

/// A texture to draw into.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Canvas<'a> {
    pub(crate) view: &'a wgpu::TextureView,
    pub(crate) format: PixelFormat,
}

impl WgpuDevice {
    /// Begins to draw the picture into a texture of its size.
    pub(crate) fn present(
        &mut self,
        picture: &Picture,
        canvas: Canvas<'_>,
    ) -> Result<(), DeviceError> {
        self.gpu.look_around()?;
        let params = self.write_params(picture)?;
        let Self { gpu, presenter, buffers, bind_groups, .. } = self;
        gpu.trying(|| {
            let (pipeline, layout) = presenter.pipeline(&gpu.device, canvas.format);
            let groups = groups(gpu, (bind_groups, buffers), layout, (picture, params));
            gpu.queue.submit([record(&gpu.device, pipeline, canvas, picture, &groups)]);
        })?;
        self.gpu.faults.check()
    }

    /// Where the parameters of the picture's bands are. They mostly are those of the last picture.
    fn write_params(&mut self, picture: &Picture) -> Result<BufferId, DeviceError> {
        let width = picture.size[0];
        let params_of = |band: &PictureBand| [width, band.rows.start, picture.is_whole_at, 0];
        let params: Vec<Params> = picture.bands.iter().map(params_of).collect();
        if self.presenter.written.len() < params.len()
            && let Some(too_small) = self.presenter.params.take()
        {
            self.bind_groups.forget(too_small);
            self.buffers.destroy(too_small);
            self.presenter.written.clear();
        }
        let id = match self.presenter.params {
            Some(id) => id,
            None => self.buffers.create(&self.gpu, "picture", STRIDE * params.len() as u64)?,
        };
        self.presenter.params = Some(id);
        let written = &mut self.presenter.written;
        written.resize(written.len().max(params.len()), Params::default());
        for (idx, (old, new)) in written.iter_mut().zip(params).enumerate() {
            if *old != new {
                let (buffer, bytes) = (self.buffers.get(id), new.map(u32::to_ne_bytes));
                let offset = STRIDE * idx as u64;
                let write = || self.gpu.queue.write_buffer(buffer, offset, bytes.as_flattened());
                self.gpu.noting(write);
                *old = new;
            }
        }
        Ok(id)
    }
}

impl Presenter {
    fn pipeline(
        &mut self,
        device: &wgpu::Device,
        format: PixelFormat,
    ) -> (&wgpu::RenderPipeline, &wgpu::BindGroupLayout) {
        let shader = self.shader.get_or_insert_with(|| Shader::new(device));
        let make = || make_pipeline(device, shader, format);
        (self.pipelines.entry(format).or_insert_with(make), &shader.group_layout)
    }
}

impl Shader {
    fn new(device: &wgpu::Device) -> Self {
        let label = Some("present");
        let module = device.create_shader_module(wgpu::include_wgsl!("present.wgsl"));
        let storage = wgpu::BufferBindingType::Storage { read_only: true };
        let kinds = [wgpu::BufferBindingType::Uniform, storage, storage];
        let entry = |(binding, ty)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
            count: None,
        };
        let entries: Vec<_> = (0..).zip(kinds).map(entry).collect();
        let group_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label,
            entries: &entries,
        });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label,
            bind_group_layouts: &[Some(&group_layout)],
            immediate_size: 0,
        });
        Self { module, group_layout, pipeline_layout }
    }
}

fn make_pipeline(
    device: &wgpu::Device,
    shader: &Shader,
    format: PixelFormat,
) -> wgpu::RenderPipeline {
    let entry_point = match format {
        PixelFormat::Rgba16Float | PixelFormat::Rgba32Float => "draw_floats",
        PixelFormat::Rgba8 { is_srgb: false } | PixelFormat::Bgra8 { is_srgb: false } => {
            "draw_bytes"
        }
        PixelFormat::Rgba8 { is_srgb: true } | PixelFormat::Bgra8 { is_srgb: true } => "draw_srgb",
    };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("present"),
        layout: Some(&shader.pipeline_layout),
        vertex: wgpu::VertexState {
            module: &shader.module,
            entry_point: Some("cover"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &shader.module,
            entry_point: Some(entry_point),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(format.of_wgpu().into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// A bind group for each band.
fn groups(
    gpu: &Gpu,
    (bind_groups, buffers): (&mut BindGroups, &Buffers),
    layout: &wgpu::BindGroupLayout,
    (picture, params): (&Picture, BufferId),
) -> Vec<wgpu::BindGroup> {
    let mut offset = 0;
    let group = |band: &PictureBand| {
        let params = Slice { buffer: params, offset, size: PARAMS_BYTES };
        offset += STRIDE;
        let bindings = [params, band.pixels, picture.counts];
        bind_groups.get(&gpu.device, buffers, ("present", layout), &bindings)
    };
    picture.bands.iter().map(group).collect()
}

fn record(
    device: &wgpu::Device,
    pipeline: &wgpu::RenderPipeline,
    canvas: Canvas<'_>,
    picture: &Picture,
    groups: &[wgpu::BindGroup],
) -> wgpu::CommandBuffer {
    let label = Some("slabsplat picture");
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label });
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label,
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: canvas.view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
        })],
        ..wgpu::RenderPassDescriptor::default()
    });
    pass.set_pipeline(pipeline);
    for (band, group) in picture.bands.iter().zip(groups) {
        let n_rows = band.rows.end - band.rows.start;
        pass.set_bind_group(0, group, &[]);
        pass.set_scissor_rect(0, band.rows.start, picture.size[0], n_rows);
        pass.draw(0..3, 0..1);
    }
    drop(pass);
    encoder.finish()
}
