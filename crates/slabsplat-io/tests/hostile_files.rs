//! Files that once broke a reader, or made it take memory or time that they do not pay for, as small as they
//! can be made. `tests/fuzz` finds such files; what is found is mended at its root, and kept here.

mod peak;
#[expect(dead_code, reason = "other tests spoil more of them")]
mod small_files;

use std::io::Write;

use peak::check_peak;
use slabsplat_io::FilesInMemory;
use small_files::{dicom, nrrd_header};

/// What reading the first of some files says against it.
fn refused(files: &[(&str, &[u8])]) -> String {
    let name = files[0].0;
    let result = FilesInMemory::from_iter(files.iter().copied()).read_volume(name);
    check_peak(name);
    result.map(|loaded| loaded.warnings).expect_err(name).to_string()
}

/// `bytes` with `from`, which is there once, in another form.
fn with(bytes: &[u8], from: &[u8], to: &[u8]) -> Vec<u8> {
    let at: Vec<usize> = (0..bytes.len()).filter(|&at| bytes[at..].starts_with(from)).collect();
    assert_eq!(at.len(), 1, "{from:?}");
    [&bytes[..at[0]], to, &bytes[at[0] + from.len()..]].concat()
}

/// A header that names a file by bytes that command a terminal.
#[test]
fn names_in_messages_are_printable() {
    let header = nrrd_header("raw") + "data file: a\u{1b}[2J.raw\n";
    let message = refused(&[("a.nhdr", header.as_bytes())]);
    assert_eq!(message, "cannot read a\u{fffd}[2J.raw: there is no such file in memory");
    let ply = b"ply\nformat ascii 1.0\nelement a\x1b[2J 1\nproperty int a\nend_header\nx\n";
    let message = FilesInMemory::from_iter([("a.ply", &ply[..])]).read_mesh("a.ply");
    let message = message.map(|loaded| loaded.format).expect_err("no number").to_string();
    assert_eq!(message, "a.ply: a\u{fffd}[2J 0 of 1: \"x\" is not a number");
}

const EXPLICIT: &str = "1.2.840.10008.1.2.1";

/// A DICOM file whose elements are `elements` and then those of a small one, packed.
fn deflated_after(elements: impl Iterator<Item = &'static [u8]>) -> Vec<u8> {
    let plain = dicom(EXPLICIT);
    let start = plain.windows(4).position(|window| window == [8, 0, 0x60, 0]);
    let start = start.expect("the small file begins so");
    let packed = dicom("1.2.840.10008.1.2.1.99");
    // The name of its transfer syntax is longer by two bytes.
    let meta = &packed[..start + 2];
    let level = flate2::Compression::fast();
    let mut encoder = flate2::write::DeflateEncoder::new(meta.to_vec(), level);
    elements.for_each(|element| encoder.write_all(element).expect("memory can be written"));
    encoder.write_all(&plain[start..]).expect("memory can be written");
    encoder.finish().expect("memory can be written")
}

/// A million frames, each of which would have taken some hundred bytes to describe.
#[test]
fn dicom_frames_without_pixels() {
    let without_groups = with(&dicom(EXPLICIT), b"\x00\x52\x30\x92SQ", b"\x00\x52\x31\x92SQ");
    let frames = b"\x28\x00\x08\x00LO\x08\x001048576 ";
    let bytes = with(&without_groups, b"\x28\x00\x08\x00LO\x02\x002 ", frames);
    let message = refused(&[("a.dcm", &bytes)]);
    assert!(message.contains("says to have 1048576 frames, and has room for 2"), "{message}");
}

#[test]
fn dicom_items_without_end() {
    let items = std::iter::repeat_n(&b"\xfe\xff\x00\xe0\0\0\0\0"[..], 1 << 21);
    let sequence = std::iter::once(&b"\x00\x52\x30\x92SQ\0\0\xff\xff\xff\xff"[..]).chain(items);
    let bytes = deflated_after(sequence);
    assert!(bytes.len() < 1 << 17, "{} bytes", bytes.len());
    let message = refused(&[("a.dcm", &bytes)]);
    assert!(message.contains("more than a million items"), "{message}");
}

/// An element that is in the file 17 million times is kept once.
#[test]
fn dicom_elements_without_end() {
    let elements = [&b"\x08\x00\x60\x00LO\0\0"[..]; 1 << 10].concat();
    let elements: &'static [u8] = elements.leak();
    let bytes = deflated_after(std::iter::repeat_n(elements, 17 << 10));
    FilesInMemory::from_iter([("a.dcm", &bytes[..])]).read_volume("a.dcm").unwrap();
    check_peak("a.dcm");
}

#[test]
fn dicom_numbers_at_the_end_of_their_range() {
    let plain = dicom(EXPLICIT);
    let high_bit = with(&plain, b"\x02\x01US\x02\0\x0b\0", b"\x02\x01US\x04\0\xff\xff\xff\xff");
    let message = refused(&[("a.dcm", &high_bit)]);
    assert!(message.contains("up to bit 4294967295 do not fit"), "{message}");
    let wide = with(&plain, b"\x10\0US\x02\0\x03\0", b"\x10\0US\x04\0\xff\xff\xff\xff");
    let wide = with(&wide, b"\x11\0US\x02\0\x04\0", b"\x11\0US\x04\0\xff\xff\xff\xff");
    let wide = with(&wide, b"\x02\0US\x02\0\x01\0", b"\x02\0US\x02\0\x03\0");
    let wide = with(&wide, b"MONOCHROME2 ", b"RGB         ");
    let message = refused(&[("a.dcm", &wide)]);
    assert!(message.contains("too many voxels"), "{message}");
}

