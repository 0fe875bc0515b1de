//! The example of the standard (T.87 §H.3), whole and spoilt.
//! `crates/slabsplat-io/tests/dicom_codecs.rs` has what CharLS writes.

use super::super::coded::CodedImage;
use super::super::frame::{Colors, Layout};
use super::unpack;

const EXAMPLE: &str = "ffd8fff7000b080004000401011100ffda0008010100000000c000006c80208e01c00000574000006ee6\
    000001bc18000005d800009160ffd9";

const PIXELS: [i32; 16] = [0, 0, 90, 74, 68, 50, 43, 205, 64, 145, 145, 145, 100, 145, 145, 145];

const LAYOUT: Layout = Layout {
    rows: 4,
    columns: 4,
    n_channels: 1,
    colors: Colors::Gray,
    is_planar: false,
    bits_allocated: 8,
    bits_stored: 8,
    high_bit: 7,
    is_signed: false,
    is_float: false,
    is_inverse: false,
};

fn example() -> Vec<u8> {
    let byte = |at: usize| u8::from_str_radix(&EXAMPLE[at..at + 2], 16).unwrap();
    (0..EXAMPLE.len()).step_by(2).map(byte).collect()
}

#[test]
fn jpeg_ls_example_of_the_standard() {
    let expected = CodedImage { samples: PIXELS.to_vec(), precision: 8, is_signed: false };
    assert_eq!(unpack(&example(), &LAYOUT), Ok(expected));
}

#[test]
fn jpeg_ls_that_is_not_read_says_why() {
    let check = |at: usize, byte: u8, expected: &str| {
        let mut bytes = example();
        bytes[at] = byte;
        let error = unpack(&bytes, &LAYOUT).expect_err(expected);
        assert!(error.contains(expected), "{error} should contain {expected}");
    };
    check(0, 0, "does not begin as one");
    check(6, 12, "samples have 12 bits");
    check(8, 5, "4 x 5 pixels");
    check(19, 2, "header of a scan is broken");
    check(21, 1, "mapping tables");
    check(22, 200, "presets are broken");
    check(24, 1, "shifted samples");
    check(3, 0xf6, "a scan comes before its frame");
    for n_bytes in 0..example().len() - 3 {
        assert!(unpack(&example()[..n_bytes], &LAYOUT).is_err(), "{n_bytes} bytes");
    }
}

/// A blank line takes a bit, and no more is taken than the lines that come.
#[test]
fn jpeg_ls_runs_end_with_lines() {
    let layout = Layout { rows: 8, columns: 32, ..LAYOUT };
    let mut bytes = example();
    bytes.truncate(25);
    (bytes[8], bytes[10]) = (8, 32);
    let with = |bits: &[u8]| unpack(&[&bytes, bits, &[0xff, 0xd9]].concat(), &layout);
    // 8 lines of zeros: the runs of the first are 1, 1, 1, 1, 2, 2, 2, 2, 4, 4, 4, 4 and 4 of 8 long.
    let expected = vec![0; 8 * 32];
    assert_eq!(with(&[0xff, 0x7f, 0xff, 0x7f]).map(|image| image.samples), Ok(expected));
    assert_eq!(with(&[0xff]), Err("it is cut off".to_owned()));
    // A run of as many as are left, of which the last would be no sample's place.
    assert_eq!(with(&[0xff, 0x7b, 0x80]), Err("a run is longer than its line".to_owned()));
}
