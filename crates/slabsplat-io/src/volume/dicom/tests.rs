//! Whole DICOM files, written here element by element.

use slabsplat_core::glam::DVec3;
use slabsplat_core::{ColorSamples, Samples};

use super::tags::{self, Tag};
use crate::{FilesInMemory, IoError, LoadedVolume, VolumeFormat, VolumeOptions};

const EXPLICIT: &str = "1.2.840.10008.1.2.1";
const IMPLICIT: &str = "1.2.840.10008.1.2";
const BIG: &str = "1.2.840.10008.1.2.2";
const DEFLATED: &str = "1.2.840.10008.1.2.1.99";
const RLE: &str = "1.2.840.10008.1.2.5";

/// An element's value, as it is written.
#[derive(Clone)]
enum Value {
    Text(String),
    Short(u16),
    Items(Vec<Vec<(Tag, Value)>>),
    Words(Vec<u16>),
    Fragments(Vec<Vec<u8>>),
}

use Value::{Fragments, Items, Short, Text, Words};

fn text(text: &str) -> Value {
    Text(text.to_owned())
}

/// Of a slice of 2 × 2 pixels at a height.
fn slice(z: f64, pixels: [u16; 4]) -> Vec<(Tag, Value)> {
    vec![
        (tags::IMAGE_TYPE, text("ORIGINAL\\PRIMARY\\AXIAL")),
        (tags::MODALITY, text("CT")),
        (tags::SERIES_DESCRIPTION, text("head")),
        (tags::SERIES_UID, text("1.2.3")),
        (tags::SERIES_NUMBER, text("7")),
        (tags::INSTANCE_NUMBER, text(&format!("{}", 100.0 - z))),
        (tags::IMAGE_POSITION, text(&format!("10\\20\\{z}"))),
        (tags::IMAGE_ORIENTATION, text("1\\0\\0\\0\\1\\0")),
        (tags::SAMPLES_PER_PIXEL, Short(1)),
        (tags::PHOTOMETRIC, text("MONOCHROME2")),
        (tags::ROWS, Short(2)),
        (tags::COLUMNS, Short(2)),
        (tags::PIXEL_SPACING, text("3\\2")),
        (tags::BITS_ALLOCATED, Short(16)),
        (tags::BITS_STORED, Short(12)),
        (tags::HIGH_BIT, Short(11)),
        (tags::PIXEL_REPRESENTATION, Short(0)),
        (tags::INTERCEPT, text("-1024")),
        (tags::SLOPE, text("1")),
        (tags::PIXEL_DATA, Words(pixels.to_vec())),
    ]
}

/// The same with other elements, in their order.
fn with(mut elements: Vec<(Tag, Value)>, changes: &[(Tag, Value)]) -> Vec<(Tag, Value)> {
    for (tag, value) in changes {
        elements.retain(|(other, _)| other != tag);
        elements.push((*tag, value.clone()));
    }
    elements.sort_by_key(|(tag, _)| *tag);
    elements
}

struct Writer {
    is_explicit: bool,
    is_big: bool,
    bytes: Vec<u8>,
}

impl Writer {
    fn short(&mut self, number: u16) {
        self.bytes.extend(if self.is_big { number.to_be_bytes() } else { number.to_le_bytes() });
    }

    fn long(&mut self, number: u32) {
        self.bytes.extend(if self.is_big { number.to_be_bytes() } else { number.to_le_bytes() });
    }

    fn element(&mut self, (group, element): Tag, representation: &[u8; 2], value: &[u8], n: u32) {
        self.short(group);
        self.short(element);
        let is_long = matches!(representation, b"SQ" | b"OW" | b"OB");
        if self.is_explicit && group != 0xfffe {
            self.bytes.extend(representation);
            if is_long {
                self.short(0);
                self.long(n);
            } else {
                self.short(n as u16);
            }
        } else {
            self.long(n);
        }
        self.bytes.extend(value);
    }

    fn all(&mut self, elements: &[(Tag, Value)]) {
        for (tag, value) in elements {
            self.one(*tag, value);
        }
    }

