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

    /// The stage that began with the last call, or at the start, is done. One that comes again continues.
    pub(crate) fn done(&mut self, name: &'static str) {
        let now = Instant::now();
        let ms = (now - self.last).as_secs_f64() * 1e3;
        match self.stages.iter_mut().find(|stage| stage.name == name) {
            Some(stage) => stage.ms += ms,
            None => self.stages.push(StageTime::new(name, ms)),
        }
        self.last = now;
    }

    pub(crate) fn stages(self) -> Vec<StageTime> {
        self.stages
    }
}
