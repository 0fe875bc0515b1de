//! Passes, and the small struct that says to each which part of the work it does.

use crate::memory::{Buffer, Memory};
use crate::params::Step;
use crate::{Device, Pass, Slice, Write};
use slabsplat_backend::BackendError;
use slabsplat_shaders::{Binding, Shader};

/// Bytes from one step to the next: every device can bind there.
const STEP_STRIDE: u64 = 256;

/// Steps that there is room for.
pub(crate) const MAX_STEPS: u64 = 2048;

/// Workgroups along one dimension that every device can start.
const MAX_GROUPS: u32 = 65535;

/// A list of passes under construction.
#[derive(Debug)]
pub(crate) struct PassList {
    stage: &'static str,
    /// The buffer of steps.
    steps_at: Slice,
    steps: Vec<Step>,
    passes: Vec<Pass>,
}

impl PassList {
    /// Pushes a pass of `n_groups` workgroups, or nothing if that is 0. `bindings` are all that the shader
    /// has, in their order, but for its step.
    ///
    /// # Panics
    /// If there are more or fewer.
    pub(crate) fn push(
        &mut self,
        shader: &'static Shader,
        bindings: &[Slice],
        step: Step,
        n_groups: u32,
    ) {
        if n_groups == 0 {
            return;
        }
        let step_slice = self.push_step(step);
        let mut others = bindings.iter().copied();
        let bind = |binding: &Binding| match binding.name {
            "step" => step_slice,
            name => others.next().unwrap_or_else(|| panic!("{}: {name} is missing", shader.name)),
        };
        let bindings = shader.bindings.iter().map(bind).collect();
        assert_eq!(others.next(), None, "{} has fewer bindings", shader.name);
        let rows = n_groups.div_ceil(MAX_GROUPS);
        let groups = [n_groups.div_ceil(rows), rows, 1];
        self.passes.push(Pass { shader, stage: self.stage, bindings, groups });
    }

    /// What is pushed from now on belongs to a stage of that name.
    pub(crate) fn begin(&mut self, stage: &'static str) {
        self.stage = stage;
    }

    fn push_step(&mut self, step: Step) -> Slice {
        let offset = self.steps_at.offset + STEP_STRIDE * self.steps.len() as u64;
        assert!(offset < STEP_STRIDE * MAX_STEPS, "a list has at most {MAX_STEPS} passes");
        self.steps.push(step);
        Slice { buffer: self.steps_at.buffer, offset, size: size_of::<Step>() as u64 }
    }
}

/// The steps of the last list on the device. The next list's are much the same.
#[derive(Debug)]
pub(crate) struct StepBuffer {
    buffer: Buffer,
    written: Vec<Step>,
}

impl StepBuffer {
    pub(crate) fn new() -> Self {
        Self { buffer: Buffer::new("steps"), written: Vec::new() }
    }

    /// An empty list, whose steps go here.
    pub(crate) fn list<D: Device>(
        &mut self,
        memory: &mut Memory,
        device: &mut D,
    ) -> Result<PassList, BackendError> {
        memory.grow(device, &mut self.buffer, STEP_STRIDE * MAX_STEPS)?;
        let steps_at = self.buffer.all();
        Ok(PassList { stage: "", steps_at, steps: Vec::new(), passes: Vec::new() })
    }

    /// The passes of a list; its steps, as far as they changed, are written.
    pub(crate) fn finish(&mut self, list: PassList, writes: &mut Vec<Write<'_>>) -> Vec<Pass> {
        let buffer = self.buffer.all().buffer;
        for (idx, step) in list.steps.iter().enumerate() {
            if self.written.get(idx) != Some(step) {
                let offset = STEP_STRIDE * idx as u64;
                writes.push(Write {
                    buffer,
                    offset,
                    bytes: bytemuck::bytes_of(step).to_vec().into(),
                });
            }
        }
        let n_old = list.steps.len().min(self.written.len());
        self.written.splice(..n_old, list.steps);
        list.passes
    }

    /// The buffer, to be freed: nothing is in it then.
    pub(crate) fn emptied(&mut self) -> &mut Buffer {
        self.written.clear();
        &mut self.buffer
    }
}

/// Workgroups of `per_group` elements that cover `n` elements.
pub(crate) fn n_groups(n: u64, per_group: u32) -> u32 {
    // Elements are counted in 32 bits, so groups are, too.
    n.div_ceil(u64::from(per_group)) as u32
}
