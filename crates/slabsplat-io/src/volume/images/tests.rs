//! Folders of images, made here.

use std::path::Path;

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use slabsplat_core::{SampleType, Samples};
use tiff::encoder::TiffEncoder;
use tiff::encoder::colortype::{CMYK8, Gray32Float};

use crate::{LoadedVolume, VolumeFormat, VolumeOptions, list_volume, read_volume};

/// 3 × 2 pixels.
const SIZE: [u32; 2] = [3, 2];

fn png(samples: &[u8], color: ExtendedColorType) -> Vec<u8> {
    let mut bytes = Vec::new();
    PngEncoder::new(&mut bytes).write_image(samples, SIZE[0], SIZE[1], color).unwrap();
    bytes
}

fn png8(first: u8) -> Vec<u8> {
    png(&(first..first + 6).collect::<Vec<u8>>(), ExtendedColorType::L8)
}

fn tiff(pages: &[[f32; 6]]) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut bytes).unwrap();
    for page in pages {
        encoder.write_image::<Gray32Float>(SIZE[0], SIZE[1], page).unwrap();
    }
    bytes.into_inner()
}

/// A gray JPEG of 8 × 8 pixels, all of them 128: no codes but those for a difference of 0, and for the end
/// of a block.
fn jpeg() -> Vec<u8> {
    let mut bytes = vec![0xff, 0xd8, 0xff, 0xdb, 0, 67, 0];
    bytes.extend([1; 64]);
    bytes.extend([0xff, 0xc0, 0, 11, 8, 0, 8, 0, 8, 1, 1, 0x11, 0]);
    for class in [0x00, 0x10] {
        bytes.extend([0xff, 0xc4, 0, 20, class, 1]);
        bytes.extend([0; 15]);
        bytes.push(0);
    }
    bytes.extend([0xff, 0xda, 0, 8, 1, 1, 0, 0, 63, 0, 0x3f, 0xff, 0xd9]);
    bytes
}

/// Writes files into a folder, and reads it.
fn read(files: &[(&str, Vec<u8>)]) -> Result<LoadedVolume, String> {
    let dir = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        std::fs::write(dir.path().join(name), bytes).unwrap();
    }
    let listing = list_volume(dir.path(), &VolumeOptions::default());
    let loaded = read_volume(dir.path());
    if let (Ok(listing), Ok(loaded)) = (&listing, &loaded) {
        assert_eq!(listing.dims, loaded.volume.grid().dims());
        assert_eq!(listing.sample_type, loaded.volume.sample_type());
    }
    loaded.map_err(|error| error.to_string().replace(&format!("{}/", dir.path().display()), ""))
}

#[test]
fn images_are_slices_in_the_order_of_their_numbers() {
    let files = [("s10.png", png8(20)), ("s9.png", png8(10)), ("s1.PNG", png8(0))];
    let loaded = read(&files).unwrap();
    let expected = [0, 1, 2, 3, 4, 5, 10, 11, 12, 13, 14, 15, 20, 21, 22, 23, 24, 25];
    assert_eq!(loaded.volume.samples(), &Samples::U8(expected.to_vec()));
    assert_eq!(loaded.volume.grid().dims(), [3, 2, 3]);
    assert_eq!(loaded.format, VolumeFormat::Images);
    assert_eq!(loaded.warnings, ["images do not say how large voxels are: 1 x 1 x 1 was assumed"]);
}

#[test]
fn images_of_every_kind() {
    let wide = |first: u16| {
        let samples: Vec<u8> = (first..first + 6).flat_map(u16::to_ne_bytes).collect();
        png(&samples, ExtendedColorType::L16)
    };
    let loaded = read(&[("a.png", wide(1000)), ("b.png", wide(60_000))]).unwrap();
    let expected: Vec<u16> = (1000..1006).chain(60_000..60_006).collect();
    assert_eq!(loaded.volume.samples(), &Samples::U16(expected));

    let floats = [0.5, -1.0, 2.0, f32::INFINITY, 4.0, 1e-30];
    let loaded = read(&[("a.tif", tiff(&[floats])), ("b.tiff", tiff(&[[7.0; 6]]))]).unwrap();
    let expected: Vec<f32> = floats.into_iter().chain([7.0; 6]).collect();
    assert_eq!(loaded.volume.samples(), &Samples::F32(expected));

    let loaded = read(&[("a.jpg", jpeg()), ("b.jpeg", jpeg())]).unwrap();
    assert_eq!(loaded.volume.sample_type(), SampleType::U8);
    assert_eq!(loaded.volume.summary().range, Some([128.0, 128.0]));
}

