//! Whole NRRD files, written here byte by byte.

use std::io::Write;
use std::path::Path;

use slabsplat_core::Samples;

use crate::store::read_from_both as read;
use crate::{FilesInMemory, VolumeOptions, read_volume};

const RAW: &str = "NRRD0004\ntype: short\ndimension: 3\nsizes: 2 2 1\nencoding: raw\nendian: big\n";
const BIG: [u8; 8] = [0, 1, 0, 2, 0, 3, 255, 255];

fn expected() -> Samples {
    Samples::I16(vec![1, 2, 3, -1])
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

fn check(files: &[(&str, &[u8])]) {
    let loaded = read(files).unwrap();
    assert_eq!(loaded.volume.samples(), &expected());
    assert_eq!(loaded.warnings, [""; 0]);
}

fn check_error(files: &[(&str, &[u8])], expected: &str) {
    let err = read(files).unwrap_err();
    assert!(err.contains(expected), "{err} should contain {expected}");
    assert!(!err.contains('\n'), "{err} should be one line");
}

fn attached(header: &str, data: &[u8]) -> Vec<u8> {
    [header.as_bytes(), b"\n", data].concat()
}

#[test]
fn nrrd_attached() {
    check(&[("a.nrrd", &attached(RAW, &BIG))]);
    let dos = RAW.replace('\n', "\r\n") + "\r";
    check(&[("a.nrrd", &attached(&dos, &BIG))]);
    let little = RAW.replace("big", "little");
    check(&[("a.nrrd", &attached(&little, &[1, 0, 2, 0, 3, 0, 255, 255]))]);
    check(&[("no-extension", &attached(RAW, &BIG))]);
}

/// In every encoding, and also one channel of several.
#[test]
fn nrrd_of_wide_integers() {
    let header =
        |encoding: &str| RAW.replace("short", "unsigned long long int").replace("raw", encoding);
    let check = |numbers: [u64; 4], expected: Samples, kept: &str| {
        let bytes = numbers.map(u64::to_be_bytes).concat();
        let hex: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        let text = numbers.map(|number| number.to_string()).join(" ");
        for (encoding, data) in [
            ("raw", bytes.clone()),
            ("gzip", gzip(&bytes)),
            ("hex", hex.into_bytes()),
            ("text", text.into_bytes()),
        ] {
            let loaded = read(&[("a.nrrd", &attached(&header(encoding), &data))]).unwrap();
            assert_eq!(loaded.volume.samples(), &expected, "{encoding}");
            assert!(loaded.warnings[0].contains(kept), "{:?}", loaded.warnings);
            assert_eq!(loaded.warnings.len(), 1, "{:?}", loaded.warnings);
        }
    };
    check([1, 2, 3, 4], Samples::I32(vec![1, 2, 3, 4]), "uint64 became int32");
    check([1, 2, 3, 1 << 31], Samples::U32(vec![1, 2, 3, 1 << 31]), "uint64 became uint32");
    let large = Samples::F64(vec![1.0, 2.0, 3.0, 1_099_511_627_776.0]);
    check([1, 2, 3, 1 << 40], large, "uint64 became float64");
    let rounded = Samples::F64(vec![1.0, 2.0, 3.0, 18_446_744_073_709_551_615.0]);
    check([1, 2, 3, u64::MAX], rounded, "were rounded to float64");
    check_error(&[("a.nrrd", &attached(&header("text"), b"1 2 3 -4"))], "\"-4\" is not a number");
    let short = attached(&header("raw"), &[0; 31]);
    check_error(&[("a.nrrd", &short)], "needs 32 bytes of data, has 31");

    let channels = header("raw")
        .replace("sizes: 2 2 1", "sizes: 2 2 1 1")
        .replace("dimension: 3", "dimension: 4")
        + "kinds: vector domain domain domain\n";
    let data = [1, 2, 3, 1 << 31].map(u64::to_be_bytes).concat();
    let bytes = attached(&channels, &data);
    let files = FilesInMemory::from_iter([("a.nrrd", bytes.as_slice())]);
    let second = files.read_volume_with("a.nrrd", &VolumeOptions::default().channel(1)).unwrap();
    assert_eq!(second.volume.samples(), &Samples::U32(vec![2, 1 << 31]));
}

fn bzip2(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::best());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

#[test]
fn nrrd_packed_by_bzip2() {
    let packed = RAW.replace("raw", "bzip2");
    check(&[("a.nrrd", &attached(&packed, &bzip2(&BIG)))]);
    // What Python's bz2 makes of the eight bytes.
    const BZ2: &str =
        "425a6839314159265359b69772590000004000f8000000a00030cd00c346a0cdc5dc914e14242da5dc9640";
    let byte = |at: usize| u8::from_str_radix(&BZ2[at..at + 2], 16).unwrap();
    let by_python: Vec<u8> = (0..BZ2.len()).step_by(2).map(byte).collect();
    let detached = attached(&format!("{packed}data file: b.bz2\n"), b"");
    check(&[("a.nhdr", &detached), ("b.bz2", &by_python)]);
    let streams = [bzip2(&BIG[..3]), bzip2(&BIG[3..])].concat();
    check(&[("a.nrrd", &attached(&packed.replace("bzip2", "bz2"), &streams))]);
    let at_end = format!("{packed}byte skip: -1\n");
    check(&[("a.nrrd", &attached(&at_end, &bzip2(&[&[9; 5][..], &BIG].concat())))]);
    let short = attached(&packed, &bzip2(&BIG[..7]));
    check_error(&[("a.nrrd", &short)], "needs 8 bytes of data, has 7");
    check_error(&[("a.nrrd", &attached(&packed, &BIG))], "a.nrrd");
    let mut wrong = bzip2(&BIG);
    wrong[12] ^= 1;
    check_error(&[("a.nrrd", &attached(&packed, &wrong))], "a.nrrd");
    let whole = attached(&packed, &bzip2(&BIG));
    for n_bytes in 0..whole.len() {
        assert!(read(&[("a.nrrd", &whole[..n_bytes])]).is_err(), "{n_bytes} bytes");
    }
}

/// 48 MiB of zeros in a hundred bytes: what is not asked for is not unpacked into memory, and what is said to
/// be there beyond that takes none.
#[test]
fn nrrd_bombs_of_bzip2_are_cut_short() {
    let packed = RAW.replace("raw", "bzip2");
    let bomb = bzip2(&vec![0; 48 << 20]);
    assert!(bomb.len() < 200, "{}", bomb.len());
    let loaded = read(&[("a.nrrd", &attached(&packed, &bomb))]).unwrap();
    assert_eq!(loaded.volume.samples(), &Samples::I16(vec![0; 4]));
    assert_eq!(loaded.warnings.len(), 1, "{:?}", loaded.warnings);
    let huge = packed.replace("2 2 1", "60000 60000 1");
    check_error(&[("a.nrrd", &attached(&huge, &bzip2(&BIG)))], "needs 7200000000 bytes of data");
}

#[test]
fn nrrd_encodings() {
    let gz = RAW.replace("raw", "gzip");
    check(&[("a.nrrd", &attached(&gz, &gzip(&BIG)))]);
    let skipping = format!("{gz}byte skip: 3\n");
    check(&[("a.nrrd", &attached(&skipping, &gzip(&[&[9; 3][..], &BIG].concat())))]);
    let text = RAW.replace("raw", "ascii");
    check(&[("a.nrrd", &attached(&text, b"1 2\n3,\t-1\n"))]);
    check_error(&[("a.nrrd", &attached(&text, b"1 2 3"))], "needs 4 numbers, has 3");
    check_error(&[("a.nrrd", &attached(&text, b"1 2 3 70000"))], "\"70000\" is not a number");
    check_error(&[("a.nrrd", &attached(&text, b"1 2 3 x"))], "\"x\" is not a number");
    for other in ["xz", "rot13"] {
        let header = RAW.replace("raw", other);
        check_error(&[("a.nrrd", &attached(&header, &BIG))], "is not supported");
    }
}

#[test]
fn nrrd_detached() {
    let header = format!("{RAW}data file: b.raw\n");
    check(&[("a.nhdr", header.as_bytes()), ("b.raw", &BIG)]);
    let skipping = format!("{RAW}line skip: 2\nbyte skip: 1\ndata file: b.raw\n");
    let data = [b"one\ntwo\nx", &BIG[..]].concat();
    check(&[("a.nhdr", skipping.as_bytes()), ("b.raw", &data)]);
    let at_end = format!("{RAW}byte skip: -1\ndata file: b.raw\n");
    check(&[("a.nhdr", at_end.as_bytes()), ("b.raw", &data)]);
    let patterned = format!("{RAW}data file: b%02d 1 2 1 1\n").replace("2 2 1", "2 1 2");
    check(&[("a.nhdr", patterned.as_bytes()), ("b01", &BIG[..4]), ("b02", &BIG[4..])]);
    let listed = format!("{RAW}data file: LIST\nx\ny\n").replace("2 2 1", "2 1 2");
    check(&[("a.nhdr", listed.as_bytes()), ("x", &BIG[..4]), ("y", &BIG[4..])]);
    check_error(&[("a.nhdr", header.as_bytes())], "cannot read");
    check_error(&[("a.nhdr", listed.as_bytes()), ("x", &BIG[..4]), ("y", &BIG[..3])], "has 3");
}

#[test]
fn nrrd_warns_of_what_it_assumed() {
    let warnings =
        |header: &str, data: &[u8]| read(&[("a.nrrd", &attached(header, data))]).unwrap().warnings;
    assert_eq!(warnings(RAW, &[&BIG[..], &[0]].concat()).len(), 1);
    assert_eq!(warnings(&RAW.replace("endian: big\n", ""), &BIG).len(), 1);
    let bytes = RAW.replace("short", "uchar").replace("endian: big\n", "");
    assert_eq!(warnings(&bytes, &BIG[..4]).len(), 0, "8 bits have no byte order");
}

#[test]
fn nrrd_bad_headers_are_named() {
    let check = |from: &str, to: &str, expected: &str| {
        let header = RAW.replace(from, to);
        check_error(&[("a.nrrd", &attached(&header, &BIG))], expected);
    };
    check("NRRD0004", "NRRD0007", "NRRD0001 to NRRD0005");
    check("type: short\n", "", "no field \"type\"");
    check("short", "block", "\"block\" cannot be read");
    check("encoding: raw\n", "", "no field \"encoding\"");
    check("big", "middle", "endian");
    check("2 2 1", "2 2 2", "needs 16 bytes of data, has 8");
    check("2 2 1", "2 0 1", "empty");
    check("2 2 1", "99999 99999 99999", "too many voxels");
    check("2 2 1", "18446744073709551615 2 2", "too many voxels");
    check("2 2 1", "99999999999999999999 2 2", "sizes should be");
    check("endian: big", "endian: big\nspacings: 0 1 1", "cannot be inverted");
    check("endian: big", "endian: big\nspacings: 1 1 inf", "cannot be inverted");
    check("endian: big", "endian: big\nbyte skip: 1e3", "byte skip");
    check("encoding: raw", "encoding: hex", "as digits, has room for 4");
    check("encoding: raw", "encoding: gzip", "needs 8 bytes of data, has 0");
    let gzip = RAW.replace("raw", "gzip");
    check_error(&[("a.nrrd", &attached(&gzip, &[7; 99]))], "invalid gzip header");
}

#[test]
fn nrrd_four_axes() {
    let header = RAW.replace("dimension: 3", "dimension: 4").replace("2 2 1", "1 2 2 1");
    check(&[("a.nrrd", &attached(&header, &BIG))]);
    let colors = header + "kinds: domain 2-color 2-color domain\n";
    check_error(&[("a.nrrd", &attached(&colors, &BIG))], "in space");
}

#[test]
fn nrrd_gone() {
    let err = read_volume(Path::new("/nonexistent/a.nrrd")).unwrap_err().to_string();
    assert!(err.starts_with("cannot read /nonexistent/a.nrrd: "), "{err}");
}

#[test]
fn nrrd_channels_and_times_are_chosen() {
    let check = |header: &str, data: &[u8], [time, channel]: [usize; 2], expected: &[i16]| {
        let bytes = attached(header, data);
        let files = FilesInMemory::from_iter([("a.nrrd", bytes.as_slice())]);
        let options = VolumeOptions::default().time(time).channel(channel);
        let loaded = files.read_volume_with("a.nrrd", &options).unwrap();
        assert_eq!(loaded.volume.samples(), &Samples::I16(expected.to_vec()), "{header}");
        assert_eq!(loaded.warnings, [""; 0]);
    };
    let four = RAW.replace("dimension: 3", "dimension: 4").replace("2 2 1", "2 1 1 2");
    let colors = format!("{four}kinds: vector domain domain domain\n");
    check(&colors, &BIG, [0, 0], &[1, 3]);
    check(&colors, &BIG, [0, 1], &[2, -1]);
    check(&colors.replace("raw", "gzip"), &gzip(&BIG), [0, 1], &[2, -1]);
    check(&colors.replace("raw", "text"), b"1 2 3 -1", [0, 1], &[2, -1]);
    check(&colors.replace("raw", "hex"), b"0001 0002 00 03\nFFff", [0, 1], &[2, -1]);
    let times = format!("{four}kinds: domain domain domain list\n");
    check(&times, &BIG, [1, 0], &[3, -1]);
    check(&times.replace("raw", "gzip"), &gzip(&BIG), [1, 0], &[3, -1]);
    check(&times.replace("raw", "hex"), b"000100020003ffff", [1, 0], &[3, -1]);
    let files = format!("{times}data file: LIST 3\nx\ny\n");
    let files = [("a.nhdr", files.as_bytes()), ("x", &BIG[..4]), ("y", &BIG[4..])];
    let files = FilesInMemory::from_iter(files);
    let loaded = files.read_volume_with("a.nhdr", &VolumeOptions::default().time(1)).unwrap();
    assert_eq!(loaded.volume.samples(), &Samples::I16(vec![3, -1]));
    let first = files.read_volume("a.nhdr").unwrap();
    assert_eq!(first.warnings, ["there are 2 times: time 0 was taken"]);
}

/// teem, ITK and pynrrd read the last bytes of what is unpacked.
#[test]
fn nrrd_packed_data_at_the_end() {
    let header = RAW.replace("raw", "gzip") + "byte skip: -1\n";
    check(&[("a.nrrd", &attached(&header, &gzip(&[&[9; 5][..], &BIG].concat())))]);
    let header = header.replace("-1", "-5");
    check_error(&[("a.nrrd", &attached(&header, &gzip(&BIG)))], "a byte skip is -1");
}

#[test]
fn nrrd_whose_data_file_is_a_folder() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::create_dir(dir.path().join("b")).unwrap();
    let path = dir.path().join("a.nhdr");
    for name in ["b", "."] {
        std::fs::write(&path, format!("{RAW}data file: {name}\n")).unwrap();
        let error = read_volume(&path).unwrap_err().to_string();
        assert!(error.ends_with("it is a folder, not a file"), "{error}");
    }
}

/// However long a field is, and whatever it would do to a terminal.
#[test]
fn nrrd_fields_are_cited_in_part() {
    let long = "x\u{1b}[2J".repeat(100_000);
    for header in [
        RAW.replace("short", &long),
        RAW.replace("2 2 1", &long),
        RAW.replace("big", &long),
        format!("{RAW}byte skip: {long}\n"),
        format!("{RAW}data file: {long}\n"),
        format!("{RAW}{long}\n"),
    ] {
        let error = read(&[("a.nrrd", &attached(&header, &BIG))]).unwrap_err();
        assert!(error.len() < 1000 && !error.contains('\u{1b}'), "{} bytes", error.len());
    }
}
