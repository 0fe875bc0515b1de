//! The marker segments that JPEG (ITU-T T.81 §B) and JPEG-LS (T.87 §C) have in common, up to a scan's bits.

/// Markers of both.
pub(super) const START_OF_IMAGE: u8 = 0xd8;
pub(super) const END_OF_IMAGE: u8 = 0xd9;
pub(super) const START_OF_SCAN: u8 = 0xda;
pub(super) const RESTART_INTERVAL: u8 = 0xdd;

/// A stream that cannot be unpacked, and why: for a message that says which packing.
pub(super) type Broken = &'static str;

/// A marker and what belongs to it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segment<'p> {
    pub(super) marker: u8,
    /// Without its length.
    pub(super) data: &'p [u8],
}

/// The segments of a stream, one after the other.
#[derive(Clone, Debug)]
pub(super) struct Segments<'p> {
    bytes: &'p [u8],
    at: usize,
}

impl<'p> Segments<'p> {
    /// Of a stream that begins with the marker that all do.
    pub(super) fn of(bytes: &'p [u8]) -> Result<Self, Broken> {
        match bytes {
            [0xff, START_OF_IMAGE, ..] => Ok(Self { bytes, at: 2 }),
            _ => Err("it does not begin as one"),
        }
    }

    /// The next segment; what is before its marker is passed over.
    pub(super) fn next(&mut self) -> Result<Segment<'p>, Broken> {
        const CUT_OFF: Broken = "it is cut off";
        let marker_at = |at: usize| matches!(self.bytes.get(at..at + 2), Some([0xff, 1..=0xfe]));
        let at = (self.at..self.bytes.len()).find(|&at| marker_at(at)).ok_or(CUT_OFF)?;
        let marker = self.bytes[at + 1];
        if matches!(marker, 0x01 | 0xd0..=END_OF_IMAGE) {
            self.at = at + 2;
            return Ok(Segment { marker, data: &[] });
        }
        let &[high, low] = self.bytes.get(at + 2..at + 4).ok_or(CUT_OFF)? else {
            return Err(CUT_OFF);
        };
        let end = at + 2 + usize::from(u16::from_be_bytes([high, low]));
        let data = self.bytes.get(at + 4..end).ok_or(CUT_OFF)?;
        self.at = end;
        Ok(Segment { marker, data })
    }

    /// What follows the segment that came last: the bits of a scan, and all after them.
    pub(super) fn rest(&self) -> &'p [u8] {
        &self.bytes[self.at..]
    }

    /// Goes on after so many bytes of [`Self::rest`].
    pub(super) fn pass_over(&mut self, n_bytes: usize) {
        self.at = self.at.saturating_add(n_bytes).min(self.bytes.len());
    }
}

/// What a frame header says of an image (T.81 §B.2.2, T.87 §C.2.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct FrameSize {
    pub(super) precision: u32,
    pub(super) rows: usize,
    pub(super) columns: usize,
    pub(super) n_components: usize,
}

impl FrameSize {
    pub(super) fn of(data: &[u8]) -> Result<Self, Broken> {
        let &[precision, y0, y1, x0, x1, n_components, ref components @ ..] = data else {
            return Err("its frame header is too short");
        };
        if components.len() < 3 * usize::from(n_components) {
            return Err("its frame header is too short");
        }
        Ok(Self {
            precision: u32::from(precision),
            rows: usize::from(u16::from_be_bytes([y0, y1])),
            columns: usize::from(u16::from_be_bytes([x0, x1])),
            n_components: usize::from(n_components),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_one_after_the_other() {
        let bytes = [0xff, 0xd8, 0xff, 0xff, 0xe0, 0, 4, 7, 8, 0xff, 0xda, 0, 2, 1, 2, 3];
        let mut segments = Segments::of(&bytes).unwrap();
        let first = segments.next().unwrap();
        assert_eq!((first.marker, first.data), (0xe0, &[7, 8][..]));
        assert_eq!(segments.next().unwrap().marker, START_OF_SCAN);
        assert_eq!(segments.rest(), [1, 2, 3]);
        segments.pass_over(9);
        assert_eq!(segments.next().unwrap_err(), "it is cut off");
        assert!(Segments::of(&[]).is_err());
    }
}