    fn one(&mut self, tag: Tag, value: &Value) {
        let part = |this: &Self, write: &dyn Fn(&mut Self)| {
            let mut part = Self { bytes: vec![], ..*this };
            write(&mut part);
            part.bytes
        };
        match value {
            Text(text) => {
                let mut bytes = text.clone().into_bytes();
                bytes.resize(bytes.len().next_multiple_of(2), b' ');
                let is_code = tag == tags::IMAGE_TYPE;
                let representation = if is_code { b"CS" } else { b"LO" };
                self.element(tag, representation, &bytes, bytes.len() as u32);
            }
            Short(number) => {
                let bytes = part(self, &|part| part.short(*number));
                self.element(tag, b"US", &bytes, 2);
            }
            Words(words) => {
                let bytes = part(self, &|part| words.iter().for_each(|word| part.short(*word)));
                self.element(tag, b"OW", &bytes, bytes.len() as u32);
            }
            // Every second sequence ends by an element, and every second item.
            Items(items) => {
                let bytes = part(self, &|part| {
                    for (idx, item) in items.iter().enumerate() {
                        let mut inner = Self { bytes: vec![], ..*part };
                        inner.all(item);
                        let n = inner.bytes.len() as u32;
                        let is_open = idx.is_multiple_of(2);
                        let item = (0xfffe, 0xe000);
                        part.element(item, b"UN", &inner.bytes, if is_open { u32::MAX } else { n });
                        if is_open {
                            part.element((0xfffe, 0xe00d), b"UN", &[], 0);
                        }
                    }
                });
                let is_open = items.len() % 2 == 1;
                let n = if is_open { u32::MAX } else { bytes.len() as u32 };
                self.element(tag, b"SQ", &bytes, n);
                if is_open {
                    self.element((0xfffe, 0xe0dd), b"UN", &[], 0);
                }
            }
            Fragments(fragments) => {
                let bytes = part(self, &|part| {
                    for fragment in fragments {
                        part.element((0xfffe, 0xe000), b"UN", fragment, fragment.len() as u32);
                    }
                    part.element((0xfffe, 0xe0dd), b"UN", &[], 0);
                });
                self.element(tag, b"OB", &bytes, u32::MAX);
            }
        }
    }
}

/// A file of these elements in a transfer syntax.
fn file(syntax: &str, elements: &[(Tag, Value)]) -> Vec<u8> {
    let mut meta = Writer { is_explicit: true, is_big: false, bytes: vec![0; 128] };
    meta.bytes.extend(b"DICM");
    meta.one(tags::TRANSFER_SYNTAX, &text(syntax));
    let mut writer =
        Writer { is_explicit: syntax != IMPLICIT, is_big: syntax == BIG, bytes: Vec::new() };
    writer.all(elements);
    let mut body = writer.bytes;
    if syntax == DEFLATED {
        use std::io::Write;
        let level = flate2::Compression::fast();
        let mut encoder = flate2::write::DeflateEncoder::new(Vec::new(), level);
        encoder.write_all(&body).unwrap();
        body = encoder.finish().unwrap();
    }
    [meta.bytes, body].concat()
}

fn read_with(files: &[Vec<u8>], options: &VolumeOptions) -> Result<LoadedVolume, IoError> {
    // Names in an order that is none.
    let names: Vec<String> = (0..files.len()).map(|idx| format!("in/{}", (idx * 7) % 10)).collect();
    let files = names.iter().map(String::as_str).zip(files.iter().map(Vec::as_slice));
    FilesInMemory::from_iter(files).read_volume_with("in", options)
}

fn read(files: &[Vec<u8>]) -> Result<LoadedVolume, String> {
    read_with(files, &VolumeOptions::default()).map_err(|error| error.to_string())
}

fn ct(heights: &[f64]) -> Vec<Vec<u8>> {
    let slices = heights.iter().map(|&z| slice(z, [1, 2, 3, 1000_u16.saturating_add(z as u16)]));
    slices.map(|elements| file(EXPLICIT, &elements)).collect()
}

fn samples(loaded: &LoadedVolume) -> Vec<u16> {
    let Samples::U16(samples) = loaded.volume.samples() else { panic!("{loaded:?}") };
    samples.clone()
}

#[test]
fn dicom_slices_are_sorted_by_place() {
    let loaded = read(&ct(&[5.0, -5.0, 10.0, 0.0])).unwrap();
    assert_eq!(loaded.format, VolumeFormat::Dicom);
    assert_eq!(loaded.warnings, [""; 0]);
    assert_eq!(loaded.volume.grid().dims(), [2, 2, 4]);
    let lasts: Vec<u16> = samples(&loaded).into_iter().skip(3).step_by(4).collect();
    assert_eq!(lasts, [1000, 1000, 1005, 1010], "−5 is 0 as an unsigned number");
    assert_eq!(loaded.volume.value(0), -1023.0);
    let affine = loaded.volume.grid().world_from_index();
    assert_eq!(affine.matrix3.x_axis, DVec3::new(-2.0, 0.0, 0.0));
    assert_eq!(affine.matrix3.y_axis, DVec3::new(0.0, -3.0, 0.0));
    assert_eq!(affine.matrix3.z_axis, DVec3::new(0.0, 0.0, 5.0));
    assert_eq!(affine.translation, DVec3::new(-10.0, -20.0, -5.0));
}

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

