//! Small valid files of every format, to be spoilt.

pub(crate) mod arrays;

use std::io::{Cursor, Write};

use tiff::encoder::colortype::Gray16;
use tiff::encoder::{Compression, TiffEncoder};
use tiff::tags::Tag;

/// Packs bytes as gzip does.
pub(crate) fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(bytes).expect("memory can be written");
    encoder.finish().expect("memory can be written")
}

/// Packs bytes as zlib does.
pub(crate) fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(bytes).expect("memory can be written");
    encoder.finish().expect("memory can be written")
}

/// A MetaImage of 4 × 3 × 2 voxels of 16 bits, with what comes after its header.
pub(crate) fn metaimage(is_packed: &str, data_file: &str, data: &[u8]) -> Vec<u8> {
    let header = format!(
        "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n\
         CompressedData = {is_packed}\nCompressedDataSize = 9\nTransformMatrix = 1 0 0 0 1 0 0 0 1\n\
         Offset = 1 2 3\nElementSpacing = 1 1.5 2\nDimSize = 4 3 2\nHeaderSize = 0\n\
         ElementType = MET_SHORT\nElementDataFile = {data_file}\n"
    );
    [header.as_bytes(), data].concat()
}

/// A TIFF of 4 × 3 × 2 voxels of 16 bits, packed, with OME-XML.
pub(crate) fn ome_tiff() -> Vec<u8> {
    let description = "<OME><Image><Pixels DimensionOrder=\"XYZCT\" SizeX=\"4\" SizeY=\"3\" SizeZ=\"2\" \
                       SizeC=\"1\" SizeT=\"1\" PhysicalSizeX=\"1\" PhysicalSizeY=\"1\" PhysicalSizeZ=\"2\">\
                       <TiffData IFD=\"0\" PlaneCount=\"2\"/></Pixels></Image></OME>";
    let mut bytes = Cursor::new(Vec::new());
    let encoder = TiffEncoder::new(&mut bytes).expect("memory can be written");
    let mut encoder = encoder.with_compression(Compression::Lzw);
    for page in [0_u16, 12] {
        let mut image = encoder.new_image::<Gray16>(4, 3).expect("memory can be written");
        let described = image.encoder().write_tag(Tag::ImageDescription, description);
        described.expect("memory can be written");
        let samples: Vec<u16> = (page..page + 12).map(|n| 100 * n).collect();
        image.write_data(&samples).expect("memory can be written");
    }
    bytes.into_inner()
}

/// An NRRD header of 4 × 3 × 2 voxels of 16 bits, without its last empty line.
pub(crate) fn nrrd_header(encoding: &str) -> String {
    format!(
        "NRRD0005\n# small\ntype: short\ndimension: 3\nspace: left-posterior-superior\n\
         sizes: 4 3 2\nspace directions: (1,0,0) (0,1.5,0) (0,0.5,2)\n\
         kinds: domain domain domain\nendian: little\nencoding: {encoding}\n\
         space origin: (-1,2,3)\nkey:=value\n"
    )
}

/// The 48 bytes of 24 voxels of 16 bits.
pub(crate) fn voxels() -> Vec<u8> {
    (0..24_i16).flat_map(|n| (n * 100).to_le_bytes()).collect()
}

/// NIfTI-1, little endian, 4 × 3 × 2 voxels of 16 bits, with a slope and a qform.
pub(crate) fn nifti1() -> Vec<u8> {
    let mut bytes = vec![0; 352];
    let mut put = |offset: usize, field: &[u8]| {
        bytes[offset..offset + field.len()].copy_from_slice(field);
    };
    put(0, &348_i32.to_le_bytes());
    for (idx, size) in [3_i16, 4, 3, 2, 1, 1, 1, 1].into_iter().enumerate() {
        put(40 + 2 * idx, &size.to_le_bytes());
        put(76 + 4 * idx, &1.0_f32.to_le_bytes());
    }
    put(70, &4_i16.to_le_bytes());
    put(108, &352.0_f32.to_le_bytes());
    put(112, &0.5_f32.to_le_bytes());
    put(252, &1_i16.to_le_bytes());
    put(344, b"n+1\0");
    [bytes, voxels()].concat()
}

