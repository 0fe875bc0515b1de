//! Writes the inputs that fuzzing begins with: `cargo run --example seeds FOLDER` fills `FOLDER/TARGET`. They
//! are small valid files of every way of packing, made here, but for those that tests have of other programs.

mod arrays;
mod drawn;
mod images;

// What the tests of slabsplat-io spoil is spoilt here as well.
#[path = "../../../../crates/slabsplat-io/tests/small_files/mod.rs"]
mod small_files;

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use anyhow::Context;
use slabsplat_core::Image;
use slabsplat_fuzz::BETWEEN;
use slabsplat_io::{PictureFormat, Provenance};
use small_files::{BINARY_PLY, COLOR_MAP, SCENE, SIDECAR, STL, VOLUME_PROPERTY};
use small_files::{arrays as small_arrays, gzip, metaimage, nifti1, nifti2, nrrd_header, ply};
use small_files::{voxels, zlib};

/// Inputs of one target.
type Seeds = Vec<Vec<u8>>;

fn main() -> anyhow::Result<()> {
    let folder = std::env::args_os().nth(1).context("name the folder that gets the inputs")?;
    for (target, seeds) in all()? {
        let folder = PathBuf::from(&folder).join(target);
        fs::create_dir_all(&folder)?;
        for (idx, seed) in seeds.iter().enumerate() {
            fs::write(folder.join(format!("seed-{idx:02}")), seed)?;
        }
    }
    Ok(())
}

