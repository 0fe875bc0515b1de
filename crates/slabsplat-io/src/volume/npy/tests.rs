//! Whole files of NumPy, written here byte by byte.

use slabsplat_core::Samples;

use super::super::zip::written::zip;
use crate::store::read_from_both as read;
use crate::{FilesInMemory, VolumeFormat, VolumeOptions};

/// An array of version 1.
fn npy(descr: &str, is_fortran: bool, shape: &str, data: &[u8]) -> Vec<u8> {
    let order = if is_fortran { "True" } else { "False" };
    let text = format!("{{'descr': {descr}, 'fortran_order': {order}, 'shape': {shape}, }}");
    let text = format!("{text:<117}\n");
    let length = (text.len() as u16).to_le_bytes();
    [&b"\x93NUMPY\x01\x00"[..], &length, text.as_bytes(), data].concat()
}

fn samples(bytes: &[u8]) -> Samples {
    let loaded = read(&[("a.npy", bytes)]).unwrap();
    assert_eq!(loaded.format, VolumeFormat::Npy);
    loaded.volume.samples().clone()
}

#[test]
fn npy_of_every_type() {
    let check = |descr: &str, data: &[u8], expected: Samples| {
        let file = npy(descr, false, "(1, 1, 2)", data);
        assert_eq!(samples(&file), expected, "{descr}");
    };
    check("'|b1'", &[0, 1], Samples::U8(vec![0, 1]));
    check("'|u1'", &[7, 255], Samples::U8(vec![7, 255]));
    check("'|i1'", &[7, 255], Samples::I8(vec![7, -1]));
    check("'<u2'", &[1, 2, 3, 4], Samples::U16(vec![0x201, 0x403]));
    check("'>u2'", &[1, 2, 3, 4], Samples::U16(vec![0x102, 0x304]));
    check("'>i2'", &[255, 254, 0, 1], Samples::I16(vec![-2, 1]));
    check("'<u4'", &[1, 0, 0, 128, 2, 0, 0, 0], Samples::U32(vec![0x8000_0001, 2]));
    check("'>i4'", &[0, 0, 0, 9, 255, 255, 255, 255], Samples::I32(vec![9, -1]));
    check("'<f2'", &[0, 0x3c, 0, 0xc0], Samples::F32(vec![1.0, -2.0]));
    check("'>f2'", &[0x3c, 0, 0x7c, 0], Samples::F32(vec![1.0, f32::INFINITY]));
    let float = |value: f32| value.to_be_bytes();
    check("'>f4'", &[float(0.5), float(-3.0)].concat(), Samples::F32(vec![0.5, -3.0]));
    let double = |value: f64| value.to_le_bytes();
    check("'<f8'", &[double(0.1), double(1e300)].concat(), Samples::F64(vec![0.1, 1e300]));
    let wide = |value: i64| value.to_be_bytes();
    check("'>i8'", &[wide(-3), wide(40)].concat(), Samples::I32(vec![-3, 40]));
    check("'>u8'", &[wide(-1), wide(0)].concat(), Samples::F64(vec![u64::MAX as f64, 0.0]));
}

/// The same array in both orders of memory is the same volume.
#[test]
fn npy_axes_are_z_y_x_in_either_order() {
    let value = |[z, y, x]: [usize; 3]| (100 * z + 10 * y + x) as u8;
    let (mut rows, mut columns) = (Vec::new(), Vec::new());
    for z in 0..2 {
        for y in 0..3 {
            rows.extend((0..4).map(|x| value([z, y, x])));
        }
    }
    for x in 0..4 {
        for y in 0..3 {
            columns.extend((0..2).map(|z| value([z, y, x])));
        }
    }
    for (is_fortran, data) in [(false, &rows), (true, &columns)] {
        let loaded = read(&[("a.npy", &npy("'|u1'", is_fortran, "(2, 3, 4)", data))]).unwrap();
        assert_eq!(loaded.volume.grid().dims(), [4, 3, 2]);
        assert_eq!(loaded.volume.samples(), &Samples::U8(rows.clone()));
    }
}

