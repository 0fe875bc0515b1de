//! A list of commands for the queue, and the few commands that are used.

use crate::context::Context;
use crate::error::{Fault, during};
use crate::memory::Buffer;
use crate::pipelines::Pipeline;
use crate::sets::Set;
use ash::vk;
use std::sync::Arc;

/// What must be finished, and seen, before what comes next begins.
///
/// All barriers are global: buffers are few, a pass touches most of them, and no driver profits from more
/// detail on buffers. A barrier holds for everything that was submitted to the queue before it, so that
/// the first one of a list orders it after the lists before.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Barrier {
    after: (vk::PipelineStageFlags, vk::AccessFlags),
    before: (vk::PipelineStageFlags, vk::AccessFlags),
}

const PASSES_AND_COPIES: vk::PipelineStageFlags = vk::PipelineStageFlags::from_raw(
    vk::PipelineStageFlags::COMPUTE_SHADER.as_raw() | vk::PipelineStageFlags::TRANSFER.as_raw(),
);
const WRITTEN_BY_THEM: vk::AccessFlags = vk::AccessFlags::from_raw(
    vk::AccessFlags::SHADER_WRITE.as_raw() | vk::AccessFlags::TRANSFER_WRITE.as_raw(),
);
const TOUCHED_BY_PASSES: vk::AccessFlags = vk::AccessFlags::from_raw(
    vk::AccessFlags::SHADER_READ.as_raw()
        | vk::AccessFlags::SHADER_WRITE.as_raw()
        | vk::AccessFlags::UNIFORM_READ.as_raw(),
);
const TOUCHED_BY_COPIES: vk::AccessFlags = vk::AccessFlags::from_raw(
    vk::AccessFlags::TRANSFER_READ.as_raw() | vk::AccessFlags::TRANSFER_WRITE.as_raw(),
);

impl Barrier {
    /// Copies after passes and copies.
    pub(crate) const BEFORE_COPIES: Self = Self {
        after: (PASSES_AND_COPIES, WRITTEN_BY_THEM),
        before: (vk::PipelineStageFlags::TRANSFER, TOUCHED_BY_COPIES),
    };
    /// Passes after passes and copies.
    pub(crate) const BEFORE_PASSES: Self = Self {
        after: (PASSES_AND_COPIES, WRITTEN_BY_THEM),
        before: (vk::PipelineStageFlags::COMPUTE_SHADER, TOUCHED_BY_PASSES),
    };
    /// A pass after a pass.
    pub(crate) const BETWEEN_PASSES: Self = Self {
        after: (vk::PipelineStageFlags::COMPUTE_SHADER, vk::AccessFlags::SHADER_WRITE),
        before: (vk::PipelineStageFlags::COMPUTE_SHADER, TOUCHED_BY_PASSES),
    };
    /// A copy after a copy.
    pub(crate) const BETWEEN_COPIES: Self = Self {
        after: (vk::PipelineStageFlags::TRANSFER, vk::AccessFlags::TRANSFER_WRITE),
        before: (vk::PipelineStageFlags::TRANSFER, TOUCHED_BY_COPIES),
    };
    /// The processor after copies.
    pub(crate) const BEFORE_HOST: Self = Self {
        after: (vk::PipelineStageFlags::TRANSFER, vk::AccessFlags::TRANSFER_WRITE),
        before: (vk::PipelineStageFlags::HOST, vk::AccessFlags::HOST_READ),
    };
}

/// A list of commands, recorded anew or submitted again once the device is done with it.
///
/// Each has a pool of its own, which is the one way to start over from any state, also after a failure.
pub(crate) struct Commands {
    pub(crate) handle: vk::CommandBuffer,
    pool: vk::CommandPool,
    context: Arc<Context>,
}

impl Commands {
    pub(crate) fn new(context: &Arc<Context>) -> Result<Self, Fault> {
        let info =
            vk::CommandPoolCreateInfo::default().queue_family_index(context.candidate.queue_family);
        // SAFETY: the family is one of the device's.
        let pool = unsafe { context.functions.create_command_pool(&info, None) }
            .map_err(during("vkCreateCommandPool"))?;
        let context = Arc::clone(context);
        // From here on, dropping it cleans up.
        let mut commands = Self { handle: vk::CommandBuffer::null(), pool, context };
        let info = vk::CommandBufferAllocateInfo::default()
            .command_pool(pool)
            .level(vk::CommandBufferLevel::PRIMARY)
            .command_buffer_count(1);
        // SAFETY: the pool was made with this device just now.
        let handles = unsafe { commands.context.functions.allocate_command_buffers(&info) };
        commands.handle = handles.map_err(during("vkAllocateCommandBuffers"))?[0];
        Ok(commands)
    }

