//! Where a picture goes that nobody reads back: what is left on the device, for its owner to show.

use crate::{Device, DeviceError, Slice};
use std::fmt;
use std::ops::Range;

/// A picture that lies in buffers of the device, or will when the device gets there.
#[derive(Clone, Debug, PartialEq, Eq)]
#[expect(clippy::exhaustive_structs, reason = "a device takes all of it or draws wrongly")]
pub struct Picture {
    /// Columns and rows.
    pub size: [u32; 2],
    /// All of its rows, from the top.
    pub bands: Vec<PictureBand>,
    /// Words, one of which says whether the picture is whole. Only the device knows that in time: there may
    /// have been no room for all splats, for instance. Then the frame is drawn again.
    pub counts: Slice,
    /// Which of the words: 1 if the picture is whole.
    pub is_whole_at: u32,
}

/// Some rows of a [`Picture`].
#[derive(Clone, Debug, PartialEq, Eq)]
#[expect(clippy::exhaustive_structs, reason = "a device takes all of it or draws wrongly")]
pub struct PictureBand {
    /// Which rows.
    pub rows: Range<u32>,
    /// Their pixels, row by row without gaps: premultiplied RGBA, a 32-bit float each.
    pub pixels: Slice,
}

/// What takes pictures from a device of type `D`, on that device.
pub trait Destination<D: Device>: fmt::Debug + Send + Sync {
    /// Whether it takes pictures of so many columns and rows.
    ///
    /// # Errors
    /// If not, with why: one sentence, lower case, without a full stop.
    fn check_size(&self, size: [u32; 2]) -> Result<(), String>;

    /// Begins to take the picture: by commands that the device executes after all work so far, and before any
    /// that comes later, which reuses its buffers. They must leave all as it is unless the picture is whole;
    /// this is then called again. It never waits.
    ///
    /// # Errors
    /// If the device cannot, or is lost.
    fn take(&self, device: &mut D, picture: &Picture) -> Result<(), DeviceError>;
}