#[test]
fn npy_parts_are_chosen() {
    let data: Vec<u8> = (0..48).collect();
    let read_part = |shape: &str, options: &VolumeOptions| {
        let file = npy("'|u1'", false, shape, &data);
        let files = FilesInMemory::from_iter([("a.npy", file.as_slice())]);
        files.read_volume_with("a.npy", options).unwrap()
    };
    let second = read_part("(2, 2, 3, 4)", &VolumeOptions::default().time(1));
    assert_eq!(second.volume.samples(), &Samples::U8((24..48).collect()));
    assert_eq!(second.choices.time.n, 2);
    let file = npy("'|u1'", false, "(1, 5, 5, 3)", &[1, 2, 3].repeat(25));
    let files = FilesInMemory::from_iter([("a.npy", file.as_slice())]);
    let options = VolumeOptions::default().channel(2);
    let third = files.read_volume_with("a.npy", &options).unwrap();
    assert_eq!(third.volume.samples(), &Samples::U8(vec![3; 25]));
}

#[test]
fn npz_arrays_are_chosen_by_name() {
    let small = npy("'<f8'", false, "(2,)", &[0; 16]);
    let [ct, mr] = [1, 2].map(|value| npy("'|u1'", false, "(2, 3, 4)", &[value; 24]));
    for packs in [false, true] {
        let file = zip(&[("spacing.npy", &small), ("ct.npy", &ct), ("mr.npy", &mr)], packs);
        let files = FilesInMemory::from_iter([("a.npz", file.as_slice())]);
        let read = |path: &str| files.read_volume(path).map_err(|error| error.to_string());
        let first = read("a.npz").unwrap();
        assert_eq!(first.volume.samples(), &Samples::U8(vec![1; 24]));
        assert_eq!(first.choices.series.names, ["spacing", "ct", "mr"]);
        assert!(first.warnings.iter().any(|w| w.contains("series 1 was taken")));
        let second = read("a.npz:mr").unwrap();
        assert_eq!(second.volume.samples(), &Samples::U8(vec![2; 24]));
        let error = read("a.npz:pet").unwrap_err();
        assert!(error.contains("no array \"pet\": there is spacing, ct, mr"), "{error}");
        let by_number = files.read_volume_with("a.npz", &VolumeOptions::default().series(2));
        assert_eq!(by_number.unwrap().volume.samples(), &Samples::U8(vec![2; 24]));
    }
}

#[test]
fn npy_errors_are_plain() {
    let check = |bytes: &[u8], expected: &str| {
        let error = read(&[("a.npy", bytes)]).unwrap_err();
        assert!(error.contains(expected) && !error.contains('\n'), "{error} lacks {expected}");
    };
    let of = |descr: &str, shape: &str| npy(descr, false, shape, &[0; 24]);
    check(&of("'|O'", "(2, 3, 4)"), "Python objects");
    check(&of("[('x', '<f4')]", "(2, 3, 4)"), "several fields");
    check(&of("'<f8'", "(2, 3, 4)"), "needs 192 bytes of data, has 24");
    check(&of("'|u1'", "(24,)"), "1 axes is no volume");
    check(&of("'|u1'", "(2, 0, 4)"), "empty");
    check(&of("'|u1'", "(99999999999, 99999999999, 99999999999)"), "too many voxels");
    check(&of("'|u1'", "(1000000, 60000, 2, 2, 2)"), "needs 480000000000 bytes");
    check(&of("'|u1'", "(2, 3, 4)")[..60], "cut off");
    check(b"\x93NUMPY\x09\x00", "version 9");
    check(b"garbage", "not a NumPy file");
    let error = read(&[("a.npz", &zip(&[("a.txt", b"text")], false))]).unwrap_err();
    assert!(error.contains("no arrays of NumPy"), "{error}");
    let mut damaged = zip(&[("a.npy", &of("'|u1'", "(2, 3, 4)"))], false);
    damaged[170] = 1;
    let error = read(&[("a.npz", &damaged)]).unwrap_err();
    assert!(error.contains("checksum"), "{error}");
}
