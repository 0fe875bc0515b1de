//! How long the stages of a frame take, where there is a clock: in browsers none is to be had without the
//! page's help, and std's panics there.

use slabsplat_backend::StageTime;
use std::time::Instant;

/// Times one stage after the other.
pub(crate) struct Stopwatch {
    /// `None` where nobody knows.
    last: Option<Instant>,
    stages: Vec<StageTime>,
}

impl Stopwatch {
    pub(crate) fn start() -> Self {
        Self { last: now(), stages: Vec::new() }
    }

    /// The stage that began with the last call, or at the start, is done. One that comes again continues.
    pub(crate) fn done(&mut self, name: &'static str) {
        let (Some(last), Some(now)) = (self.last, now()) else { return };
        let ms = (now - last).as_secs_f64() * 1e3;
        match self.stages.iter_mut().find(|stage| stage.name == name) {
            Some(stage) => stage.ms += ms,
            None => self.stages.push(StageTime::new(name, ms)),
        }
        self.last = Some(now);
    }

    /// None, if there is no clock.
    pub(crate) fn stages(self) -> Vec<StageTime> {
        self.stages
    }
}

fn now() -> Option<Instant> {
    let has_clock = !cfg!(all(target_family = "wasm", target_os = "unknown"));
    has_clock.then(Instant::now)
}
