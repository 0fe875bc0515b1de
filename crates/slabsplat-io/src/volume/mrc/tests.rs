//! Whole MRC files, written here field by field.

use slabsplat_core::glam::DVec3;
use slabsplat_core::{SampleType, Samples};

use super::header::Header;
use crate::store::read_from_both as read;
use crate::{
    Endian, FilesInMemory, LoadedVolume, VolumeFormat, VolumeOptions, list_volume, read_volume,
};

/// A file in the making.
#[derive(Clone)]
struct Written {
    bytes: Vec<u8>,
    endian: Endian,
}

impl Written {
    /// 3 × 2 × 2 voxels of 16 bits, 2 × 3 × 4 ångström each.
    fn new(endian: Endian) -> Self {
        let written = Self { bytes: vec![0; 1024], endian };
        let stamp = if endian == Endian::Little { [0x44, 0x44] } else { [0x11, 0x11] };
        let written = written.integers(0, &[3, 2, 2, 1]).integers(28, &[3, 2, 2]);
        let mut written = written.integers(64, &[1, 2, 3]).floats(40, &[6.0, 6.0, 8.0]);
        written.bytes[208..214].copy_from_slice(&[b"MAP ", &stamp[..]].concat());
        written.floats(52, &[90.0; 3])
    }

    fn put(&mut self, at: usize, mut bytes: [u8; 4]) {
        if self.endian == Endian::Big {
            bytes.reverse();
        }
        self.bytes[at..at + 4].copy_from_slice(&bytes);
    }

    fn integers(mut self, at: usize, numbers: &[i32]) -> Self {
        for (idx, number) in numbers.iter().enumerate() {
            self.put(at + 4 * idx, number.to_le_bytes());
        }
        self
    }

    fn floats(mut self, at: usize, numbers: &[f32]) -> Self {
        for (idx, number) in numbers.iter().enumerate() {
            self.put(at + 4 * idx, number.to_le_bytes());
        }
        self
    }

    fn without_magic(mut self) -> Self {
        self.bytes[208..216].fill(0);
        self
    }

    /// The file with the numbers 0, 1, 2, … of 16 bits in it.
    fn counted(&self, n: i16) -> Vec<u8> {
        let numbers = (0..n).flat_map(|number| match self.endian {
            Endian::Little => number.to_le_bytes(),
            Endian::Big => number.to_be_bytes(),
        });
        self.bytes.iter().copied().chain(numbers).collect()
    }

    fn with(&self, data: &[u8]) -> Vec<u8> {
        [&self.bytes, data].concat()
    }
}

fn both() -> [Written; 2] {
    [Written::new(Endian::Little), Written::new(Endian::Big)]
}

fn loaded(bytes: &[u8]) -> LoadedVolume {
    read(&[("a.dat", bytes)]).unwrap()
}

fn check_error(bytes: &[u8], expected: &str) {
    let error = read(&[("a.mrc", bytes)]).unwrap_err();
    assert!(error.contains(expected) && !error.contains('\n'), "{error} should contain {expected}");
}

fn is_near(a: [f64; 3], b: [f64; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-12 * b.abs().max(1e-7))
}

#[test]
fn mrc_is_known_by_its_content() {
    for written in both() {
        let loaded = loaded(&written.counted(12));
        assert_eq!(loaded.format, VolumeFormat::Mrc);
        assert_eq!(loaded.volume.samples(), &Samples::I16((0..12).collect()));
        assert_eq!(loaded.volume.grid().dims(), [3, 2, 2]);
        assert!(is_near(loaded.volume.grid().spacing(), [2e-7, 3e-7, 4e-7]));
        assert_eq!(loaded.warnings, [""; 0]);
    }
}

/// A header of 348 columns begins as those of Analyze do.
#[test]
fn mrc_of_348_columns_is_no_nifti() {
    let wide = Written::new(Endian::Little).integers(0, &[348, 1, 1, 1]);
    assert_eq!(loaded(&wide.with(&[0; 696])).format, VolumeFormat::Mrc);
}

