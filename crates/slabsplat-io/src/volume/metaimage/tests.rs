//! Whole MetaImage files, written here byte by byte.

use std::fs;
use std::io::Write;

use slabsplat_core::Samples;
use slabsplat_core::glam::DVec3;

use crate::store::read_from_both as read;
use crate::{VolumeFormat, VolumeOptions, list_volume};

const FIELDS: &str = "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = True\n\
                      ElementSpacing = 1 2 3\nDimSize = 2 2 1\nElementType = MET_SHORT\n";
const BIG: [u8; 8] = [0, 1, 0, 2, 0, 3, 255, 255];

fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

fn check(files: &[(&str, &[u8])]) {
    let loaded = read(files).unwrap();
    assert_eq!(loaded.volume.samples(), &Samples::I16(vec![1, 2, 3, -1]));
    assert_eq!((loaded.format, loaded.warnings), (VolumeFormat::MetaImage, vec![]));
}

fn check_error(files: &[(&str, &[u8])], expected: &str) {
    let err = read(files).unwrap_err();
    assert!(err.contains(expected), "{err} should contain {expected}");
    assert!(!err.contains('\n'), "{err} should be one line");
}

fn attached(fields: &str, data: &[u8]) -> Vec<u8> {
    [fields.as_bytes(), b"ElementDataFile = LOCAL\n", data].concat()
}

#[test]
fn metaimage_attached() {
    check(&[("a.mha", &attached(FIELDS, &BIG))]);
    check(&[("no-extension", &attached(FIELDS, &BIG))]);
    check(&[("a.nrrd", &attached(&FIELDS.replace('\n', "\r\n"), &BIG))]);
    let little = FIELDS.replace("MSB = True", "MSB = False");
    check(&[("a.mha", &attached(&little, &[1, 0, 2, 0, 3, 0, 255, 255]))]);
    let text = FIELDS.replace("BinaryData = True", "BinaryData = False");
    check(&[("a.mha", &attached(&text, b"1 2\n3 -1\n"))]);
    let other = FIELDS.replace("BinaryDataByteOrderMSB", "ElementByteOrderMSB");
    check(&[("a.mha", &attached(&other, &BIG))]);
}

#[test]
fn metaimage_of_wide_integers() {
    let data = [3_i64, -4, 5, 6].map(i64::to_be_bytes).concat();
    for (name, expected) in [
        ("MET_LONG_LONG", Samples::I32(vec![3, -4, 5, 6])),
        ("MET_ULONG_LONG", Samples::F64(vec![3.0, 18_446_744_073_709_551_612.0, 5.0, 6.0])),
    ] {
        let fields = FIELDS.replace("MET_SHORT", name);
        let loaded = read(&[("a.mha", &attached(&fields, &data))]).unwrap();
        assert_eq!(loaded.volume.samples(), &expected);
        assert_eq!(loaded.warnings.len(), 1, "{:?}", loaded.warnings);
    }
}

/// The size of packed data is wrong in many files.
#[test]
fn metaimage_packed() {
    for size in ["", "CompressedDataSize = 3\n", "CompressedDataSize = 99999999999\n"] {
        let fields = format!("{FIELDS}CompressedData = True\n{size}");
        check(&[("a.mha", &attached(&fields, &zlib(&BIG)))]);
        let detached = format!("{fields}ElementDataFile = b.zraw\n");
        check(&[("a.mhd", detached.as_bytes()), ("b.zraw", &zlib(&BIG))]);
    }
    let fields = format!("{FIELDS}CompressedData = True\n");
    check_error(&[("a.mha", &attached(&fields, &zlib(&BIG[..6])))], "needs 8 bytes of data, has 6");
    check_error(&[("a.mha", &attached(&fields, &[7; 99]))], "invalid gzip header");
}