/// A gantry that leans: every slice is 2 mm further along y than the one below.
#[test]
fn dicom_gantry_tilt_is_a_shear() {
    let tilted = [0.0, 4.0, 8.0].map(|z| {
        let position = text(&format!("10\\{}\\{z}", 20.0 + z / 2.0));
        file(EXPLICIT, &with(slice(z, [1, 2, 3, 4]), &[(tags::IMAGE_POSITION, position)]))
    });
    let loaded = read(&tilted).unwrap();
    assert_eq!(loaded.warnings, [""; 0]);
    let affine = loaded.volume.grid().world_from_index();
    assert_eq!(affine.matrix3.z_axis, DVec3::new(0.0, -2.0, 4.0));
}

#[test]
fn dicom_missing_slices_are_made() {
    let files = [0.0, 2.0, 4.0, 8.0].map(|z| file(EXPLICIT, &slice(z, [0, 10 * z as u16, 0, 0])));
    let loaded = read(&files).unwrap();
    assert_eq!(loaded.volume.grid().dims(), [2, 2, 5]);
    assert_eq!(loaded.volume.grid().spacing(), [2.0, 3.0, 2.0]);
    let seconds: Vec<u16> = samples(&loaded).into_iter().skip(1).step_by(4).collect();
    assert_eq!(seconds, [0, 20, 40, 60, 80]);
    let [warning] = &loaded.warnings[..] else { panic!("{:?}", loaded.warnings) };
    assert!(warning.contains("2.000 to 4.000 mm apart, and 1 seem to be missing"), "{warning}");
    assert!(warning.contains("5 slices 2.000 mm apart"), "{warning}");
    let far = read(&ct(&[0.0, 2.0, 4.0, 1e6])).unwrap();
    assert_eq!(far.volume.grid().dims(), [2, 2, 17], "no more than four times as many");
}

/// A scan that is finer in its lower half: not one of its slices is lost.
#[test]
fn dicom_finer_parts_stay_fine() {
    let heights = [0.0, 1.0, 2.0, 3.0, 7.0, 11.0, 15.0, 19.0];
    let files = heights.map(|z| file(EXPLICIT, &slice(z, [0, 10 * z as u16, 0, 0])));
    let loaded = read(&files).unwrap();
    assert_eq!(loaded.volume.grid().dims(), [2, 2, 20]);
    let seconds: Vec<u16> = samples(&loaded).into_iter().skip(1).step_by(4).collect();
    assert_eq!(seconds, std::array::from_fn::<u16, 20, _>(|z| 10 * z as u16));
    let expected =
        "slices are 1.000 to 4.000 mm apart: the volume was resampled to 20 slices 1.000 mm apart";
    assert_eq!(loaded.warnings, [expected]);
}

#[test]
fn dicom_series_are_chosen() {
    let other = [0.0, 3.0].map(|z| {
        let changes = [(tags::SERIES_UID, text("9.9")), (tags::SERIES_NUMBER, text("2"))];
        file(EXPLICIT, &with(slice(z, [9, 9, 9, 9]), &changes))
    });
    let files = [ct(&[0.0, 1.0, 2.0]), other.to_vec(), vec![b"not an image".to_vec()]].concat();
    let loaded = read(&files).unwrap();
    assert_eq!(loaded.volume.grid().dims(), [2, 2, 3]);
    let expected = [
        "CT 2 \"head\", 2 slices of 2 x 2".to_owned(),
        "CT 7 \"head\", 3 slices of 2 x 2".to_owned(),
    ];
    assert_eq!(loaded.choices.series.names, expected);
    assert_eq!(loaded.choices.series.chosen, 1);
    let expected =
        ["files that hold no slices were passed over: 1", "there are 2 series: series 1 was taken"];
    assert_eq!(loaded.warnings, expected);
    let first = read_with(&files, &VolumeOptions::default().series(0)).unwrap();
    assert_eq!(first.volume.grid().dims(), [2, 2, 2]);
    let error = read_with(&files, &VolumeOptions::default().series(2)).unwrap_err().to_string();
    assert!(error.starts_with("in: there is no series 2: there is 0 to 1 (0 CT 2"), "{error}");
}