#[test]
fn mrc_without_the_word_map_is_known_by_its_name() {
    for written in both() {
        let bytes = written.without_magic().counted(12);
        for name in ["a.mrc", "a.st", "a.REC"] {
            let loaded = read(&[(name, &bytes)]).unwrap();
            assert_eq!(loaded.volume.samples(), &Samples::I16((0..12).collect()));
            assert_eq!(loaded.warnings, [""; 0]);
        }
        assert!(read(&[("a.dat", &bytes)]).is_err());
    }
    check_error(&[0; 2000], "not an MRC file");
    check_error(b"a text", "not an MRC file");
    let json = br#"{"dims": [4, 1, 1], "type": "uint8", "file": "a.map"}"#;
    let raw = read(&[("a.map", &[0; 4]), ("a.json", json)]).unwrap();
    assert_eq!(raw.format, VolumeFormat::Raw);
}

#[test]
fn mrc_byte_order_is_that_of_the_header() {
    let mut wrong = Written::new(Endian::Big);
    wrong.bytes[212..214].copy_from_slice(&[0x44, 0x44]);
    let loaded = loaded(&wrong.counted(12));
    assert_eq!(loaded.volume.samples(), &Samples::I16((0..12).collect()));
    assert!(loaded.warnings[0].contains("machine stamp"), "{:?}", loaded.warnings);
}

#[test]
fn mrc_modes() {
    let little = Written::new(Endian::Little).integers(0, &[2, 1, 1]);
    let check = |mode: i32, data: &[u8], expected: Samples| {
        let written = little.clone().integers(12, &[mode]);
        assert_eq!(loaded(&written.with(data)).volume.samples(), &expected);
    };
    check(0, &[1, 255], Samples::I8(vec![1, -1]));
    check(1, &[1, 0, 255, 255], Samples::I16(vec![1, -1]));
    check(2, &[0, 0, 128, 63, 0, 0, 0, 192], Samples::F32(vec![1.0, -2.0]));
    check(6, &[1, 0, 255, 255], Samples::U16(vec![1, 65535]));
    check(12, &[0, 0x3c, 0, 0xc0], Samples::F32(vec![1.0, -2.0]));
    for (mode, expected) in [
        (3, "complex numbers"),
        (4, "complex numbers"),
        (16, "colours"),
        (101, "4 bits"),
        (5, "there is no mode 5"),
    ] {
        check_error(&little.clone().integers(12, &[mode]).with(&[0; 32]), expected);
    }
}

#[test]
fn mrc_bytes_have_a_sign_unless_something_says_otherwise() {
    let bytes = Written::new(Endian::Little).integers(0, &[2, 1, 1, 0]);
    let check = |written: Written, expected: SampleType, n_warnings: usize| {
        let loaded = loaded(&written.with(&[1, 200]));
        assert_eq!(loaded.volume.sample_type(), expected);
        assert_eq!(loaded.warnings.len(), n_warnings, "{:?}", loaded.warnings);
    };
    let stamp = 1_146_047_817;
    let unsigned = bytes.clone().integers(152, &[stamp, 0]);
    assert!(Header::parse(&unsigned.bytes).unwrap().is_of_imod());
    check(unsigned, SampleType::U8, 0);
    check(bytes.clone().integers(152, &[stamp, 1]), SampleType::I8, 0);
    check(bytes.clone().floats(76, &[0.0, 200.0]), SampleType::U8, 1);
    check(bytes.clone().floats(76, &[-3.0, 100.0]), SampleType::I8, 0);
    check(bytes, SampleType::I8, 0);
}

