//! First inputs of what has pages or slices: DICOM and TIFF.

use std::io::Cursor;

use image::codecs::jpeg::JpegEncoder;
use slabsplat_fuzz::BETWEEN;
use tiff::encoder::colortype::{Gray8, Gray16};
use tiff::encoder::{Compression, DeflateLevel, TiffEncoder};
use tiff::tags::Tag;

use crate::Seeds;
use crate::small_files::{dicom as small_dicom, ome_tiff, zlib as small_zlib};

/// The pixels of the small file: an element with its header.
const N_PIXEL_BYTES: usize = 12 + 48;

/// A lossless JPEG that gdcm 3 wrote of 4 × 3 numbers.
const LOSSLESS: &str = "ffd8ffc3000b100003000401011100ffc40019000003000300000000000000000000000001070c0a0b10ffda0008\
    010100010000e72391c97ffc00ac8cece001277e6fffd900";

pub(crate) fn dicom() -> Seeds {
    let explicit = small_dicom("1.2.840.10008.1.2.1");
    let folder = [slice("1", "0\\0\\0"), slice("2", "0\\0\\2"), slice("3", "0\\0\\4")];
    vec![
        folder.join(BETWEEN),
        explicit,
        small_dicom("1.2.840.10008.1.2.1.99"),
        packed("1.2.840.10008.1.2.5", &[&run_lengths(), &run_lengths()]),
        packed("1.2.840.10008.1.2.4.70", &[&lossless(), &lossless()]),
        of_8_bits(packed("1.2.840.10008.1.2.4.50", &[&jpeg(), &jpeg()])),
    ]
}

/// One slice of a folder: the small file with a position and a number of its own, and half of its pixels.
fn slice(number: &str, position: &str) -> Vec<u8> {
    let mut bytes = small_dicom("1.2.840.10008.1.2.1");
    bytes.truncate(bytes.len() - N_PIXEL_BYTES);
    let frames = [0x28, 0, 8, 0, b'L', b'O', 2, 0, b'2', b' '];
    let at = find(&bytes, &frames);
    bytes[at + 8] = b'1';
    for (tag, value) in [([0x20, 0x13], number), ([0x20, 0x32], position)] {
        bytes.extend(tag.map(u16::to_le_bytes).concat());
        bytes.extend(b"LO");
        bytes.extend((value.len() as u16).next_multiple_of(2).to_le_bytes());
        bytes.extend(value.as_bytes());
        bytes.extend(if value.len() % 2 == 1 { &b" "[..] } else { &[] });
    }
    bytes.extend(b"\xe0\x7f\x10\x00OW\0\0\x18\0\0\0");
    bytes.extend([7; 24]);
    bytes
}

/// The small file with its frames in fragments.
fn packed(syntax: &str, frames: &[&[u8]]) -> Vec<u8> {
    let mut bytes = small_dicom(syntax);
    bytes.truncate(bytes.len() - N_PIXEL_BYTES);
    bytes.extend(b"\xe0\x7f\x10\x00OB\0\0\xff\xff\xff\xff");
    for fragment in [&[&b""[..]], frames].concat() {
        bytes.extend(b"\xfe\xff\x00\xe0");
        bytes.extend((fragment.len() as u32).next_multiple_of(2).to_le_bytes());
        bytes.extend(fragment);
        bytes.extend(if fragment.len() % 2 == 1 { &[0][..] } else { &[] });
    }
    bytes.extend(b"\xfe\xff\xdd\xe0\0\0\0\0");
    bytes
}

/// 12 pixels of 16 bits, all the same.
fn run_lengths() -> Vec<u8> {
    let mut packed = [2_u32, 64, 66].iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<_>>();
    packed.resize(64, 0);
    packed.extend([245, 3, 245, 9]);
    packed
}

fn lossless() -> Vec<u8> {
    let byte = |at| u8::from_str_radix(&LOSSLESS[at..at + 2], 16).expect("two digits");
    (0..LOSSLESS.len()).step_by(2).map(byte).collect()
}

