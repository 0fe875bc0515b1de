//! The ways in which one file can be written.

use slabsplat_core::Samples;

use super::super::tags;
use super::written::{
    BIG, DEFLATED, EXPLICIT, Fragments, IMPLICIT, RLE, Short, file, slice, text, with,
};
use super::{ct, read, samples};

#[test]
fn dicom_is_written_in_several_ways() {
    let expected = read(&ct(&[0.0, 5.0])).unwrap();
    for syntax in [IMPLICIT, BIG, DEFLATED] {
        let files = [0.0, 5.0]
            .map(|z| file(syntax, &slice(z, [1, 2, 3, 1000_u16.saturating_add(z as u16)])));
        let loaded = read(&files).unwrap_or_else(|error| panic!("{syntax}: {error}"));
        assert_eq!(loaded.volume.samples(), expected.volume.samples(), "{syntax}");
        assert_eq!(loaded.volume.grid(), expected.volume.grid(), "{syntax}");
    }
    let headless = ct(&[0.0, 5.0]).map_all(|file| file[132 + 28..].to_vec());
    assert_eq!(read(&headless).unwrap().volume.samples(), expected.volume.samples());
}

trait MapAll {
    fn map_all(self, change: impl Fn(Vec<u8>) -> Vec<u8>) -> Vec<Vec<u8>>;
}

impl MapAll for Vec<Vec<u8>> {
    fn map_all(self, change: impl Fn(Vec<u8>) -> Vec<u8>) -> Vec<Vec<u8>> {
        self.into_iter().map(change).collect()
    }
}

#[test]
fn dicom_run_lengths() {
    let segment = |bytes: [u8; 4]| [&[3][..], &bytes, &[128]].concat();
    let mut packed = [2_u32, 64, 70].iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<_>>();
    packed.resize(64, 0);
    packed.extend([segment([0, 0, 0, 3]), segment([1, 2, 3, 232])].concat());
    let elements = with(slice(0.0, [0; 4]), &[(tags::PIXEL_DATA, Fragments(vec![vec![], packed]))]);
    let loaded = read(&[file(RLE, &elements)]).unwrap();
    assert_eq!(samples(&loaded), [1, 2, 3, 1000]);
}

#[test]
fn dicom_bits_that_are_not_stored_are_none() {
    let changes = [(tags::PIXEL_REPRESENTATION, Short(1)), (tags::INTERCEPT, text("0"))];
    let elements = with(slice(0.0, [0xf001, 0x0fff, 0x0800, 0x07ff]), &changes);
    let loaded = read(&[file(EXPLICIT, &elements)]).unwrap();
    assert_eq!(loaded.volume.samples(), &Samples::I16(vec![1, -1, -2048, 2047]));
}

/// A lossless JPEG that gdcm 3 wrote of these numbers.
#[test]
fn dicom_lossless_jpeg() {
    const JPEG: &str = "ffd8ffc3000b100003000401011100ffc40019000003000300000000000000000000000001070c0a0b10ff\
                        da0008010100010000e72391c97ffc00ac8cece001277e6fffd900";
    let byte = |at: usize| u8::from_str_radix(&JPEG[at..at + 2], 16).unwrap();
    let jpeg: Vec<u8> = (0..JPEG.len()).step_by(2).map(byte).collect();
    let changes = |jpeg: Vec<u8>| {
        let pixels = Fragments(vec![vec![], jpeg]);
        [(tags::ROWS, Short(3)), (tags::COLUMNS, Short(4)), (tags::PIXEL_DATA, pixels)]
    };
    let syntax = "1.2.840.10008.1.2.4.70";
    let read = |jpeg| read(&[file(syntax, &with(slice(0.0, [0; 4]), &changes(jpeg)))]);
    let expected = [0, 100, 200, 300, 4095, 5, 77, 1024, 1, 2, 3, 2000];
    assert_eq!(samples(&read(jpeg.clone()).unwrap()), expected);
    let error = read(jpeg[..20].to_vec()).unwrap_err();
    assert!(error.contains("its JPEG is broken"), "{error}");
    let other = [&jpeg[..8], &[9], &jpeg[9..]].concat();
    assert!(
        read(other).unwrap_err().contains("4 x 9 pixels of 1 values, other than the file says")
    );
    // Of two components, which what unpacks JPEG has no name for.
    let two = [&jpeg[..5], &[14], &jpeg[6..11], &[2, 1, 17, 0, 2, 17, 0], &jpeg[15..]].concat();
    assert!(read(two).unwrap_err().contains("pixels of 2 values"));
}
