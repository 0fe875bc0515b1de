//! First inputs of what holds arrays: NumPy, VTK, Zarr.

use crate::Seeds;
use crate::joined;
use crate::small_files::arrays::{npy as small_npy, vti_raw, vti_text, vtk as small_vtk, zip};
use crate::small_files::{gzip, voxels, zlib};
use crate::text;

pub(crate) fn npy() -> Seeds {
    let npy = small_npy(&voxels());
    let of = |descr: &str, shape: &str, n_bytes: usize| {
        let text = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}\n");
        let length = (text.len() as u16).to_le_bytes();
        [b"\x93NUMPY\x01\x00", &length[..], text.as_bytes(), &vec![1; n_bytes]].concat()
    };
    vec![
        npy.clone(),
        zip(&[("a.npy", &npy), ("b.npy", &of("|b1", "(2, 2, 2)", 8))]),
        of(">f2", "(2, 3, 4)", 48),
        of("<i8", "(2, 1, 2, 3)", 96),
    ]
}

pub(crate) fn vtk() -> Seeds {
    let lz4 = lz4_flex::block::compress(&voxels());
    let words = [1, 48, 0, lz4.len() as u32].map(u32::to_le_bytes).concat();
    let fields = "# vtk DataFile Version 5.1\na\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 3 2 2\nSPACING 1 1 1\n\
        ORIGIN 0 0 0\nCELL_DATA 2\nFIELD f 2\na 1 2 int\n1 2\nb 3 2 float\n1 2 3 4 5 6\nMETADATA\n\n";
    let base64 = "<VTKFile type=\"ImageData\" byte_order=\"BigEndian\" header_type=\"UInt64\"><ImageData \
        WholeExtent=\"0 3 0 0 0 0\" Origin=\"0 0 0\" Spacing=\"1 1 1\"><Piece Extent=\"0 3 0 0 0 0\"><PointData>\
        <DataArray type=\"UInt8\" Name=\"b\" format=\"binary\">AAAAAAAAAAQBAgME</DataArray></PointData></Piece>\
        </ImageData></VTKFile>\n";
    let by_lz4 = String::from_utf8_lossy(&vti_raw(b"")).replace("ZLib", "LZ4");
    let (before, after) = by_lz4.split_once('_').expect("the data begin by it");
    let after = &after[after.find("\n</Appended").expect("the data end")..];
    vec![
        vti_raw(&zlib(&voxels())),
        [before.as_bytes(), b"_", &words, &lz4, after.as_bytes()].concat(),
        vti_text(&text()),
        base64.into(),
        small_vtk("BINARY", &voxels()),
        small_vtk("ASCII", text().as_bytes()),
        fields.into(),
    ]
}

const IMAGE: &str = r#""multiscales": [{"axes": [{"name": "z", "type": "space"}, {"name": "y", "type": "space"},
    {"name": "x", "type": "space", "unit": "micrometer"}], "datasets": [{"path": "0",
    "coordinateTransformations": [{"type": "scale", "scale": [2, 1, 1]}]}]}]"#;

/// Two chunks of 2 × 3 × 2 voxels by each codec.
pub(crate) fn zarr() -> Seeds {
    let chunk = &voxels()[..24];
    let zstd =
        ruzstd::encoding::compress_to_vec(chunk, ruzstd::encoding::CompressionLevel::Fastest);
    let mut seeds = Seeds::new();
    for (id, packed) in
        [("gzip", gzip(chunk)), ("zlib", zlib(chunk)), ("zstd", zstd.clone()), ("blosc", blosc(1))]
    {
        let array = format!(
            r#"{{"zarr_format": 2, "shape": [2, 3, 4], "chunks": [2, 3, 2], "dtype": "<i2", "order": "F",
            "compressor": {{"id": "{id}"}}, "fill_value": 7, "filters": null}}"#
        );
        let image = format!("2{{{IMAGE}}}");
        seeds.push(joined(&[image.as_bytes(), array.as_bytes(), &packed, &packed]));
    }
    let index = [0_u64, 12, 12, 12].map(u64::to_le_bytes).concat();
    let shard = r#"{"name": "sharding_indexed", "configuration": {"chunk_shape": [1, 3, 2],
        "codecs": [{"name": "bytes"}], "index_codecs": [{"name": "bytes"}]}}"#;
    let transposed =
        r#"{"name": "transpose", "configuration": {"order": [2, 1, 0]}}, {"name": "bytes"}"#;
    for (codecs, packed) in [
        (shard.to_owned(), [chunk, &index].concat()),
        (format!(r#"{transposed}, {{"name": "zstd"}}"#), zstd),
        (format!(r#"{transposed}, {{"name": "blosc"}}"#), blosc(4)),
    ] {
        let array = format!(
            r#"{{"zarr_format": 3, "node_type": "array", "shape": [2, 3, 4], "data_type": "int16",
            "chunk_grid": {{"name": "regular", "configuration": {{"chunk_shape": [2, 3, 2]}}}},
            "chunk_key_encoding": {{"name": "default"}}, "fill_value": 0, "codecs": [{codecs}]}}"#
        );
        let group = format!(
            r#"3{{"zarr_format": 3, "node_type": "group", "attributes": {{"ome": {{{IMAGE}}}}}}}"#
        );
        seeds.push(joined(&[group.as_bytes(), array.as_bytes(), &packed, &packed]));
    }
    seeds
}

/// A buffer of Blosc with one block: by LZ4 (1) or Zstandard (4), without shuffling.
fn blosc(codec: u8) -> Vec<u8> {
    let chunk = &voxels()[..24];
    let packed = match codec {
        1 => lz4_flex::block::compress(chunk),
        _ => ruzstd::encoding::compress_to_vec(chunk, ruzstd::encoding::CompressionLevel::Fastest),
    };
    let n_packed = packed.len() as u32;
    let header = [2, 1, codec << 5 | 16, 2];
    let words = [24, 24, 24 + n_packed, 20, n_packed].map(u32::to_le_bytes).concat();
    [&header, &words[..], &packed].concat()
}