fn jpeg() -> Vec<u8> {
    let mut bytes = Vec::new();
    let pixels: Vec<u8> = (0..12).map(|n| 20 * n).collect();
    let encoded = JpegEncoder::new(&mut bytes).encode(&pixels, 4, 3, image::ExtendedColorType::L8);
    encoded.expect("memory can be written");
    bytes
}

/// The same with bytes for pixels.
fn of_8_bits(mut bytes: Vec<u8>) -> Vec<u8> {
    for (element, value) in [(0_u8, 8_u8), (1, 8), (2, 7)] {
        let at = find(&bytes, &[0x28, 0, element, 1, b'U', b'S', 2, 0]);
        bytes[at + 8] = value;
    }
    bytes
}

fn find(bytes: &[u8], part: &[u8]) -> usize {
    bytes.windows(part.len()).position(|window| window == part).expect("the element is there")
}

/// Folders of images of each kind, and of two.
pub(crate) fn folders() -> Seeds {
    let gray = |depth: u8| png(depth, 0, &[0x5a; 12]);
    vec![
        [gray(8), gray(8), gray(8)].join(BETWEEN),
        [gray(16), gray(16)].join(BETWEEN),
        [png(8, 2, &[7; 36]), png(8, 2, &[7; 36])].join(BETWEEN),
        [jpeg(), jpeg()].join(BETWEEN),
        [tiff().swap_remove(0), gray(8)].join(BETWEEN),
    ]
}

/// A PNG of two columns and as many rows as `samples` fill, by the colour type of its header (PNG §11.2.2).
fn png(depth: u8, color: u8, samples: &[u8]) -> Vec<u8> {
    let n_values = if color == 2 { 3 } else { 1 };
    let row_bytes = 2 * n_values * usize::from(depth / 8);
    let rows: Vec<u8> =
        samples.chunks(row_bytes).flat_map(|row| [&[0][..], row].concat()).collect();
    let n_rows = (samples.len() / row_bytes) as u32;
    let header =
        [&2_u32.to_be_bytes()[..], &n_rows.to_be_bytes(), &[depth, color, 0, 0, 0]].concat();
    let mut bytes = b"\x89PNG\r\n\x1a\n".to_vec();
    for (name, data) in [(b"IHDR", header), (b"IDAT", small_zlib(&rows)), (b"IEND", Vec::new())] {
        let mut sum = flate2::Crc::new();
        sum.update(name);
        sum.update(&data);
        bytes.extend((data.len() as u32).to_be_bytes());
        bytes.extend(name);
        bytes.extend(&data);
        bytes.extend(sum.sum().to_be_bytes());
    }
    bytes
}

pub(crate) fn tiff() -> Seeds {
    let description =
        "ImageJ=1.53\nimages=2\nchannels=2\nslices=1\nhyperstack=true\nspacing=2\nunit=um\n";
    let mut seeds = vec![ome_tiff()];
    for compression in
        [Compression::Uncompressed, Compression::Deflate(DeflateLevel::Fast), Compression::Packbits]
    {
        let mut bytes = Cursor::new(Vec::new());
        let encoder = TiffEncoder::new(&mut bytes).expect("memory can be written");
        let mut encoder = encoder.with_compression(compression);
        let mut image = encoder.new_image::<Gray16>(4, 3).expect("memory can be written");
        let described = image.encoder().write_tag(Tag::ImageDescription, description);
        described.expect("memory can be written");
        image.write_data(&[500; 12]).expect("memory can be written");
        encoder.write_image::<Gray16>(4, 3, &[7; 12]).expect("memory can be written");
        seeds.push(bytes.into_inner());
    }
    let mut bytes = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new_big(&mut bytes).expect("memory can be written");
    encoder.write_image::<Gray8>(4, 3, &[7; 12]).expect("memory can be written");
    seeds.push(bytes.into_inner());
    seeds
}
