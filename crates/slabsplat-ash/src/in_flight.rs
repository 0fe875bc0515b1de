//! What a submission holds until the device is done with it.

use crate::commands::Commands;
use crate::memory::Buffer;
use crate::readback::Readback;
use crate::recordings::{RecordingIdx, Recordings};

/// A submission in the making. All parts may be missing.
#[derive(Default)]
pub(crate) struct Batch {
    /// Fills buffers with zeros, and with the bytes of `staging`.
    pub(crate) copies_in: Option<Commands>,
    pub(crate) staging: Option<Buffer>,
    pub(crate) recording: Option<RecordingIdx>,
    /// Fills `readback`.
    pub(crate) copies_out: Option<Commands>,
    pub(crate) readback: Option<Readback>,
}

impl Batch {
    /// The lists of commands, in their order.
    pub(crate) fn lists<'a>(&'a self, recordings: &'a Recordings) -> Vec<&'a Commands> {
        let passes = self.recording.map(|recording| recordings.commands(recording));
        [self.copies_in.as_ref(), passes, self.copies_out.as_ref()].into_iter().flatten().collect()
    }
}

/// A submission that the device has.
pub(crate) struct InFlight {
    /// Its number on the timeline.
    pub(crate) number: u64,
    pub(crate) batch: Batch,
}

impl InFlight {
    /// Bytes of host memory that wait to be copied.
    pub(crate) fn staging_bytes(&self) -> u64 {
        self.batch.staging.as_ref().map_or(0, |buffer| buffer.size)
    }
}
