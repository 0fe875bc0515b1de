//! Samples without a header: someone else must say what they are.

use std::path::Path;

use slabsplat_core::glam::{DAffine3, DVec3};
use slabsplat_core::{Grid, SampleType, Samples, Scaling};

use super::buffer::{Endian, SampleBuffer};
use super::formats::Input;
use super::stream::DataStream;
use super::window::Window;
use super::{LoadedVolume, VolumeFormat, VolumeOptions, assemble};
use crate::IoError;
use crate::progress::unless_stopped;
use crate::store::Store;

/// What a raw file holds: the header that it lacks.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct RawDesc {
    /// Voxels along x (fastest in the file), y and z.
    pub dims: [usize; 3],
    /// The type of the samples.
    pub sample_type: SampleType,
    /// The order of a sample's bytes; of no matter for 8 bits.
    pub endian: Endian,
    /// World length of a step along each axis.
    pub spacing: [f64; 3],
    /// Bytes before the first sample.
    pub header_bytes: u64,
}

impl RawDesc {
    /// So many samples of that type from the first byte on, the least byte of each first, a unit of the world
    /// apart.
    pub fn new(dims: [usize; 3], sample_type: SampleType) -> Self {
        Self { dims, sample_type, endian: Endian::Little, spacing: [1.0; 3], header_bytes: 0 }
    }

    /// The same with bytes in that order.
    #[must_use]
    pub fn endian(self, endian: Endian) -> Self {
        Self { endian, ..self }
    }

    /// The same with steps of that length.
    #[must_use]
    pub fn spacing(self, spacing: [f64; 3]) -> Self {
        Self { spacing, ..self }
    }

    /// The same behind so many bytes that are not read.
    #[must_use]
    pub fn header_bytes(self, header_bytes: u64) -> Self {
        Self { header_bytes, ..self }
    }

    /// What its samples take, in the file and in memory.
    pub(crate) fn bytes(&self) -> u64 {
        let n_voxels = self.dims.iter().fold(1, |n: u64, &len| n.saturating_mul(len as u64));
        n_voxels.saturating_mul(self.sample_type.size_bytes() as u64)
    }
}

/// Reads a file that is nothing but samples, `desc.header_bytes` from its start to its very end.
///
/// # Errors
/// If the file cannot be read, or is not just as long as `desc` says: then the description is
/// wrong, and the picture would be noise.
pub fn read_raw(path: impl AsRef<Path>, desc: &RawDesc) -> Result<LoadedVolume, IoError> {
    read_raw_from(Store::Disk, path.as_ref(), desc, &VolumeOptions::default())
}

pub(crate) fn read_raw_from(
    store: Store<'_>,
    path: &Path,
    desc: &RawDesc,
    options: &VolumeOptions,
) -> Result<LoadedVolume, IoError> {
    let map = DAffine3::from_scale(DVec3::from_array(desc.spacing));
    let grid = Grid::new_large(desc.dims, map)
        .map_err(|source| IoError::Grid { path: path.to_owned(), source })?;
    let input = Input { store, path, options, spill: None };
    let (window, grid) = input.window(&grid)?;
    let read = read_samples(&input, path, desc, window.as_ref());
    let samples = unless_stopped(options.progress.as_ref(), read)?;
    let volume = assemble(path, grid, samples, Scaling::IDENTITY)?;
    Ok(LoadedVolume::new(volume, VolumeFormat::Raw, Vec::new()))
}

/// The samples alone, of a grid that there can be.
pub(super) fn read_samples(
    input: &Input<'_>,
    path: &Path,
    desc: &RawDesc,
    window: Option<&Window>,
) -> Result<Samples, IoError> {
    let n_voxels = desc.dims.iter().fold(1, |n: usize, len| n.saturating_mul(*len));
    let sample_bytes = desc.sample_type.size_bytes();
    let mut stream = DataStream::open(input.store, path, desc.header_bytes)?;
    let needed = desc.bytes();
    let found = stream.n_left_at_most();
    if needed != found {
        let what = format!("needs {needed} bytes of data, has {found}: {}", what_fits(desc, found));
        return Err(IoError::malformed(path, what));
    }
    if let Some(window) = window {
        return window.read(path, &mut stream, (desc.sample_type.into(), 1), desc.endian);
    }
    let mut buffer = SampleBuffer::new(desc.sample_type, desc.endian);
    let meter = input.meter(needed);
    stream.metered(&meter);
    stream.fill(&mut buffer, n_voxels, sample_bytes)?;
    Ok(buffer.finish(&mut Vec::new()))
}