#[test]
fn images_that_differ_are_named() {
    let check = |files: &[(&str, Vec<u8>)], expected: &str| {
        let error = read(files).unwrap_err();
        assert!(error.contains(expected) && !error.contains('\n'), "{error} should be {expected}");
    };
    let deep = png(&[0; 12], ExtendedColorType::L16);
    check(
        &[("a1.png", png8(0)), ("a2.png", deep), ("a10.png", png8(0))],
        "a2.png: the image has 3 x 2 pixels of uint16, and the first, a1.png, 3 x 2 of uint8",
    );
    check(&[("a.jpg", jpeg()), ("b.jpg", png8(0))], "b.jpg: the image has 3 x 2 pixels");
    let colors = png(&[0; 18], ExtendedColorType::Rgb8);
    check(
        &[("a.png", png8(0)), ("b.png", colors)],
        "b.png: the image has 3 x 2 pixels of 3 x uint8",
    );
    check(&[("a.png", png8(0)), ("b.png", vec![])], "b.png: not an image, or cut off");
    let half = |bytes: Vec<u8>| bytes[..bytes.len() / 2].to_vec();
    check(&[("a.png", half(png8(0))), ("b.png", png8(0))], "a.png: ");
    check(&[("a.jpg", half(jpeg())), ("b.jpg", jpeg())], "a.jpg: ");
    let two = tiff(&[[0.0; 6]; 2]);
    check(&[("a.tif", two), ("b.tif", tiff(&[[0.0; 6]]))], "a.tif: the file has 2 pages, not one");
    let mut cmyk = std::io::Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut cmyk).unwrap();
    encoder.write_image::<CMYK8>(3, 2, &[0; 24]).unwrap();
    check(&[("a.tif", cmyk.into_inner()), ("b.tif", vec![])], "a.tif: pages of other colours");
    check(
        &[("b.txt", vec![]), ("a.png", png8(0)), ("c.txt", vec![])],
        "holds no volume of many files, but 2 .txt (b.txt, c.txt), 1 .png (a.png): name one of them",
    );
}

#[test]
fn images_beside_other_files() {
    let files = [("a.png", png8(0)), ("b.png", png8(1)), ("c.jpg", jpeg()), (".d.png", vec![])];
    let loaded = read(&files).unwrap();
    assert_eq!(loaded.volume.grid().dims(), [3, 2, 2]);
    let expected = "files that are none of the images were passed over: 1";
    assert_eq!(loaded.warnings[1], expected);
}

/// A size that no such file can hold costs nothing.
#[test]
fn images_that_lie_cost_nothing() {
    let mut lies = png8(0);
    lies[16..24].copy_from_slice(&[0, 0, 0xea, 0x60, 0, 0, 0xea, 0x60]);
    let mut crc = flate2::Crc::new();
    crc.update(&lies[12..29]);
    lies[29..33].copy_from_slice(&crc.sum().to_be_bytes());
    let error = read(&[("a.png", lies), ("b.png", png8(0))]).unwrap_err();
    assert!(error.contains("60000 x 60000"), "{error}");
    let mut lies = jpeg();
    let at = lies.windows(4).position(|window| window == [0, 8, 0, 8]).unwrap();
    lies[at..at + 4].fill(0xff);
    let error = read(&[("a.jpg", lies), ("b.jpg", jpeg())]).unwrap_err();
    assert!(error.contains("65535 x 65535"), "{error}");
}

#[test]
fn images_in_memory() {
    let (a, b) = (png8(0), png8(6));
    let files = [("in/a.png", a.as_slice()), ("in/b.png", b.as_slice())];
    let files = crate::FilesInMemory::from_iter(files);
    let loaded = files.read_volume(Path::new("in")).unwrap();
    assert_eq!(loaded.volume.samples(), &Samples::U8((0..12).collect()));
}