#[test]
fn metaimage_detached() {
    let file = |data_file: &str| format!("{FIELDS}ElementDataFile = {data_file}\n");
    for name in ["b.raw", "a [1], b.raw", "b (2) c.raw"] {
        check(&[("a.mhd", file(name).as_bytes()), (name, &BIG)]);
    }
    let skipping = format!("{FIELDS}HeaderSize = 3\nElementDataFile = b.raw\n");
    check(&[("a.mhd", skipping.as_bytes()), ("b.raw", &[&[7; 3][..], &BIG].concat())]);
    let at_end = skipping.replace("= 3", "= -1").replace("NDims = -1", "NDims = 3");
    check(&[("a.mhd", at_end.as_bytes()), ("b.raw", &[&[7; 5][..], &BIG].concat())]);

    let two_slices = |data_file: &str| file(data_file).replace("2 2 1", "2 1 2");
    let halves = [&BIG[..4], &BIG[4..]];
    for (data_file, names) in [
        ("LIST\nx, y.raw\nz.raw", ["x, y.raw", "z.raw"]),
        ("LIST 2\nx.raw\nz.raw\n\n", ["x.raw", "z.raw"]),
        ("s%02d.raw 4 6 2", ["s04.raw", "s06.raw"]),
        ("s %d.raw 8 9", ["s 8.raw", "s 9.raw"]),
        ("s%d.raw", ["s1.raw", "s2.raw"]),
    ] {
        let header = two_slices(data_file);
        check(&[("a.mhd", header.as_bytes()), (names[0], halves[0]), (names[1], halves[1])]);
    }
    check_error(&[("a.mhd", file("b.raw").as_bytes())], "cannot read");
    check_error(&[("a.mhd", two_slices("s%d.raw 1 3 1").as_bytes())], "names 3 data files where 2");
    check_error(&[("a.mhd", two_slices("LIST 3\na\nb").as_bytes())], "1 to 2 axes, not \"3\"");
    check_error(&[("a.mhd", two_slices("LIST\na").as_bytes())], "names 1 data files where 2");
    check_error(&[("a.mhd", two_slices("s%d%d 1 2 1").as_bytes())], "not of the form");
}

/// The rows of the matrix are the directions of the axes, in LPS.
#[test]
fn metaimage_lies_in_ras() {
    let place = |more: &str| {
        let fields = format!("{FIELDS}{more}");
        read(&[("a.mha", &attached(&fields, &BIG))]).unwrap().volume.grid().world_from_index()
    };
    let plain = place("");
    assert_eq!(plain.matrix3.x_axis, DVec3::new(-1.0, 0.0, 0.0));
    assert_eq!(plain.matrix3.y_axis, DVec3::new(0.0, -2.0, 0.0));
    assert_eq!((plain.matrix3.z_axis, plain.translation), (DVec3::Z * 3.0, DVec3::ZERO));
    for [matrix, offset] in
        [["TransformMatrix", "Offset"], ["Rotation", "Origin"], ["Orientation", "Position"]]
    {
        let turned = place(&format!("{matrix} = 0 1 0 0 0 1 1 0 0\n{offset} = 5 6 7\n"));
        assert_eq!(turned.matrix3.x_axis, DVec3::new(0.0, -1.0, 0.0));
        assert_eq!(turned.matrix3.y_axis, DVec3::new(0.0, 0.0, 2.0));
        assert_eq!(turned.matrix3.z_axis, DVec3::new(-3.0, 0.0, 0.0));
        assert_eq!(turned.translation, DVec3::new(-5.0, -6.0, 7.0));
    }
    assert_eq!(place("AnatomicalOrientation = LPS\nCenterOfRotation = 1 2 3\n"), plain);
}

#[test]
fn metaimage_of_other_numbers_of_axes() {
    let four = FIELDS.replace("NDims = 3", "NDims = 4").replace("2 2 1", "2 2 1 2");
    let four = four.replace("1 2 3", "1 2 3 9");
    let loaded = read(&[("a.mha", &attached(&four, &[BIG, BIG].concat()))]).unwrap();
    assert_eq!(loaded.volume.samples(), &Samples::I16(vec![1, 2, 3, -1]));
    assert_eq!(loaded.volume.grid().spacing(), [1.0, 2.0, 3.0]);
    assert_eq!(loaded.warnings, ["there are 2 times: time 0 was taken"]);
    let times = format!("{four}ElementDataFile = t%d.raw 0 1 1\n");
    let files = [("a.mhd", times.as_bytes()), ("t0.raw", &BIG), ("t1.raw", &[0; 8])];
    assert_eq!(read(&files).unwrap().volume.samples(), &Samples::I16(vec![1, 2, 3, -1]));
    let two =
        FIELDS.replace("NDims = 3", "NDims = 2").replace("2 2 1", "2 2").replace("1 2 3", "4 5");
    let loaded = read(&[("a.mha", &attached(&two, &BIG))]).unwrap();
    assert_eq!(loaded.volume.grid().dims(), [2, 2, 1]);
    assert_eq!(loaded.volume.grid().spacing(), [4.0, 5.0, 1.0]);
}

#[test]
fn metaimage_warns_of_what_it_assumed() {
    let warnings =
        |fields: &str, data: &[u8]| read(&[("a.mha", &attached(fields, data))]).unwrap().warnings;
    let silent = FIELDS.replace("BinaryDataByteOrderMSB = True\n", "");
    assert_eq!(warnings(&silent, &BIG).len(), 1);
    let bytes = silent.replace("MET_SHORT", "MET_UCHAR");
    assert_eq!(warnings(&bytes, &BIG[..4]).len(), 0, "8 bits have no byte order");
    assert_eq!(warnings(FIELDS, &[&BIG[..], &[0]].concat()).len(), 1);
}

