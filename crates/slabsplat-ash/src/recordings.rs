//! Lists of passes as commands, cached to be submitted again: frame after frame runs the same passes.

use crate::buffers::Buffers;
use crate::check;
use crate::commands::{Barrier, Commands};
use crate::context::Context;
use crate::error::Fault;
use crate::pipelines::{Pipeline, Pipelines};
use crate::sets::{Set, Sets};
use crate::timing::{StageTimes, stages};
use ash::vk;
use slabsplat_gpu::{BufferId, Pass};
use std::sync::Arc;

/// What a recording is made from.
pub(crate) struct Sources<'a> {
    pub(crate) buffers: &'a Buffers,
    pub(crate) pipelines: &'a mut Pipelines,
    pub(crate) sets: &'a mut Sets,
}

/// Recordings of recent lists of passes.
///
/// A recording notes its times in queries of its own, and is therefore with the device once at a time. A
/// list that is submitted again before it is done gets a second recording, and so on; so frames overlap, and
/// yet, after a few frames, nothing is recorded any more.
pub(crate) struct Recordings {
    all: Vec<Recording>,
    /// At most so many. More than submissions are in flight, so that one is always free.
    capacity: usize,
    n_submitted: u64,
    context: Arc<Context>,
}

/// Names one of the recordings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct RecordingIdx(usize);

struct Recording {
    commands: Commands,
    times: Option<StageTimes>,
    /// What is recorded.
    passes: Vec<Pass>,
    /// Keeps the sets from being filled in anew.
    sets: Vec<Arc<Set>>,
    /// It can be submitted: nothing that it names has gone.
    is_valid: bool,
    /// The device has it.
    is_in_flight: bool,
    /// How many submissions there had been at its last.
    last_use: u64,
}

impl Recordings {
    pub(crate) fn new(context: &Arc<Context>, capacity: usize) -> Self {
        Self { all: Vec::new(), capacity, n_submitted: 0, context: Arc::clone(context) }
    }

    /// A recording of these passes that the device does not have.
    pub(crate) fn get(
        &mut self,
        passes: &[Pass],
        sources: Sources<'_>,
    ) -> Result<RecordingIdx, Fault> {
        let cached = self.all.iter().position(|recording| {
            recording.is_valid && !recording.is_in_flight && recording.is_of(passes)
        });
        if let Some(slot) = cached {
            return Ok(RecordingIdx(slot));
        }
        let slot = self.free_slot()?;
        self.all[slot].record(&self.context, passes, sources)?;
        Ok(RecordingIdx(slot))
    }

    pub(crate) fn commands(&self, recording: RecordingIdx) -> &Commands {
        &self.all[recording.0].commands
    }

    /// Notes that the device has it.
    pub(crate) fn note_submitted(&mut self, recording: RecordingIdx) {
        self.n_submitted += 1;
        let recording = &mut self.all[recording.0];
        recording.is_in_flight = true;
        recording.last_use = self.n_submitted;
    }

    /// Notes that the device is done with it, and says how long its stages took.
    pub(crate) fn note_done(
        &mut self,
        recording: RecordingIdx,
    ) -> Result<Vec<(&'static str, f64)>, Fault> {
        let recording = &mut self.all[recording.0];
        recording.is_in_flight = false;
        let stage_ms = recording.stage_ms();
        if !recording.is_valid {
            recording.clear();
        }
        stage_ms
    }

    /// Never submits again what names this buffer.
    pub(crate) fn forget(&mut self, buffer: BufferId) {
        for recording in self.all.iter_mut().filter(|recording| recording.names(buffer)) {
            recording.is_valid = false;
            if !recording.is_in_flight {
                recording.clear();
            }
        }
    }

    /// How many can be submitted again.
    #[cfg(test)]
    pub(crate) fn n_recorded(&self) -> usize {
        self.all.iter().filter(|recording| recording.is_valid).count()
    }

    /// A recording that may be made anew: one of nothing, or a new one, or the one that was not used for
    /// longest.
    fn free_slot(&mut self) -> Result<usize, Fault> {
        let slots = || self.all.iter().enumerate().filter(|(_, one)| !one.is_in_flight);
        if let Some((slot, _)) = slots().find(|(_, one)| !one.is_valid) {
            return Ok(slot);
        }
        if self.all.len() < self.capacity {
            self.all.push(Recording::new(Commands::new(&self.context)?));
            return Ok(self.all.len() - 1);
        }
        let oldest = slots().min_by_key(|(_, one)| one.last_use);
        let (slot, _) = oldest.expect("fewer submissions are in flight than there are recordings");
        Ok(slot)
    }
}