/// What lists the files of a folder is named for them.
#[test]
fn dicom_folders_are_named_by_what_lists_them() {
    let slices = ct(&[0.0, 1.0]);
    let list = file(EXPLICIT, &slice(0.0, [1; 4])[..3]);
    let files = [("in/DICOMDIR", &list), ("in/a/1", &slices[0]), ("in/a/2", &slices[1])];
    let files = FilesInMemory::from_iter(files.map(|(name, bytes)| (name, bytes.as_slice())));
    for path in ["in/DICOMDIR", "in"] {
        let loaded = files.read_volume(path).unwrap();
        assert_eq!(loaded.volume.grid().dims(), [2, 2, 2], "{path}");
        assert_eq!(loaded.warnings, [""; 0], "{path}");
    }
}

#[test]
fn dicom_times_and_echoes_are_chosen() {
    let at = |z: f64, echo: &str, time: &str, value: u16| {
        let changes = [(tags::ECHO_NUMBER, text(echo)), (tags::TEMPORAL_POSITION, text(time))];
        file(EXPLICIT, &with(slice(z, [value; 4]), &changes))
    };
    let mut files = Vec::new();
    for z in [0.0, 1.0] {
        for echo in [2, 1] {
            for time in [3, 1, 2] {
                let value = 100 * z as u16 + 10 * echo + time;
                files.push(at(z, &echo.to_string(), &time.to_string(), value));
            }
        }
    }
    let names: Vec<String> = (0..files.len()).map(|idx| format!("in/{idx}")).collect();
    let files = names.iter().map(String::as_str).zip(files.iter().map(Vec::as_slice));
    let files = FilesInMemory::from_iter(files);
    let read = |channel, time| {
        let options = VolumeOptions::default().channel(channel).time(time);
        files.read_volume_with("in", &options).unwrap()
    };
    assert_eq!(samples(&read(0, 0))[..5], [11, 11, 11, 11, 111]);
    assert_eq!(samples(&read(1, 2))[..5], [23, 23, 23, 23, 123]);
    assert_eq!(read(0, 0).choices.channel.names, ["AXIAL, echo 1", "AXIAL, echo 2"]);
}

#[test]
fn dicom_slices_with_scalings_of_their_own_are_floats() {
    let files = [0.0, 1.0].map(|z| {
        let slope = text(&format!("{}", 0.5 + z));
        file(
            EXPLICIT,
            &with(slice(z, [4; 4]), &[(tags::SLOPE, slope), (tags::INTERCEPT, text("1"))]),
        )
    });
    let loaded = read(&files).unwrap();
    let expected = Samples::F32(vec![3.0, 3.0, 3.0, 3.0, 7.0, 7.0, 7.0, 7.0]);
    assert_eq!(loaded.volume.samples(), &expected);
    assert!(loaded.warnings[0].contains("scalings of their own"), "{:?}", loaded.warnings);
}

/// An enhanced image: frames say where they are in groups of their own, here from above to below.
#[test]
fn dicom_frames_of_one_file() {
    let shared = vec![
        (tags::PIXEL_MEASURES, Items(vec![vec![(tags::PIXEL_SPACING, text("1\\2"))]])),
        (
            tags::PLANE_ORIENTATION,
            Items(vec![vec![(tags::IMAGE_ORIENTATION, text("0\\1\\0\\0\\0\\-1"))]]),
        ),
        (tags::PIXEL_TRANSFORMATION, Items(vec![vec![(tags::SLOPE, text("2"))]])),
    ];
    let changes = [
        (tags::N_FRAMES, text("3")),
        (tags::SHARED_GROUPS, Items(vec![shared])),
        (
            tags::PER_FRAME_GROUPS,
            Items(
                [8, 4, 0]
                    .map(|x| {
                        let position = vec![(tags::IMAGE_POSITION, text(&format!("{}\\0\\0", -x)))];
                        vec![(tags::PLANE_POSITION, Items(vec![position]))]
                    })
                    .to_vec(),
            ),
        ),
        (tags::PIXEL_DATA, Words((1..=12).collect())),
    ];
    let mut elements = with(slice(0.0, [0; 4]), &changes);
    elements.retain(|(tag, _)| {
        !matches!(*tag, tags::IMAGE_POSITION | tags::IMAGE_ORIENTATION | tags::PIXEL_SPACING)
            && !matches!(*tag, tags::SLOPE | tags::INTERCEPT)
    });
    for syntax in [EXPLICIT, IMPLICIT, BIG, DEFLATED] {
        let bytes = file(syntax, &elements);
        let files = FilesInMemory::from_iter([("a", bytes.as_slice())]);
        let loaded = files.read_volume("a").unwrap_or_else(|error| panic!("{syntax}: {error}"));
        assert_eq!(loaded.warnings, [""; 0], "{syntax}");
        // The normal is −x, along which the first frame is the highest.
        assert_eq!(samples(&loaded), [9, 10, 11, 12, 5, 6, 7, 8, 1, 2, 3, 4], "{syntax}");
        assert_eq!(loaded.volume.value(0), 18.0);
        let affine = loaded.volume.grid().world_from_index();
        assert_eq!(affine.matrix3.x_axis, DVec3::new(0.0, -2.0, 0.0));
        assert_eq!(affine.matrix3.y_axis, DVec3::new(0.0, 0.0, -1.0));
        assert_eq!(affine.matrix3.z_axis, DVec3::new(4.0, 0.0, 0.0));
    }
}

