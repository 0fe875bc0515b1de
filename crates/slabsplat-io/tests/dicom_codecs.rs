//! DICOM files that other programs packed, against what pydicom reads of them: `dicom_codecs/make.py` made
//! both.

use std::path::{Path, PathBuf};

use slabsplat_io::{FilesInMemory, VolumeOptions, read_volume_with};

const VALUES: &str = include_str!("dicom_codecs/values.tsv");

/// Every how many values are in the table.
const STEP: usize = 7;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/dicom_codecs")
}

/// All values of a channel.
fn values(path: &Path, channel: usize) -> Vec<i64> {
    let options = VolumeOptions::default();
    let loaded =
        read_volume_with(path, &options.channel(channel)).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(loaded.volume.grid().dims(), [33, 21, 1], "{}", path.display());
    let volume = &loaded.volume;
    (0..volume.grid().n_voxels()).map(|voxel_idx| volume.value(voxel_idx) as i64).collect()
}

#[test]
fn packed_frames_are_what_others_read() {
    let mut n_checked = 0;
    for line in VALUES.lines() {
        let fields: Vec<&str> = line.split('\t').collect();
        let [name, channel, off, sum, every_seventh] = fields[..] else { panic!("{line}") };
        let off: i64 = off.parse().unwrap();
        let found = values(&folder().join(name), channel.parse().unwrap());
        if off == 0 {
            assert_eq!(
                found.iter().sum::<i64>(),
                sum.parse::<i64>().unwrap(),
                "{name}, channel {channel}"
            );
        }
        let expected: Vec<i64> =
            every_seventh.split(' ').map(|n| n.parse::<i64>().unwrap()).collect();
        let seventh: Vec<i64> = found.into_iter().step_by(STEP).collect();
        assert_eq!(seventh.len(), expected.len(), "{name}");
        let farthest = seventh.iter().zip(&expected).map(|(f, e)| (f - e).abs()).max();
        assert!(farthest <= Some(off), "{name}, channel {channel}: {farthest:?} off");
        n_checked += 1;
    }
    assert_eq!(n_checked, 38, "lines of the table");
}

/// A file that breaks off is an error wherever it does, and one line.
#[test]
fn packed_frames_cut_off_anywhere() {
    for name in ["ls_12.dcm", "ls_planes.dcm", "2000_12.dcm", "jpeg_12.dcm"] {
        let whole = std::fs::read(folder().join(name)).unwrap();
        // The last bytes say only that an image ends, and the file.
        for n_bytes in (0..whole.len() - 24).step_by(3) {
            let files = FilesInMemory::from_iter([("a.dcm", &whole[..n_bytes])]);
            let error = files.read_volume("a.dcm").expect_err(name).to_string();
            assert!(error.contains("a.dcm") && !error.contains('\n'), "{name}: {error}");
        }
    }
}
