//! The fields of a header that matter here, the same for both versions.

use super::super::Endian;

/// Which of the two headers a file has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Version {
    /// Analyze 7.5, from which NIfTI-1 came.
    Zero,
    One,
    Two,
}

/// A header's fields, by the names of nifti1.h, widened to those of NIfTI-2.
#[derive(Debug)]
pub(super) struct Header {
    pub(super) version: Version,
    pub(super) endian: Endian,
    /// Whether the voxels are in the header's file.
    pub(super) is_single_file: bool,
    pub(super) dim: [i64; 8],
    pub(super) datatype: i64,
    pub(super) intent_code: i64,
    pub(super) pixdim: [f64; 8],
    pub(super) vox_offset: f64,
    pub(super) scl_slope: f64,
    pub(super) scl_inter: f64,
    pub(super) xyzt_units: i64,
    pub(super) qform_code: i64,
    pub(super) sform_code: i64,
    pub(super) quatern: [f64; 3],
    pub(super) qoffset: [f64; 3],
    pub(super) srow: [[f64; 4]; 3],
}

impl Version {
    pub(super) fn n_header_bytes(self) -> u64 {
        match self {
            Self::Zero | Self::One => 348,
            Self::Two => 540,
        }
    }
}

/// The first bytes of a file, in a known byte order.
#[derive(Clone, Copy)]
struct Fields<'b> {
    bytes: &'b [u8],
    endian: Endian,
}

impl Header {
    /// The header at the start of `bytes`, if there is one.
    pub(super) fn parse(bytes: &[u8]) -> Option<Self> {
        [Endian::Little, Endian::Big].into_iter().find_map(|endian| {
            let fields = Fields { bytes, endian };
            match fields.i32(0)? {
                348 => Self::parse_one(fields),
                540 => Self::parse_two(fields),
                _ => None,
            }
        })
    }

    fn parse_one(fields: Fields<'_>) -> Option<Self> {
        let is_single_file = match fields.bytes.get(344..348)? {
            b"n+1\0" => true,
            b"ni1\0" => false,
            _ => return Self::parse_zero(fields),
        };
        Some(Self {
            version: Version::One,
            endian: fields.endian,
            is_single_file,
            dim: fields.array(40, 2, Fields::i16)?,
            datatype: fields.i16(70)?,
            intent_code: fields.i16(68)?,
            pixdim: fields.array(76, 4, Fields::f32)?,
            vox_offset: fields.f32(108)?,
            scl_slope: fields.f32(112)?,
            scl_inter: fields.f32(116)?,
            xyzt_units: i64::from(*fields.bytes.get(123)?),
            qform_code: fields.i16(252)?,
            sform_code: fields.i16(254)?,
            quatern: fields.array(256, 4, Fields::f32)?,
            qoffset: fields.array(268, 4, Fields::f32)?,
            srow: [
                fields.array(280, 4, Fields::f32)?,
                fields.array(296, 4, Fields::f32)?,
                fields.array(312, 4, Fields::f32)?,
            ],
        })
    }

    /// A header without a name: what it says must make sense.
    fn parse_zero(fields: Fields<'_>) -> Option<Self> {
        let dim: [i64; 8] = fields.array(40, 2, Fields::i16)?;
        let datatype = fields.i16(70)?;
        let n_bits = fields.i16(72)?;
        // The format wants an `r` there, and nibabel writes none.
        let is_sane = matches!(*fields.bytes.get(38)?, b'r' | 0)
            && (1..=7).contains(&dim[0])
            && matches!((datatype, n_bits), (2, 8) | (4, 16) | (8 | 16, 32) | (64, 64));
        fields.bytes.get(344..348)?;
        if !is_sane {
            return None;
        }
        Some(Self {
            version: Version::Zero,
            endian: fields.endian,
            is_single_file: false,
            dim,
            datatype,
            intent_code: 0,
            pixdim: fields.array(76, 4, Fields::f32)?,
            vox_offset: fields.f32(108)?,
            // What later became slope, units and orientation has other meanings here.
            scl_slope: 0.0,
            scl_inter: 0.0,
            xyzt_units: 2,
            qform_code: 0,
            sform_code: 0,
            quatern: [0.0; 3],
            qoffset: [0.0; 3],
            srow: [[0.0; 4]; 3],
        })
    }

    fn parse_two(fields: Fields<'_>) -> Option<Self> {
        // The four bytes after the name catch transfers that change line ends.
        let is_single_file = match fields.bytes.get(4..12)? {
            b"n+2\0\r\n\x1a\n" => true,
            b"ni2\0\r\n\x1a\n" => false,
            _ => return None,
        };
        fields.bytes.get(..540)?;
        Some(Self {
            version: Version::Two,
            endian: fields.endian,
            is_single_file,
            dim: fields.array(16, 8, Fields::i64)?,
            datatype: fields.i16(12)?,
            intent_code: fields.i32(504)?,
            pixdim: fields.array(104, 8, Fields::f64)?,
            vox_offset: fields.i64(168)? as f64,
            scl_slope: fields.f64(176)?,
            scl_inter: fields.f64(184)?,
            xyzt_units: fields.i32(500)?,
            qform_code: fields.i32(344)?,
            sform_code: fields.i32(348)?,
            quatern: fields.array(352, 8, Fields::f64)?,
            qoffset: fields.array(376, 8, Fields::f64)?,
            srow: [
                fields.array(400, 8, Fields::f64)?,
                fields.array(432, 8, Fields::f64)?,
                fields.array(464, 8, Fields::f64)?,
            ],
        })
    }
}

impl Fields<'_> {
    fn get<const N: usize>(self, offset: usize) -> Option<[u8; N]> {
        let mut bytes: [u8; N] = self.bytes.get(offset..offset + N)?.try_into().ok()?;
        if self.endian == Endian::Big {
            bytes.reverse();
        }
        Some(bytes)
    }

    fn i16(self, offset: usize) -> Option<i64> {
        self.get(offset).map(|bytes| i64::from(i16::from_le_bytes(bytes)))
    }

    fn i32(self, offset: usize) -> Option<i64> {
        self.get(offset).map(|bytes| i64::from(i32::from_le_bytes(bytes)))
    }

    fn i64(self, offset: usize) -> Option<i64> {
        self.get(offset).map(i64::from_le_bytes)
    }

    fn f32(self, offset: usize) -> Option<f64> {
        self.get(offset).map(|bytes| f64::from(f32::from_le_bytes(bytes)))
    }

    fn f64(self, offset: usize) -> Option<f64> {
        self.get(offset).map(f64::from_le_bytes)
    }

    /// Fields of one kind, `stride` bytes apart.
    fn array<T: Copy + Default, const N: usize>(
        self,
        offset: usize,
        stride: usize,
        field: impl Fn(Self, usize) -> Option<T>,
    ) -> Option<[T; N]> {
        let mut array = [T::default(); N];
        for (idx, value) in array.iter_mut().enumerate() {
            *value = field(self, offset + idx * stride)?;
        }
        Some(array)
    }
}
