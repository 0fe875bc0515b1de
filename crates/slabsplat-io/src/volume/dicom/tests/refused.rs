//! What is not read, and what is guessed, says so.

use super::super::tags::{self, Tag};
use super::written::{BIG, DEFLATED, EXPLICIT, IMPLICIT, Short, Value, file, slice, text, with};
use super::{ct, read};
use crate::FilesInMemory;

#[test]
fn dicom_that_is_not_read_says_why() {
    let check = |changes: &[(Tag, Value)], expected: &str| {
        let error = read(&[file(EXPLICIT, &with(slice(0.0, [1; 4]), changes))]).unwrap_err();
        assert!(error.contains(expected), "{error} should contain {expected}");
        assert!(!error.contains('\n'), "{error}");
    };
    check(&[(tags::BITS_ALLOCATED, Short(1))], "pixels of 1 bits");
    check(&[(tags::HIGH_BIT, Short(16))], "do not fit into pixels of 16");
    check(&[(tags::BITS_STORED, Short(0))], "do not fit");
    check(&[(tags::PHOTOMETRIC, text("PALETTE COLOR"))], "`gdcmconv --apply-lut IN OUT`");
    check(&[(tags::PHOTOMETRIC, text("MO\n\u{1b}"))], "\"MO\\n");
    check(&[(tags::ROWS, Short(3))], "needs 12 bytes of data, has 8");
    check(&[(tags::ROWS, Short(0))], "empty");
    check(&[(tags::N_FRAMES, text("2"))], "needs 8 bytes of data, has 0");
    check(&[(tags::N_FRAMES, text("99999999"))], "99999999 frames");
    check(&[(tags::PIXEL_SPACING, text("1e-300\\1"))], "matrix");
    for (syntax, expected) in [
        ("1.2.840.10008.1.2.4.201", "HTJ2K, which cannot be read: save it as JPEG 2000"),
        ("1.2.840.10008.1.2.4.80", "its pixels should be in fragments"),
        ("1.2.3", "its transfer syntax \"1.2.3\""),
    ] {
        let error = read(&[file(syntax, &slice(0.0, [1; 4]))]).unwrap_err();
        assert!(error.contains(expected), "{error}");
    }
    let without_pixels = file(EXPLICIT, &slice(0.0, [1; 4])[..10]);
    let error = read(&[without_pixels]).unwrap_err();
    assert!(error.contains("no images in it"), "{error}");
}

#[test]
fn dicom_guesses_are_told() {
    let warnings = |changes: &[(Tag, Value)]| {
        let files = [0.0, 1.0].map(|z| file(EXPLICIT, &with(slice(z, [1; 4]), changes)));
        read(&files).unwrap().warnings.concat()
    };
    assert!(warnings(&[(tags::PHOTOMETRIC, text("MONOCHROME1"))]).contains("MONOCHROME1"));
    assert!(warnings(&[(tags::PIXEL_SPACING, text("?"))]).contains("how large pixels are"));
    assert!(warnings(&[(tags::IMAGE_ORIENTATION, text(""))]).contains("how slices are turned"));
    let lost = [(tags::IMAGE_POSITION, text("")), (tags::SLICE_THICKNESS, text("4"))];
    assert!(warnings(&lost).contains("4 mm apart was assumed"));
    let one = read(&ct(&[0.0])).unwrap().warnings.concat();
    assert!(one.contains("only one slice"), "{one}");
}

#[test]
fn dicom_cut_off_anywhere() {
    for syntax in [EXPLICIT, IMPLICIT, BIG, DEFLATED] {
        let whole = file(syntax, &slice(0.0, [1, 2, 3, 4]));
        // The last bytes of a packed file say only that it ends.
        let n_needed = whole.len() - if syntax == DEFLATED { 4 } else { 0 };
        for n_bytes in 0..n_needed {
            let files = FilesInMemory::from_iter([("a.dcm", &whole[..n_bytes])]);
            let error = files.read_volume("a.dcm").unwrap_err().to_string();
            assert!(error.contains("a.dcm") && !error.contains('\n'), "{error}");
        }
    }
}
