//! How long the stages of a frame take, where there is a clock, and whether anyone still wants it. In
//! browsers no clock is to be had without the page's help, and std's panics there.

use slabsplat_backend::StageTime;
use slabsplat_core::{Cancelled, FrameHandle};
use std::time::Instant;

/// Times one stage after the other.
pub(crate) struct Stopwatch<'a> {
    frame: &'a FrameHandle,
    /// `None` where nobody knows.
    last: Option<Instant>,
    stages: Vec<StageTime>,
}

impl<'a> Stopwatch<'a> {
    pub(crate) fn start(frame: &'a FrameHandle) -> Self {
        Self { frame, last: now(), stages: Vec::new() }
    }

    /// The frame that is timed.
    pub(crate) fn frame(&self) -> &'a FrameHandle {
        self.frame
    }

    /// The stage that began with the last call, or at the start, is done. One that comes again continues.
    ///
    /// # Errors
    /// If the frame is cancelled: stages may leave things half done then.
    pub(crate) fn done(&mut self, name: &'static str) -> Result<(), Cancelled> {
        let (Some(last), Some(now)) = (self.last, now()) else { return self.frame.check() };
        let ms = (now - last).as_secs_f64() * 1e3;
        match self.stages.iter_mut().find(|stage| stage.name == name) {
            Some(stage) => stage.ms += ms,
            None => self.stages.push(StageTime::new(name, ms)),
        }
        self.last = Some(now);
        self.frame.check()
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