#[test]
fn dicom_colors_are_channels() {
    for (planar, words) in [
        (0, [0x0201, 0x0403, 0x0605, 0x0807, 0x0a09, 0x0c0b]),
        (1, [0x0401, 0x0a07, 0x0502, 0x0b08, 0x0603, 0x0c09]),
    ] {
        let changes = [
            (tags::SAMPLES_PER_PIXEL, Short(3)),
            (tags::PLANAR, Short(planar)),
            (tags::PHOTOMETRIC, text("RGB")),
            (tags::BITS_ALLOCATED, Short(8)),
            (tags::BITS_STORED, Short(8)),
            (tags::HIGH_BIT, Short(7)),
            (tags::PIXEL_DATA, Words(words.to_vec())),
        ];
        let files = [file(EXPLICIT, &with(slice(0.0, [0; 4]), &changes))];
        let loaded = read_with(&files, &VolumeOptions::default().channel(1)).unwrap();
        assert_eq!(loaded.volume.samples(), &Samples::U8(vec![2, 5, 8, 11]), "{planar}");
        assert_eq!(loaded.choices.channel.names, ["red", "green", "blue"]);
        let all = read(&files).unwrap();
        let colors = ColorSamples::U8(vec![[1, 2, 3], [4, 5, 6], [7, 8, 9], [10, 11, 12]]);
        assert_eq!(all.volume.samples(), &colors.luminances(), "{planar}");
        let voxels = all.colors.unwrap().voxels.unwrap();
        assert_eq!(voxels.samples(), &colors, "{planar}");
    }
}

/// Gray, and red and blue as PS3.3 has them: 76.2, 85.0 and 255.5; 29.1, 255.5 and 107.3.
#[test]
fn dicom_luminance_and_differences_are_colors() {
    for (planar, words) in [
        (0, [0x8080, 0x4c80, 0xff55, 0xff1d, 0x806b, 0x8080]),
        (1, [0x4c80, 0x801d, 0x5580, 0x80ff, 0xff80, 0x806b]),
    ] {
        let changes = [
            (tags::SAMPLES_PER_PIXEL, Short(3)),
            (tags::PLANAR, Short(planar)),
            (tags::PHOTOMETRIC, text("YBR_FULL")),
            (tags::BITS_ALLOCATED, Short(8)),
            (tags::BITS_STORED, Short(8)),
            (tags::HIGH_BIT, Short(7)),
            (tags::PIXEL_DATA, Words(words.to_vec())),
        ];
        let files = [file(EXPLICIT, &with(slice(0.0, [0; 4]), &changes))];
        let of_channel = |channel| {
            let loaded = read_with(&files, &VolumeOptions::default().channel(channel)).unwrap();
            loaded.volume.samples().clone()
        };
        let expected = [[128, 254, 0, 128], [128, 0, 0, 128], [128, 0, 254, 128]];
        for (channel, expected) in expected.into_iter().enumerate() {
            assert_eq!(of_channel(channel), Samples::U8(expected.to_vec()), "{planar}, {channel}");
        }
        let wide = [(tags::BITS_STORED, Short(7)), (tags::HIGH_BIT, Short(6))];
        let error = read(&[file(EXPLICIT, &with(with(slice(0.0, [0; 4]), &changes), &wide))]);
        assert!(error.unwrap_err().contains("YBR_FULL of 7 bits"));
    }
}

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