/// Voxel (x, y, z) has the number x + 10y + 100z, in whatever order the file has them.
#[test]
fn mrc_axes_in_any_order() {
    let dims = [2, 3, 4];
    let expected: Vec<i16> = (0..4_i16)
        .flat_map(|z| (0..3).flat_map(move |y| (0..2).map(move |x| x + 10 * y + 100 * z)))
        .collect();
    for axes in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
        let sizes = axes.map(|axis: usize| dims[axis]);
        let place = [1_i16, 10, 100];
        let mut data = Vec::new();
        for section in 0..sizes[2] as i16 {
            for row in 0..sizes[1] as i16 {
                for column in 0..sizes[0] as i16 {
                    let [c, r, s] = axes.map(|axis| place[axis]);
                    data.extend((c * column + r * row + s * section).to_le_bytes());
                }
            }
        }
        let written = Written::new(Endian::Little)
            .integers(0, &sizes)
            .integers(16, &[5, 6, 7])
            .integers(28, &[2, 3, 4])
            .floats(40, &[2.0, 6.0, 12.0])
            .integers(64, &axes.map(|axis| axis as i32 + 1));
        let loaded = loaded(&written.with(&data));
        assert_eq!(loaded.volume.grid().dims(), [2, 3, 4]);
        assert_eq!(loaded.volume.samples(), &Samples::I16(expected.clone()), "{axes:?}");
        assert!(is_near(loaded.volume.grid().spacing(), [1e-7, 2e-7, 3e-7]));
        let mut first = [0.0; 3];
        for (stored, &axis) in axes.iter().enumerate() {
            first[axis] = (stored as f64 + 5.0) * (axis as f64 + 1.0) * 1e-7;
        }
        let place = loaded.volume.grid().world_from_index().translation;
        assert!(is_near(place.to_array(), first), "{axes:?} {place}");
    }
    let twice = Written::new(Endian::Little).integers(64, &[1, 1, 3]);
    check_error(&twice.counted(12), "not an MRC file");
}

#[test]
fn mrc_place() {
    let place = |written: &Written| {
        let loaded = loaded(&written.counted(12));
        let grid = loaded.volume.grid().world_from_index();
        (grid.translation.to_array(), loaded.warnings)
    };
    let [little, big] = both();
    let (at, warnings) = place(&big.floats(196, &[-10.0, 20.0, 30.0]));
    assert!(is_near(at, [-10e-7, 20e-7, 30e-7]) && warnings.is_empty(), "{at:?} {warnings:?}");
    let started = little.clone().integers(16, &[1, 2, 3]);
    assert!(is_near(place(&started).0, [2e-7, 6e-7, 12e-7]));
    let same = started.clone().floats(196, &[2.0, 6.0, 12.0]);
    assert_eq!(place(&same).1, [""; 0]);
    let (at, warnings) = place(&started.floats(196, &[1.0, 1.0, 1.0]));
    assert!(is_near(at, [1e-7; 3]) && warnings[0].contains("ORIGIN"), "{at:?} {warnings:?}");
    let unsized_voxels = little.clone().floats(40, &[0.0; 3]).floats(196, &[9.0; 3]);
    let loaded = loaded(&unsized_voxels.counted(12));
    assert_eq!(loaded.volume.grid().spacing(), [1.0; 3]);
    assert!(loaded.warnings[0].contains("1 x 1 x 1"), "{:?}", loaded.warnings);
    assert_eq!(place(&little.clone().floats(52, &[0.0; 3])), place(&little));
}