/// What would make a description one of so many bytes.
fn what_fits(desc: &RawDesc, found: u64) -> String {
    let [x, y, z] = desc.dims.map(|len| len as u64);
    let slice = x.saturating_mul(y);
    let n_voxels = slice.saturating_mul(z);
    let sample_bytes = desc.sample_type.size_bytes() as u64;
    let mut fitting = Vec::new();
    let of_size = |n: u64| match n {
        1 => Some("type uint8 or int8"),
        2 => Some("type uint16 or int16"),
        4 => Some("type uint32, int32 or float32"),
        8 => Some("type float64"),
        _ => None,
    };
    if 0 < n_voxels && found.is_multiple_of(n_voxels) {
        fitting.extend(of_size(found / n_voxels).map(str::to_owned));
    }
    let n_samples = found / sample_bytes;
    if found.is_multiple_of(sample_bytes) && 0 < n_samples {
        let mut with = |others: u64, dims: &dyn Fn(u64) -> String| {
            if 0 < others && n_samples.is_multiple_of(others) {
                fitting.push(format!("dims {}", dims(n_samples / others)));
            }
        };
        with(slice, &|len| format!("{x},{y},{len}"));
        with(x.saturating_mul(z), &|len| format!("{x},{len},{z}"));
        with(y.saturating_mul(z), &|len| format!("{len},{y},{z}"));
        let side = (n_samples as f64).cbrt().round() as u64;
        if side.checked_pow(3) == Some(n_samples) {
            fitting.push(format!("dims {side},{side},{side}"));
        }
    }
    let needed = n_voxels.saturating_mul(sample_bytes);
    if (1..=MAX_HEADER_BYTES).contains(&found.saturating_sub(needed)) {
        let n_bytes = desc.header_bytes.saturating_add(found - needed);
        fitting.push(format!("header bytes {n_bytes}"));
    }
    fitting.dedup();
    match fitting.as_slice() {
        [] => "check dims, type and header bytes".to_owned(),
        fitting => format!("what would fit is {}", fitting.join(", or ")),
    }
}

/// A longer header than this is none that a raw file has.
const MAX_HEADER_BYTES: u64 = 1 << 16;

#[cfg(test)]
mod tests {
    use super::*;

    const DESC: RawDesc = RawDesc {
        dims: [3, 2, 1],
        sample_type: SampleType::I16,
        endian: Endian::Big,
        spacing: [1.0, 2.0, 3.0],
        header_bytes: 4,
    };

    #[test]
    fn raw_reads_what_is_described() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.raw");
        std::fs::write(&path, [9, 9, 9, 9, 0, 1, 0, 2, 0, 3, 0, 4, 0, 5, 255, 250]).unwrap();
        let loaded = read_raw(&path, &DESC).unwrap();
        assert_eq!(loaded.volume.summary().range, Some([-6.0, 5.0]));
        assert_eq!(loaded.volume.grid().spacing(), [1.0, 2.0, 3.0]);
        assert_eq!(loaded.format.name(), "raw");
    }

    #[test]
    fn raw_says_what_would_fit() {
        let fits =
            |dims, sample_type, found| what_fits(&RawDesc { dims, sample_type, ..DESC }, found);
        let check = |dims, sample_type, found, expected: &str| {
            assert_eq!(fits(dims, sample_type, found), expected);
        };
        let u8 = SampleType::U8;
        check(
            [256, 256, 128],
            u8,
            256 * 256 * 128 * 2,
            "what would fit is type uint16 or int16, or dims \
            256,256,256, or dims 256,512,128, or dims 512,256,128, or dims 256,256,256",
        );
        check([7, 5, 3], u8, 7 * 5 * 3 + 11, "what would fit is header bytes 15");
        check([7, 5, 3], u8, 7 * 5 * 11, "what would fit is dims 7,5,11, or header bytes 284");
        check([7, 5, 3], SampleType::U16, 13, "check dims, type and header bytes");
        check([usize::MAX; 3], SampleType::U16, 62, "check dims, type and header bytes");
    }

    #[test]
    fn raw_refuses_any_other_length() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.raw");
        for n_bytes in [0, 3, 15, 17] {
            std::fs::write(&path, vec![0; n_bytes]).unwrap();
            let err = read_raw(&path, &DESC).unwrap_err().to_string();
            let expected = format!("needs 12 bytes of data, has {}:", n_bytes.saturating_sub(4));
            assert!(err.contains(&expected), "{err}");
        }
        let huge = RawDesc { dims: [usize::MAX, 2, 2], ..DESC };
        assert!(matches!(read_raw(&path, &huge), Err(IoError::Grid { .. })));
        let flat = RawDesc { spacing: [0.0, 1.0, 1.0], ..DESC };
        assert!(matches!(read_raw(&path, &flat), Err(IoError::Grid { .. })));
        let missing = read_raw(dir.path().join("b.raw"), &DESC).unwrap_err().to_string();
        assert!(missing.starts_with("cannot read"), "{missing}");
    }
}