/// An NRRD of 4 × 2 × 2 voxels that are colours of 8 bits.
pub(crate) fn rgb_nrrd() -> Vec<u8> {
    let header = nrrd_header("raw")
        .replace("type: short\ndimension: 3", "type: uchar\ndimension: 4")
        .replace("sizes: 4 3 2", "sizes: 3 4 2 2")
        .replace("directions: ", "directions: none ")
        .replace("kinds: ", "kinds: RGB-color ");
    [header.as_bytes(), b"\n", &voxels()].concat()
}

/// NIfTI-1 of 2 × 3 × 2 voxels that are colours with alpha.
pub(crate) fn rgba_nifti() -> Vec<u8> {
    let mut bytes = nifti1();
    bytes[42..44].copy_from_slice(&2_i16.to_le_bytes());
    bytes[70..72].copy_from_slice(&2304_i16.to_le_bytes());
    bytes
}

/// An MRC file, big endian, with an extended header, columns along y and a skewed cell.
pub(crate) fn mrc() -> Vec<u8> {
    let mut bytes = vec![0; 1024 + 12];
    let mut put = |offset: usize, word: [u8; 4]| bytes[offset..offset + 4].copy_from_slice(&word);
    for (idx, number) in [4, 3, 2, 1, 0, 0, 0, 4, 3, 2].into_iter().enumerate() {
        put(4 * idx, i32::to_be_bytes(number));
    }
    for (idx, number) in [4.0, 3.0, 5.0, 90.0, 95.0, 90.0].into_iter().enumerate() {
        put(40 + 4 * idx, f32::to_be_bytes(number));
    }
    for (idx, axis) in [2, 1, 3].into_iter().enumerate() {
        put(64 + 4 * idx, i32::to_be_bytes(axis));
    }
    put(92, 12_i32.to_be_bytes());
    put(208, *b"MAP ");
    put(212, [0x11, 0x11, 0, 0]);
    [bytes, voxels()].concat()
}

/// NIfTI-2, big endian, otherwise the same but for the voxels' byte order.
pub(crate) fn nifti2() -> Vec<u8> {
    let mut bytes = vec![0; 544];
    let mut put = |offset: usize, field: &[u8]| {
        bytes[offset..offset + field.len()].copy_from_slice(field);
    };
    put(0, &540_i32.to_be_bytes());
    put(4, b"n+2\0\r\n\x1a\n");
    put(12, &4_i16.to_be_bytes());
    for (idx, size) in [3_i64, 4, 3, 2, 1, 1, 1, 1].into_iter().enumerate() {
        put(16 + 8 * idx, &size.to_be_bytes());
        put(104 + 8 * idx, &1.0_f64.to_be_bytes());
    }
    put(168, &544_i64.to_be_bytes());
    [bytes, voxels()].concat()
}

/// A scene with most keys.
pub(crate) const SCENE: &str = r#"
[volume]
generate = "cube"
size = 12
spacing = [1.0, 1.0, 1.5]
[classify]
opacity = [[0.0, 0.0], [80.0, 0.0], [255.0, 0.9]]
color = [[0.0, 0.0, 0.0, 0.0], [255.0, 1.0, 0.9, 0.8]]
[shading]
model = "phong"
shininess = 20.0
[[lights]]
from = [0.0, 1.0, 1.0]
[camera]
projection = "perspective"
eye = [0.0, 0.0, 400.0]
fov_y = 30.0
[image]
width = 64
background = [0.0, 0.0, 0.0, 0.0]
[render]
method = "image-aligned"
slab_width = 1.0
sections = 128
"#;

/// A volume property of 3D Slicer.
pub(crate) const VOLUME_PROPERTY: &str =
    "1\n1\n0.9\n0.1\n0.3\n12\n6 -9 0 5 0 9 0.8\n4 0 0.5 100 1\n8 -9 0 0 0 9 1 0.9 0.8\n";