    /// Starts over with an empty list. The device must be done with the one before.
    pub(crate) fn begin(&mut self, usage: vk::CommandBufferUsageFlags) -> Result<(), Fault> {
        // SAFETY: the device is done with the list, as callers promise.
        let reset = unsafe {
            let flags = vk::CommandPoolResetFlags::empty();
            self.context.functions.reset_command_pool(self.pool, flags)
        };
        reset.map_err(during("vkResetCommandPool"))?;
        let info = vk::CommandBufferBeginInfo::default().flags(usage);
        // SAFETY: the list is in its first state after the reset.
        unsafe { self.context.functions.begin_command_buffer(self.handle, &info) }
            .map_err(during("vkBeginCommandBuffer"))
    }

    pub(crate) fn end(&mut self) -> Result<(), Fault> {
        // SAFETY: `begin` came before.
        unsafe { self.context.functions.end_command_buffer(self.handle) }
            .map_err(during("vkEndCommandBuffer"))
    }

    pub(crate) fn barrier(&mut self, barrier: Barrier) {
        let memory = vk::MemoryBarrier::default()
            .src_access_mask(barrier.after.1)
            .dst_access_mask(barrier.before.1);
        // SAFETY: the list is being recorded; stages and accesses match, see `Barrier`.
        unsafe {
            self.context.functions.cmd_pipeline_barrier(
                self.handle,
                barrier.after.0,
                barrier.before.0,
                vk::DependencyFlags::empty(),
                &[memory],
                &[],
                &[],
            );
        }
    }

    /// Fills a buffer with zeros.
    pub(crate) fn clear(&mut self, buffer: &Buffer) {
        // SAFETY: the list is being recorded, and the buffer can be copied to, as all are.
        unsafe {
            self.context.functions.cmd_fill_buffer(
                self.handle,
                buffer.handle,
                0,
                vk::WHOLE_SIZE,
                0,
            );
        }
    }

    /// Copies ranges from one buffer to another.
    pub(crate) fn copy(&mut self, from: &Buffer, to: &Buffer, ranges: &[vk::BufferCopy]) {
        let are_within = ranges.iter().all(|range| {
            range.src_offset + range.size <= from.size && range.dst_offset + range.size <= to.size
        });
        assert!(are_within, "internal: a copy beyond a buffer's end");
        // SAFETY: the list is being recorded; the ranges are within the buffers as was just checked, not
        // empty, and do not overlap, which `Upload` and `Readback` take care of.
        unsafe {
            self.context.functions.cmd_copy_buffer(self.handle, from.handle, to.handle, ranges);
        }
    }

    /// Runs a shader.
    pub(crate) fn dispatch(&mut self, pipeline: &Pipeline, set: &Set, groups: [u32; 3]) {
        let functions = &self.context.functions;
        let point = vk::PipelineBindPoint::COMPUTE;
        // SAFETY: the list is being recorded.
        unsafe { functions.cmd_bind_pipeline(self.handle, point, pipeline.handle) };
        // SAFETY: the set was made for this pipeline's layout, see `Sets`.
        unsafe {
            let sets = [set.handle];
            functions.cmd_bind_descriptor_sets(self.handle, point, pipeline.layout, 0, &sets, &[]);
        }
        let [x, y, z] = groups;
        // SAFETY: pipeline and set are bound; the numbers are at most 65535, see `check::pass`.
        unsafe { functions.cmd_dispatch(self.handle, x, y, z) };
    }

    /// Forgets the first times of a pool of queries.
    pub(crate) fn reset_times(&mut self, queries: vk::QueryPool, n_times: u32) {
        // SAFETY: the list is being recorded, and the pool is long enough, see `StageTimes`.
        unsafe { self.context.functions.cmd_reset_query_pool(self.handle, queries, 0, n_times) };
    }

    /// Notes the time at which all commands before are finished.
    pub(crate) fn write_time(&mut self, queries: vk::QueryPool, idx: u32) {
        let stage = vk::PipelineStageFlags::BOTTOM_OF_PIPE;
        // SAFETY: the list is being recorded, the pool is long enough, and the query was reset.
        unsafe { self.context.functions.cmd_write_timestamp(self.handle, stage, queries, idx) };
    }

    pub(crate) fn begin_label(&mut self, label: &str) {
        self.context.begin_label(self.handle, label);
    }

    pub(crate) fn end_label(&mut self) {
        self.context.end_label(self.handle);
    }
}

impl Drop for Commands {
    fn drop(&mut self) {
        // SAFETY: lists are dropped when the device is done with them, or by an `AshDevice` that waited.
        unsafe { self.context.functions.destroy_command_pool(self.pool, None) };
    }
}