/// A thousand pages of 2048 × 2048 pixels that are all the same strip of 4 KiB.
#[test]
fn tiff_pages_of_one_strip() {
    let strip = small_files::zlib(&vec![0; 1 << 22]);
    let mut bytes = b"II*\0\0\0\0\0".to_vec();
    bytes.extend(&strip);
    let n_pages = 1000;
    for page_idx in 0..n_pages {
        let at = bytes.len() as u32;
        let link = if page_idx == 0 { 4 } else { bytes.len() - 4 };
        bytes[link..link + 4].copy_from_slice(&at.to_le_bytes());
        let entries = [
            (256_u16, 2048),
            (257, 2048),
            (258, 8),
            (259, 8),
            (262, 1),
            (273, 8),
            (277, 1),
            (278, 2048),
            (279, strip.len() as u32),
        ];
        bytes.extend((entries.len() as u16).to_le_bytes());
        for (tag, value) in entries {
            bytes.extend([tag, 4].map(u16::to_le_bytes).concat());
            bytes.extend([1, value].map(u32::to_le_bytes).concat());
        }
        bytes.extend([0; 4]);
    }
    let message = refused(&[("a.tif", &bytes)]);
    assert!(message.contains("more than the file could unpack to"), "{message}");
}

/// A value has 2^61 parts, of 8 bytes each.
#[test]
fn nrrd_digits_of_too_many_channels() {
    let header = nrrd_header("hex")
        .replace("short", "double")
        .replace("dimension: 3", "dimension: 4")
        .replace("4 3 2", "2305843009213693952 1 1 1")
        .replace("directions:", "directions: none")
        .replace("kinds:", "kinds: vector");
    let message = refused(&[("a.nrrd", (header + "\n00").as_bytes())]);
    assert!(message.contains("bytes as digits"), "{message}");
}

/// A list with one file five thousand times, as a volume of 320 MiB.
#[test]
fn nrrd_list_of_one_file() {
    let header = nrrd_header("raw").replace("4 3 2", "256 128 5000");
    let header = header + "data file: LIST\n" + &"a.raw\n".repeat(5000);
    let message = refused(&[("a.nhdr", header.as_bytes()), ("a.raw", &[7; 1 << 16])]);
    assert!(message.contains("more than once"), "{message}");
}

/// Twenty million chunks of one voxel, none of which is there: looking for each took a minute.
#[test]
fn zarr_chunks_that_are_nowhere() {
    let array = r#"{"zarr_format": 2, "shape": [1, 1, 20000000], "chunks": [1, 1, 1], "dtype": "|u1",
        "order": "C", "compressor": null, "fill_value": 0, "filters": null}"#;
    let files = FilesInMemory::from_iter([("a.zarr/.zarray", array.as_bytes())]);
    let message = files.read_volume("a.zarr").map(|loaded| loaded.warnings);
    let message = message.expect_err("too many").to_string();
    assert!(message.contains("more than a million chunks"), "{message}");
}

/// A chunk of one block, which is 1.5 GiB of zeros in 48 KiB.
#[test]
fn blosc_block_without_end() {
    const N_BYTES: u32 = 12 << 27;
    // A frame of zstd with blocks of 128 KiB that repeat one byte (RFC 8878 §3.1.1).
    let mut zstd = b"\x28\xb5\x2f\xfd\x00\x58".to_vec();
    for block_idx in (0..N_BYTES >> 17).rev() {
        let header = (1 << 17) << 3 | 1 << 1 | u32::from(block_idx == 0);
        zstd.extend(&header.to_le_bytes()[..3]);
        zstd.push(0);
    }
    let n_packed = zstd.len() as u32;
    let header = [2, 1, 4 << 5 | 16, 1];
    let words = [N_BYTES, N_BYTES, 24 + n_packed, 20, n_packed].map(u32::to_le_bytes).concat();
    let chunk = [&header, &words[..], &zstd].concat();
    let array = format!(
        r#"{{"zarr_format": 2, "shape": [1, 1, 9], "chunks": [1, 1, {N_BYTES}], "dtype": "|u1", "order": "C",
        "compressor": {{"id": "blosc"}}, "fill_value": 0, "filters": null}}"#
    );
    let files = [("a.zarr/.zarray", array.as_bytes()), ("a.zarr/0.0.0", &chunk)];
    let result = FilesInMemory::from_iter(files).read_volume("a.zarr");
    check_peak("a.zarr");
    let message = result.map(|loaded| loaded.warnings).expect_err("a bomb").to_string();
    assert!(message.contains("blocks"), "{message}");
}

/// A JPEG of 8 × 8 pixels that says to have as many rows as it can.
#[test]
fn jpeg_of_most_rows() {
    let mut jpeg = Vec::new();
    let encoder = image::codecs::jpeg::JpegEncoder::new(&mut jpeg);
    let gray = image::ExtendedColorType::L8;
    image::ImageEncoder::write_image(encoder, &[7; 64], 8, 8, gray).unwrap();
    let of_rows = |rows: u16| {
        let [high, low] = rows.to_be_bytes();
        with(&jpeg, b"\xff\xc0\0\x0b\x08\0\x08", &[0xff, 0xc0, 0, 0x0b, 8, high, low])
    };
    let tall = of_rows(65_535);
    let slices = ["slices/a.jpg", "slices/b.jpg"].map(|name| (name, tall.as_slice()));
    let message = FilesInMemory::from_iter(slices).read_volume("slices");
    let message = message.map(|loaded| loaded.warnings).unwrap_err().to_string();
    assert!(message.contains("more than 65528 rows"), "{message}");
}