fn all() -> anyhow::Result<[(&'static str, Seeds); 19]> {
    Ok([
        ("nrrd", nrrd()),
        ("nifti", nifti()),
        ("metaimage", meta_image()),
        ("dicom", [images::dicom(), of_tests("dicom_codecs", "dcm")?].concat()),
        ("tiff", images::tiff()),
        ("images", images::folders()),
        ("mrc", vec![small_files::mrc(), gzip(&small_files::mrc())]),
        ("npy", arrays::npy()),
        ("hdf5", of_tests("hdf5", "gz")?.iter().map(|bytes| unpacked(bytes)).collect()),
        ("vtk", arrays::vtk()),
        ("zarr", arrays::zarr()),
        ("zip", zip()),
        ("raw", raw()),
        ("scene", vec![SCENE.into(), include_bytes!("../../../../docs/example.toml").to_vec()]),
        ("mesh", mesh()),
        ("transfer", vec![named(0, COLOR_MAP), named(1, VOLUME_PROPERTY)]),
        ("picture", pictures()),
        ("annotations", drawn::annotations()),
        ("film", drawn::films()?),
    ])
}

/// The files in a folder of slabsplat-io's tests that end so.
fn of_tests(folder: &str, extension: &str) -> anyhow::Result<Seeds> {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../crates/slabsplat-io/tests");
    let mut paths = Vec::new();
    for entry in fs::read_dir(tests.join(folder))? {
        paths.push(entry?.path());
    }
    paths.retain(|path| path.extension().is_some_and(|end| end == extension));
    paths.sort_unstable();
    Ok(paths.iter().map(fs::read).collect::<Result<_, _>>()?)
}

fn unpacked(gzip: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    flate2::read::GzDecoder::new(gzip).read_to_end(&mut bytes).expect("the tests read it, too");
    bytes
}

/// A text, after the number of its name.
fn named(name_idx: u8, text: &str) -> Vec<u8> {
    [&[name_idx], text.as_bytes()].concat()
}

/// Pictures that say what they show.
fn pictures() -> Seeds {
    let mut provenance = Provenance::default();
    (provenance.program, provenance.scene) = (Some("a program".into()), Some(SCENE.into()));
    // JPEG has no transparency.
    let picture = Image::filled(2, 1, [0.5, 0.4, 0.3, 1.0]);
    let bytes = PictureFormat::ALL.iter().map(|it| it.bytes(&picture, Some(&provenance)));
    bytes.map(|bytes| bytes.expect("it has pixels")).collect()
}

/// Files of an input.
fn joined(files: &[&[u8]]) -> Vec<u8> {
    files.join(BETWEEN)
}

/// The voxels as numbers.
fn text() -> String {
    (0..24).map(|n| format!("{} ", n * 100)).collect()
}

fn nrrd() -> Seeds {
    let attached =
        |encoding: &str, data: &[u8]| [nrrd_header(encoding).as_bytes(), b"\n", data].concat();
    let detached = |lines: &str, files: &[&[u8]]| {
        let header = nrrd_header("raw") + lines;
        joined(&[&[header.as_bytes()], files].concat())
    };
    let hex: String = voxels().iter().map(|byte| format!("{byte:02x}")).collect();
    let halves = [&voxels()[..24], b"", &voxels()[..24], &voxels()[24..]];
    let times = nrrd_header("raw")
        .replace("dimension: 3", "dimension: 4")
        .replace("4 3 2", "2 2 3 2")
        .replace("directions:", "directions: none")
        .replace("kinds:", "kinds: vector");
    vec![
        attached("raw", &voxels()),
        attached("gzip", &gzip(&voxels())),
        attached("text", text().as_bytes()),
        attached("hex", hex.as_bytes()),
        [times.as_bytes(), b"\n", &voxels()].concat(),
        small_files::rgb_nrrd(),
        detached("data file: a.raw\n", &[&voxels()]),
        detached("data file: slice%02d.raw 1 2 1 2\n", &halves[1..]),
        detached("byte skip: -1\ndata file: LIST 2\na.raw\na.raw\n", &halves[..1]),
    ]
}

fn nifti() -> Seeds {
    let mut pair = nifti1();
    pair.truncate(348);
    pair[344..348].copy_from_slice(b"ni1\0");
    let mut analyze = pair.clone();
    analyze[344..348].fill(0);
    let mut series = nifti1();
    series[40..50].copy_from_slice(&[4, 0, 4, 0, 3, 0, 1, 0, 2, 0]);
    vec![
        nifti1(),
        gzip(&nifti1()),
        nifti2(),
        small_files::rgba_nifti(),
        series,
        joined(&[&pair, &voxels()]),
        joined(&[&gzip(&analyze), &gzip(&voxels())]),
    ]
}

fn meta_image() -> Seeds {
    let pattern = metaimage("False", "slice%02d.raw 1 2 1", b"");
    let text = metaimage("False", "LOCAL", text().as_bytes());
    let text = String::from_utf8_lossy(&text).replace("BinaryData = True", "BinaryData = False");
    vec![
        metaimage("True", "LOCAL", &zlib(&voxels())),
        metaimage("False", "LOCAL", &voxels()),
        text.into_bytes(),
        joined(&[&metaimage("False", "a.raw", b""), &voxels()]),
        joined(&[&metaimage("False", "LIST\na.raw\na.raw", b""), &voxels()[..24]]),
        joined(&[&pattern, b"", &voxels()[..24], &voxels()[24..]]),
    ]
}

fn zip() -> Seeds {
    let npy = small_arrays::npy(&voxels());
    vec![
        small_arrays::zip(&[("a.npy", &npy), ("b.npy", &npy)]),
        small_arrays::zarr_2(&gzip(&voxels())),
        small_arrays::zarr_3(&voxels()),
    ]
}

fn raw() -> Seeds {
    let affine = r#"{"file": "a.raw", "dims": [4, 3, 2], "type": "uint16", "endian": "big", "order": "xyz",
        "affine": [[1, 0, 0, 5], [0, 0, 2, 6], [0, 1, 0, 7]], "slope": 2.5, "intercept": -1}"#;
    vec![
        joined(&[SIDECAR.as_bytes(), &voxels()]),
        joined(&[affine.as_bytes(), &voxels()]),
        joined(&[b"a_4x3x2_int16_le.raw", &voxels()]),
        joined(&[b"b-4x3x4-u8.vol", &voxels()]),
    ]
}

fn mesh() -> Seeds {
    let named = |first: u8, bytes: &[u8]| [&[first], bytes].concat();
    let obj = b"v 0 0 0\nv 1 0 0 1\nv 0 1 0 1 1 1\nvn 0 0 1\nf 1//1 2 -1//1\n";
    vec![
        named(0, &ply("ascii", b"0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")),
        named(0, &ply("binary_little_endian", &BINARY_PLY)),
        named(0, &ply("binary_big_endian", &BINARY_PLY)),
        named(1, STL.as_bytes()),
        named(1, &[&[b' '; 80][..], &1_u32.to_le_bytes(), &[1; 50]].concat()),
        named(2, obj),
    ]
}