#[test]
fn metaimage_bad_headers_are_named() {
    let check = |from: &str, to: &str, expected: &str| {
        let fields = FIELDS.replace(from, to);
        check_error(&[("a.mha", &attached(&fields, &BIG))], expected);
    };
    check("DimSize = 2 2 1\n", "", "no field \"dimsize\"");
    check("2 2 1", "2 2", "dimsize should be 3 numbers");
    check("2 2 1", "2 2 2", "needs 16 bytes of data, has 8");
    check("2 2 1", "2 0 1", "empty");
    check("2 2 1", "99999 99999 99999", "too many voxels");
    check("NDims = 3", "NDims = 99999999", "has 99999999 axes");
    check("MET_SHORT", "MET_STRING", "\"MET_STRING\" cannot be read");
    check("1 2 3", "1 0 3", "cannot be inverted");
    check("1 2 3", "1 2 x", "elementspacing should be 3 numbers");
    check("MSB = True", "MSB = maybe", "not True or False");
    check("NDims", "ElementNumberOfChannels = 3\nNDims", "needs 24 bytes of data, has 8");
    check("NDims", "ElementNumberOfChannels = 0\nNDims", "no channels");
    check("NDims", "ElementNumberOfChannels = 18446744073709551615\nNDims", "bytes of data, has 8");
    check("NDims", "TransformMatrix = 1 0 0 1 0 0 0 0 1\nNDims", "cannot be inverted");
    check("NDims", "what is this\nNDims", "\"what is this\" in the header is no field");
    check_error(&[("a.mhd", FIELDS.as_bytes())], "does not say ElementDataFile");
    check_error(&[("a.mhd", b"not a header")], "not a MetaImage file");
}

#[test]
fn metaimage_tells_its_size_by_its_header() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.mhd");
    fs::write(&path, format!("{FIELDS}ElementDataFile = gone.raw\n")).unwrap();
    assert_eq!(list_volume(&path, &VolumeOptions::default()).unwrap().bytes(), 8);
}

#[test]
fn metaimage_channels_and_times_are_chosen() {
    let four = FIELDS.replace("NDims = 3", "NDims = 4").replace("2 2 1", "1 1 1 2");
    let four = four.replace("1 2 3", "1 2 3 9") + "ElementNumberOfChannels = 2\n";
    let text = four.replace("BinaryData = True", "BinaryData = False");
    let packed = format!("{four}CompressedData = True\n");
    for bytes in
        [attached(&four, &BIG), attached(&text, b"1 2 3 -1"), attached(&packed, &zlib(&BIG))]
    {
        let files = crate::FilesInMemory::from_iter([("a.mha", bytes.as_slice())]);
        for (time, channel, sample) in [(0, 0, 1), (0, 1, 2), (1, 0, 3), (1, 1, -1)] {
            let options = VolumeOptions::default().time(time).channel(channel);
            let loaded = files.read_volume_with("a.mha", &options).unwrap();
            assert_eq!(loaded.volume.samples(), &Samples::I16(vec![sample]));
            assert_eq!(loaded.warnings, [""; 0]);
        }
    }
    let times = format!("{four}ElementDataFile = t%d.raw 0 1 1\n");
    let files = [("a.mhd", times.as_bytes()), ("t0.raw", &BIG[..4]), ("t1.raw", &BIG[4..])];
    let files = crate::FilesInMemory::from_iter(files);
    let loaded = files.read_volume_with("a.mhd", &VolumeOptions::default().time(1)).unwrap();
    assert_eq!(loaded.volume.samples(), &Samples::I16(vec![3]));
}

/// What ITK writes of a new image says nothing; what somebody has set does.
#[test]
fn metaimage_stands_as_somebody_has_said() {
    use slabsplat_core::Orientation::{Anatomical, Unknown};
    let new = "TransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 0 0 0\n";
    let cube = FIELDS.replace("1 2 3", "1 1 1");
    for (fields, expected) in [
        (FIELDS.to_owned(), Unknown),
        (format!("{new}{cube}"), Unknown),
        (format!("{new}{FIELDS}"), Anatomical),
        (format!("{}{cube}", new.replace("0 0 0\n", "0 -7 0\n")), Anatomical),
        (format!("{}{cube}", new.replace("1 0 0 0 1 0 0 0 1", "0 1 0 -1 0 0 0 0 1")), Anatomical),
    ] {
        let loaded = read(&[("a.mha", &attached(&fields, &BIG))]).unwrap();
        assert_eq!(loaded.acquisition.orientation, expected, "{fields}");
    }
}