impl Recording {
    fn new(commands: Commands) -> Self {
        Self {
            commands,
            times: None,
            passes: Vec::new(),
            sets: Vec::new(),
            is_valid: false,
            is_in_flight: false,
            last_use: 0,
        }
    }

    /// If it is a recording of these. Shaders are compared by address, not by source.
    fn is_of(&self, passes: &[Pass]) -> bool {
        let is_same = |(one, other): (&Pass, &Pass)| {
            std::ptr::eq(one.shader, other.shader)
                && one.stage == other.stage
                && one.groups == other.groups
                && one.bindings == other.bindings
        };
        self.passes.len() == passes.len() && self.passes.iter().zip(passes).all(is_same)
    }

    fn names(&self, buffer: BufferId) -> bool {
        let mut slices = self.passes.iter().flat_map(|pass| &pass.bindings);
        slices.any(|slice| slice.buffer == buffer)
    }

    fn clear(&mut self) {
        self.passes.clear();
        self.sets.clear();
        self.is_valid = false;
    }

    fn record(
        &mut self,
        context: &Arc<Context>,
        passes: &[Pass],
        mut sources: Sources<'_>,
    ) -> Result<(), Fault> {
        self.clear();
        let mut pipelines = Vec::with_capacity(passes.len());
        for pass in passes {
            let (pipeline, set) = sources.of(context, pass)?;
            pipelines.push(pipeline);
            self.sets.push(set);
        }
        sources.sets.trim();
        self.make_room_for_times(context, 1 + stages(passes).count() as u32)?;
        self.commands.begin(vk::CommandBufferUsageFlags::empty())?;
        self.record_stages(passes, &pipelines);
        self.commands.end()?;
        self.passes.extend_from_slice(passes);
        self.is_valid = true;
        Ok(())
    }

    fn make_room_for_times(&mut self, context: &Arc<Context>, n_times: u32) -> Result<(), Fault> {
        let Some(clock) = context.candidate.clock else { return Ok(()) };
        if self.times.as_ref().is_none_or(|times| times.capacity < n_times) {
            self.times = Some(StageTimes::new(context, clock, n_times)?);
        }
        Ok(())
    }

    fn record_stages(&mut self, passes: &[Pass], pipelines: &[Arc<Pipeline>]) {
        let commands = &mut self.commands;
        let queries = self.times.as_ref().map(|times| times.queries);
        if let Some(queries) = queries {
            commands.reset_times(queries, 1 + stages(passes).count() as u32);
        }
        commands.barrier(Barrier::BEFORE_PASSES);
        if let Some(queries) = queries {
            commands.write_time(queries, 0);
        }
        let mut runs = passes.iter().zip(pipelines).zip(&self.sets);
        for (query_idx, stage) in (1..).zip(stages(passes)) {
            commands.begin_label(stage[0].stage);
            for (nth, ((pass, pipeline), set)) in runs.by_ref().take(stage.len()).enumerate() {
                if 0 < nth || 1 < query_idx {
                    commands.barrier(Barrier::BETWEEN_PASSES);
                }
                commands.dispatch(pipeline, set, pass.groups);
            }
            commands.end_label();
            if let Some(queries) = queries {
                commands.write_time(queries, query_idx);
            }
        }
    }

    fn stage_ms(&self) -> Result<Vec<(&'static str, f64)>, Fault> {
        let Some(times) = &self.times else { return Ok(Vec::new()) };
        let names = stages(&self.passes).map(|stage| stage[0].stage);
        let n_times = 1 + names.clone().count() as u32;
        Ok(names.zip(times.durations_ms(n_times)?).collect())
    }
}

impl Sources<'_> {
    fn of(&mut self, context: &Context, pass: &Pass) -> Result<(Arc<Pipeline>, Arc<Set>), Fault> {
        let buffers: Vec<_> =
            pass.bindings.iter().map(|slice| self.buffers.get(slice.buffer)).collect();
        check::pass(pass, &buffers, &context.candidate);
        let pipeline = self.pipelines.get(pass.shader)?;
        let set = self.sets.get(pass, &pipeline, &buffers)?;
        Ok((pipeline, set))
    }
}
