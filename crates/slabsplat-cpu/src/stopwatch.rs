//! How long the stages of a frame take.

use slabsplat_backend::StageTime;
use std::time::Instant;

/// Times one stage after the other.
pub(crate) struct Stopwatch {
    last: Instant,
    stages: Vec<StageTime>,
}

impl Stopwatch {
    pub(crate) fn start() -> Self {
        Self { last: Instant::now(), stages: Vec::new() }
    }

    /// The stage that began with the last call, or at the start, is done.
    pub(crate) fn done(&mut self, name: &'static str) {
        let now = Instant::now();
        self.stages.push(StageTime { name, ms: (now - self.last).as_secs_f64() * 1e3 });
        self.last = now;
    }

    pub(crate) fn stages(self) -> Vec<StageTime> {
        self.stages
    }
}
