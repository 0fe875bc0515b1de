//! Recording work: a compute pass a stage, then the copies to the read-back buffer, first what is read
//! and after it two timestamps a stage.

use crate::buffers::Buffers;
use crate::read_back::ReadBack;
use crate::timer::Timer;
use slabsplat_gpu::{Pass, Work};

/// Bytes of the two timestamps of a stage.
pub(crate) const BYTES_OF_STAGE: u64 = 2 * wgpu::QUERY_SIZE as u64;

/// All that work needs beside the caller's buffers.
#[derive(Debug)]
pub(crate) struct Prepared {
    /// For each pass.
    pub(crate) dispatches: Vec<(wgpu::ComputePipeline, wgpu::BindGroup)>,
    /// The stages of the passes.
    pub(crate) stages: Vec<&'static str>,
    /// If they can be timed.
    pub(crate) timer: Option<Timer>,
    /// If anything is read.
    pub(crate) read_back: Option<ReadBack>,
    /// Bytes that come back, those of the timestamps included.
    pub(crate) n_read_bytes: u64,
}

/// The stages of passes, in their order.
pub(crate) fn stages(passes: &[Pass]) -> Vec<&'static str> {
    by_stage(passes).map(|passes| passes[0].stage).collect()
}

fn by_stage(passes: &[Pass]) -> impl Iterator<Item = &[Pass]> {
    passes.chunk_by(|a, b| a.stage == b.stage)
}

/// Records the passes and the reads of work.
pub(crate) fn record(
    device: &wgpu::Device,
    buffers: &Buffers,
    work: &Work<'_>,
    prepared: &Prepared,
) -> wgpu::CommandBuffer {
    let label = Some("slabsplat work");
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label });
    let mut dispatches = prepared.dispatches.iter();
    for (number, passes) in by_stage(&work.passes).enumerate() {
        let mut compute = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(passes[0].stage),
            timestamp_writes: prepared.timer.as_ref().map(|timer| timer.around_stage(number)),
        });
        record_stage(&mut compute, passes, dispatches.by_ref());
    }
    if let Some(read_back) = &prepared.read_back {
        let mut end = 0;
        for slice in &work.reads {
            let from = buffers.get(slice.buffer);
            let to = &read_back.buffer;
            encoder.copy_buffer_to_buffer(from, slice.offset, to, end, slice.size);
            end += slice.size;
        }
        if let Some(timer) = &prepared.timer {
            timer.resolve(&mut encoder, prepared.stages.len(), &read_back.buffer, end);
        }
    }
    encoder.finish()
}

fn record_stage<'a>(
    compute: &mut wgpu::ComputePass<'_>,
    passes: &[Pass],
    dispatches: impl Iterator<Item = &'a (wgpu::ComputePipeline, wgpu::BindGroup)>,
) {
    let mut current = None;
    for (pass, (pipeline, group)) in passes.iter().zip(dispatches) {
        if current != Some(pass.shader.name) {
            compute.set_pipeline(pipeline);
            current = Some(pass.shader.name);
        }
        compute.set_bind_group(0, group, &[]);
        let [x, y, z] = pass.groups;
        compute.dispatch_workgroups(x, y, z);
    }
}

/// How long the stages took, from their timestamps.
pub(crate) fn stage_ms(
    stages: &[&'static str],
    timestamps: &[u8],
    period_ns: f32,
) -> Vec<(&'static str, f64)> {
    let (ticks, _) = timestamps.as_chunks::<8>();
    let (pairs, _) = ticks.as_chunks::<2>();
    let ms = |&[begin, end]: &[[u8; 8]; 2]| {
        // Devices are allowed to turn their clocks back.
        let n_ticks = u64::from_ne_bytes(end).saturating_sub(u64::from_ne_bytes(begin));
        n_ticks as f64 * f64::from(period_ns) * 1e-6
    };
    stages.iter().copied().zip(pairs.iter().map(ms)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stage_ms_counts_ticks() {
        let ticks = [1_000_000_u64, 3_000_000, 5, 4];
        let bytes: Vec<u8> = ticks.iter().flat_map(|tick| tick.to_ne_bytes()).collect();
        assert_eq!(stage_ms(&["a", "b"], &bytes, 0.5), [("a", 1.0), ("b", 0.0)]);
    }
}
