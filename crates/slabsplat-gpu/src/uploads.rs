//! What goes to the device before a frame, in pieces, so that its bytes need not be on the host all at once.

use crate::memory::backend_error;
use crate::{Device, Work, WorkId, Write};
use slabsplat_backend::BackendError;
use std::task::Poll;

/// Writes that were submitted by themselves, ahead of the work that sees them.
#[derive(Debug, Default)]
pub(crate) struct Uploads {
    /// Not known to be done.
    under_way: Vec<WorkId>,
}

impl Uploads {
    /// Submits writes.
    pub(crate) fn send<D: Device>(
        &mut self,
        device: &mut D,
        what: &'static str,
        writes: Vec<Write<'_>>,
    ) -> Result<(), BackendError> {
        let work = Work { writes, ..Work::default() };
        let sent = device.submit(&work).map_err(|error| backend_error(device, what, &error))?;
        self.under_way.push(sent);
        Ok(())
    }

    /// Takes note of those that are done: until then a device holds something for each.
    pub(crate) fn collect<D: Device>(&mut self, device: &mut D) {
        self.under_way.retain(|&work| matches!(device.poll(work), Ok(Poll::Pending)));
    }
}
