//! Samples without a header: someone else must say what they are.

use std::path::Path;

use slabsplat_core::{Grid, SampleType, Scaling};

use super::buffer::{Endian, SampleBuffer};
use super::stream::DataStream;
use super::{LoadedVolume, VolumeFormat, assemble};
use crate::IoError;
use crate::store::Store;

/// What a raw file holds: the header that it lacks.
#[derive(Clone, Debug, PartialEq)]
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

/// Reads a file that is nothing but samples, `desc.header_bytes` from its start to its very end.
///
/// # Errors
/// If the file cannot be read, or is not just as long as `desc` says: then the description is
/// wrong, and the picture would be noise.
pub fn read_raw(path: impl AsRef<Path>, desc: &RawDesc) -> Result<LoadedVolume, IoError> {
    read_raw_from(Store::Disk, path.as_ref(), desc)
}

pub(crate) fn read_raw_from(
    store: Store<'_>,
    path: &Path,
    desc: &RawDesc,
) -> Result<LoadedVolume, IoError> {
    let grid = Grid::with_spacing(desc.dims, desc.spacing)
        .map_err(|source| IoError::Grid { path: path.to_owned(), source })?;
    let sample_bytes = desc.sample_type.size_bytes();
    let mut stream = DataStream::open(store, path, desc.header_bytes)?;
    let needed = grid.n_voxels() as u64 * sample_bytes as u64;
    let found = stream.n_left_at_most();
    if needed != found {
        let hint = "check dims, type and header bytes";
        return Err(IoError::WrongLength { path: path.to_owned(), needed, found, hint });
    }
    let mut buffer = SampleBuffer::new(desc.sample_type);
    stream.fill(&mut buffer, grid.n_voxels(), sample_bytes)?;
    let volume = assemble(path, grid, buffer.finish(desc.endian), Scaling::IDENTITY)?;
    Ok(LoadedVolume::new(volume, VolumeFormat::Raw, Vec::new()))
}

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