/// A ParaView colour map.
pub(crate) const COLOR_MAP: &str = r#"[{"Name": "x", "Points": [0, 0, 0.5, 0, 255, 1, 0.5, 0],
    "RGBPoints": [0, 0, 0, 0, 128, 1, 0.5, 0, 255, 1, 1, 1]}]"#;

/// The description of a raw file of 4 × 3 × 2 voxels.
pub(crate) const SIDECAR: &str = r#"{"file": "a.raw", "dims": [4, 3, 2], "type": "int16",
    "endian": "little", "header_bytes": 0, "spacing": [1, 1, 2.5], "origin": [0, 0, -3]}"#;

/// A triangle, but for its data.
pub(crate) fn ply(format: &str, data: &[u8]) -> Vec<u8> {
    let header = format!(
        "ply\nformat {format} 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
         property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    );
    [header.as_bytes(), data].concat()
}

/// The data of a triangle: nine coordinates, the count and the numbers of its corners.
pub(crate) const BINARY_PLY: [u8; 49] = {
    let mut data = [0; 49];
    (data[14], data[15], data[30], data[31]) = (0x80, 0x3f, 0x80, 0x3f);
    (data[36], data[41], data[45]) = (3, 1, 2);
    data
};

pub(crate) const STL: &str = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n\
    vertex 0 1 0\nendloop\nendfacet\nendsolid a\n";

/// A DICOM file of 4 × 3 pixels in two frames, in an explicit little-endian transfer syntax.
pub(crate) fn dicom(syntax: &str) -> Vec<u8> {
    let element = |tag: [u16; 2], representation: &str, value: &[u8]| {
        let mut bytes = tag.map(u16::to_le_bytes).concat();
        bytes.extend(representation.as_bytes());
        if matches!(representation, "OW" | "SQ") {
            bytes.extend([0, 0]);
            bytes.extend((value.len() as u32).to_le_bytes());
        } else {
            bytes.extend((value.len() as u16).to_le_bytes());
        }
        [&bytes, value].concat()
    };
    let text = |tag, value: &str| {
        let mut bytes = value.as_bytes().to_vec();
        bytes.resize(bytes.len().next_multiple_of(2), b' ');
        element(tag, "LO", &bytes)
    };
    let short = |tag, value: u16| element(tag, "US", &value.to_le_bytes());
    let item = |value: &[u8]| {
        let length = (value.len() as u32).to_le_bytes();
        [&[0xfe, 0xff, 0x00, 0xe0][..], &length, value].concat()
    };
    let group = |z: &str| {
        let position = element([0x20, 0x9113], "SQ", &item(&text([0x20, 0x32], z)));
        item(&position)
    };
    let elements = [
        text([0x08, 0x60], "CT"),
        text([0x20, 0x0e], "1.2.3"),
        text([0x20, 0x37], "1\\0\\0\\0\\1\\0"),
        short([0x28, 0x02], 1),
        text([0x28, 0x04], "MONOCHROME2"),
        text([0x28, 0x08], "2"),
        short([0x28, 0x10], 3),
        short([0x28, 0x11], 4),
        text([0x28, 0x30], "1\\1.5"),
        short([0x28, 0x100], 16),
        short([0x28, 0x101], 12),
        short([0x28, 0x102], 11),
        text([0x28, 0x1053], "2"),
        element([0x5200, 0x9230], "SQ", &[group("0\\0\\0"), group("0\\0\\3")].concat()),
        element([0x7fe0, 0x10], "OW", &voxels()),
    ]
    .concat();
    let body = if syntax.ends_with(".99") {
        let level = flate2::Compression::fast();
        let mut encoder = flate2::write::DeflateEncoder::new(Vec::new(), level);
        encoder.write_all(&elements).expect("memory can be written");
        encoder.finish().expect("memory can be written")
    } else {
        elements
    };
    [&[0; 128][..], b"DICM", &text([0x02, 0x10], syntax), &body].concat()
}