/// The angles between the edges are those of the header, and the volume is that of the cell.
#[test]
fn mrc_skewed_cells_are_sheared_grids() {
    let skewed = Written::new(Endian::Little).floats(52, &[80.0, 95.0, 120.0]);
    let m = loaded(&skewed.counted(12)).volume.grid().world_from_index().matrix3;
    let angle = |a: DVec3, b: DVec3| a.angle_between(b).to_degrees();
    assert!((angle(m.y_axis, m.z_axis) - 80.0).abs() < 1e-9);
    assert!((angle(m.x_axis, m.z_axis) - 95.0).abs() < 1e-9);
    assert!((angle(m.x_axis, m.y_axis) - 120.0).abs() < 1e-9);
    let lengths = [m.x_axis.length(), m.y_axis.length(), m.z_axis.length()];
    assert!(is_near(lengths, [2e-7, 3e-7, 4e-7]) && m.x_axis.y == 0.0 && 0.0 < m.z_axis.z);
    for angles in [[10.0, 10.0, 170.0], [90.0, 90.0, 0.0], [f32::NAN, 90.0, 90.0]] {
        let none = Written::new(Endian::Little).floats(52, &angles);
        check_error(&none.counted(12), "no cell has the angles");
    }
}

#[test]
fn mrc_stacks_are_times() {
    let stack =
        Written::new(Endian::Big).integers(0, &[3, 2, 4]).integers(36, &[2]).integers(88, &[401]);
    let bytes = stack.counted(24);
    let files = FilesInMemory::from_iter([("a.mrc", bytes.as_slice())]);
    let second = files.read_volume_with("a.mrc", &VolumeOptions::default().time(1)).unwrap();
    assert_eq!(second.volume.samples(), &Samples::I16((12..24).collect()));
    assert_eq!(second.choices.time.n, 2);
    let first = files.read_volume("a.mrc").unwrap();
    assert_eq!(first.warnings, ["there are 2 times: time 0 was taken"]);
    check_error(&stack.clone().integers(36, &[3]).counted(24), "no whole number of volumes");
    let images = stack.integers(88, &[0]).floats(48, &[8.0]);
    assert_eq!(loaded(&images.counted(24)).volume.grid().dims(), [3, 2, 4]);
}

#[test]
fn mrc_extended_headers_are_passed_over() {
    let written = Written::new(Endian::Little).integers(92, &[5]);
    let data: Vec<u8> = (0..12_i16).flat_map(i16::to_le_bytes).collect();
    let loaded = loaded(&written.with(&[&[9; 5], data.as_slice()].concat()));
    assert_eq!(loaded.volume.samples(), &Samples::I16((0..12).collect()));
    let long = Written::new(Endian::Little).integers(92, &[i32::MAX]);
    check_error(&long.counted(12), "needs 24 bytes of data, has 0");
    check_error(&Written::new(Endian::Little).integers(92, &[-1]).counted(12), "not an MRC file");
}

#[test]
fn mrc_lengths_that_are_wrong() {
    for written in both() {
        let whole = written.counted(12);
        check_error(&whole[..whole.len() - 1], "needs 24 bytes of data, has 23");
        check_error(&whole[..1000], "needs 24 bytes of data, has 0");
        check_error(&whole[..200], "not an MRC file");
        let longer = loaded(&[&whole, &[0; 3][..]].concat());
        assert!(longer.warnings[0].contains("more data"), "{:?}", longer.warnings);
        let huge = written.integers(0, &[1 << 24; 3]);
        check_error(&huge.counted(12), "too many voxels");
        let large = huge.integers(0, &[60_000, 60_000, 1]);
        check_error(&large.counted(12), "needs 7200000000 bytes of data, has 24");
    }
}

#[test]
fn mrc_packed_by_gzip() {
    use std::io::Write;
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("emd.map.gz");
    let file = std::fs::File::create(&path).unwrap();
    let mut encoder = flate2::write::GzEncoder::new(file, flate2::Compression::fast());
    encoder.write_all(&Written::new(Endian::Big).counted(12)).unwrap();
    encoder.finish().unwrap();
    let loaded = read_volume(&path).unwrap();
    assert_eq!(loaded.volume.samples(), &Samples::I16((0..12).collect()));
    let listing = list_volume(&path, &VolumeOptions::default()).unwrap();
    assert_eq!((listing.dims, listing.bytes()), ([3, 2, 2], 24));
}
