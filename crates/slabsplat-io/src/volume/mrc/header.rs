//! The bytes at the head of an MRC file, as fields.

use super::super::Endian;

/// Bytes of the header that every file has.
pub(super) const HEADER_BYTES: u64 = 1024;

/// Of these the first are needed, up to the machine stamp.
const NEEDED_BYTES: usize = 216;

/// More voxels along an axis are none that a detector has: such a header is in the other byte order.
const MAX_SIZE: i32 = 1 << 24;

/// What IMOD writes at byte 152, before its flags.
const IMOD_STAMP: i32 = 1_146_047_817;

/// IMOD's flag for bytes that are signed.
const IMOD_SIGNED: i32 = 1;

/// From this space group on the file is a stack of volumes.
const FIRST_STACK_GROUP: i32 = 401;

/// What a header says.
#[derive(Clone, Debug)]
pub(super) struct Header {
    pub(super) endian: Endian,
    /// Whether the word `MAP ` is there.
    pub(super) has_magic: bool,
    /// Whether the machine stamp is for the other byte order, or none.
    pub(super) is_stamp_wrong: bool,
    /// Columns, rows and sections.
    pub(super) sizes: [usize; 3],
    pub(super) mode: i32,
    /// Index of the first column, row and section in the cell.
    pub(super) start: [i32; 3],
    /// Steps of the cell along x, y and z.
    pub(super) intervals: [i32; 3],
    /// Lengths of the cell's edges, in ångström.
    pub(super) cell: [f64; 3],
    /// Its angles, in degrees.
    pub(super) angles: [f64; 3],
    /// Along which axis, 0 to 2, columns, rows and sections follow each other.
    pub(super) axis_of: [usize; 3],
    /// Least and largest value.
    range: [f64; 2],
    space_group: i32,
    pub(super) n_extended_bytes: u32,
    imod_flags: Option<i32>,
    /// Where the first voxel is, in ångström.
    pub(super) origin: [f64; 3],
}

impl Header {
    /// `None` if no header can begin like this.
    pub(super) fn parse(start: &[u8]) -> Option<Self> {
        let start = start.get(..NEEDED_BYTES)?;
        let stamped = match start[212..214] {
            [0x44, 0x41 | 0x44] => Some(Endian::Little),
            [0x11, 0x11] => Some(Endian::Big),
            _ => None,
        };
        let first = stamped.unwrap_or(Endian::Little);
        let second = if first == Endian::Little { Endian::Big } else { Endian::Little };
        let header =
            [first, second].into_iter().find_map(|endian| Self::in_order(start, endian))?;
        let has_stamp = start[212..216] != [0; 4];
        Some(Self { is_stamp_wrong: has_stamp && stamped != Some(header.endian), ..header })
    }

    /// `None` if the fields cannot be what they are in this byte order.
    fn in_order(start: &[u8], endian: Endian) -> Option<Self> {
        let word = |at: usize| {
            let bytes = [start[at], start[at + 1], start[at + 2], start[at + 3]];
            match endian {
                Endian::Little => u32::from_le_bytes(bytes),
                Endian::Big => u32::from_be_bytes(bytes),
            }
        };
        let integers = |at: usize| [0, 4, 8].map(|next| word(at + next).cast_signed());
        let floats = |at: usize| [0, 4, 8].map(|next| f64::from(f32::from_bits(word(at + next))));
        let integer = |at: usize| integers(at)[0];
        let sizes = integers(0);
        let mode = integer(12);
        let n_extended_bytes = integer(92);
        let is_plausible = sizes.iter().all(|size| (1..=MAX_SIZE).contains(size))
            && (0..=127).contains(&mode)
            && 0 <= n_extended_bytes;
        if !is_plausible {
            return None;
        }
        let [min, max, _] = floats(76);
        Some(Self {
            endian,
            has_magic: matches!(&start[208..212], b"MAP " | b"MAP\0"),
            is_stamp_wrong: false,
            sizes: sizes.map(|size| size as usize),
            mode,
            start: integers(16),
            intervals: integers(28),
            cell: floats(40),
            angles: floats(52),
            axis_of: axis_of(integers(64))?,
            range: [min, max],
            space_group: integer(88),
            n_extended_bytes: n_extended_bytes.cast_unsigned(),
            imod_flags: (integer(152) == IMOD_STAMP).then(|| integer(156)),
            origin: floats(196),
        })
    }

    /// Columns, rows and sections of one volume.
    pub(super) fn volume_sizes(&self) -> [usize; 3] {
        let [n_columns, n_rows, n_sections] = self.sizes;
        let is_stack = (FIRST_STACK_GROUP..FIRST_STACK_GROUP + 230).contains(&self.space_group);
        let n_each = usize::try_from(self.intervals[2]).unwrap_or(0);
        let n_each = if is_stack && 0 < n_each { n_each } else { n_sections };
        [n_columns, n_rows, n_each]
    }

    /// Volumes that follow each other, at least 1.
    pub(super) fn n_volumes(&self) -> usize {
        (self.sizes[2] / self.volume_sizes()[2]).max(1)
    }

    /// Voxels along x, y and z.
    pub(super) fn dims(&self) -> [usize; 3] {
        let mut dims = [0; 3];
        for (&axis, size) in self.axis_of.iter().zip(self.volume_sizes()) {
            dims[axis] = size;
        }
        dims
    }

    /// Samples in the file.
    pub(super) fn n_items(&self) -> u64 {
        self.sizes.iter().fold(1, |n: u64, &size| n.saturating_mul(size as u64))
    }

    /// Whether samples of 8 bits have a sign. By the standard they do; IMOD has a flag, and older programs
    /// betray themselves by the largest value.
    pub(super) fn are_bytes_signed(&self, warnings: &mut Vec<String>) -> bool {
        if let Some(flags) = self.imod_flags {
            return flags & IMOD_SIGNED != 0;
        }
        let [min, max] = self.range;
        let is_beyond = 0.0 <= min && 127.0 < max && max <= 255.0;
        if is_beyond {
            warnings.push(format!(
                "the header has values up to {max}, so that bytes were read without a sign"
            ));
        }
        !is_beyond
    }

    /// Whether the header is what IMOD writes.
    #[cfg(test)]
    pub(super) fn is_of_imod(&self) -> bool {
        self.imod_flags.is_some()
    }
}

/// Axes are counted from 1; files of three zeros have columns along x, rows along y, sections along z.
fn axis_of(axes: [i32; 3]) -> Option<[usize; 3]> {
    if axes == [0; 3] {
        return Some([0, 1, 2]);
    }
    let mut sorted = axes;
    sorted.sort_unstable();
    (sorted == [1, 2, 3]).then(|| axes.map(|axis| axis as usize - 1))
}
