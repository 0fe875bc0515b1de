//! Files that lie, break off, or are noise: an error or a volume, never a panic, and no memory that
//! the file itself does not pay for.

mod peak;
mod small_files;

use slabsplat_seeds::for_each_seed;
use std::fs;
use std::path::Path;

use peak::check_peak;
use slabsplat_io::{read_mesh, read_scene, read_transfer, read_volume};
use small_files::{
    BINARY_PLY, COLOR_MAP, SCENE, SIDECAR, STL, VOLUME_PROPERTY, arrays, dicom, gzip, metaimage,
    mrc, nifti1, nifti2, nrrd_header, ome_tiff, ply, voxels, zlib,
};

/// Changes tried on each file.
const N_MUTATIONS: usize = 1500;

/// Reads a file, for better or worse.
type Reader = fn(&Path) -> Result<(), slabsplat_io::IoError>;

fn volume(path: &Path) -> Result<(), slabsplat_io::IoError> {
    read_volume(path).map(drop)
}

fn scene(path: &Path) -> Result<(), slabsplat_io::IoError> {
    read_scene(path).map(drop)
}

fn transfer(path: &Path) -> Result<(), slabsplat_io::IoError> {
    read_transfer(path).map(drop)
}

fn mesh(path: &Path) -> Result<(), slabsplat_io::IoError> {
    read_mesh(path).map(drop)
}

/// A valid file of each kind, beside the raw data that some name.
fn valid_files() -> Vec<(&'static str, Vec<u8>, Reader)> {
    let attached =
        |encoding: &str, data: &[u8]| [nrrd_header(encoding).as_bytes(), b"\n", data].concat();
    let text: String = (0..24).map(|n| format!("{} ", n * 100)).collect();
    let hex: String = voxels().iter().map(|byte| format!("{byte:02x}")).collect();
    let detached = nrrd_header("raw") + "data file: a.raw\n";
    let patterned = nrrd_header("raw") + "data file: slice%02d.raw 1 2 1 2\n";
    let listed = nrrd_header("raw") + "byte skip: -1\ndata file: LIST 2\na.raw\na.raw\n";
    vec![
        ("raw.nrrd", attached("raw", &voxels()), volume),
        ("gzip.nrrd", attached("gzip", &gzip(&voxels())), volume),
        ("text.nrrd", attached("text", text.as_bytes()), volume),
        ("detached.nhdr", detached.into_bytes(), volume),
        ("patterned.nhdr", patterned.into_bytes(), volume),
        ("listed.nhdr", listed.into_bytes(), volume),
        ("one.nii", nifti1(), volume),
        ("one.nii.gz", gzip(&nifti1()), volume),
        ("two.nii", nifti2(), volume),
        ("a.mha", metaimage("True", "LOCAL", &zlib(&voxels())), volume),
        ("a.mhd", metaimage("False", "a.raw", b""), volume),
        ("listed.mhd", metaimage("False", "LIST\na.raw\na.raw", b""), volume),
        ("patterned.mhd", metaimage("False", "slice%02d.raw 1 2 1", b""), volume),
        ("a.mrc", mrc(), volume),
        ("a.ome.tif", ome_tiff(), volume),
        ("explicit.dcm", dicom("1.2.840.10008.1.2.1"), volume),
        ("deflated.dcm", dicom("1.2.840.10008.1.2.1.99"), volume),
        ("ls.dcm", include_bytes!("dicom_codecs/ls_lines.dcm").to_vec(), volume),
        ("2000.dcm", include_bytes!("dicom_codecs/2000_rct.dcm").to_vec(), volume),
        ("12.dcm", include_bytes!("dicom_codecs/jpeg_12.dcm").to_vec(), volume),
        ("rgb.nrrd", small_files::rgb_nrrd(), volume),
        ("rgba.nii", small_files::rgba_nifti(), volume),
        ("hex.nrrd", attached("hex", hex.as_bytes()), volume),
        ("a.json", SIDECAR.as_bytes().to_vec(), volume),
        ("a.npy", arrays::npy(&voxels()), volume),
        ("a.npz", arrays::zip(&[("a.npy", &arrays::npy(&voxels()))]), volume),
        ("raw.vti", arrays::vti_raw(&zlib(&voxels())), volume),
        ("text.vti", arrays::vti_text(&text), volume),
        ("binary.vtk", arrays::vtk("BINARY", &voxels()), volume),
        ("text.vtk", arrays::vtk("ASCII", text.as_bytes()), volume),
        ("two.zip", arrays::zarr_2(&gzip(&voxels())), volume),
        ("three.zip", arrays::zarr_3(&voxels()), volume),
        ("scene.toml", SCENE.as_bytes().to_vec(), scene),
        ("map.json", COLOR_MAP.as_bytes().to_vec(), transfer),
        ("property.vp", VOLUME_PROPERTY.as_bytes().to_vec(), transfer),
        ("text.ply", ply("ascii", b"0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"), mesh),
        ("binary.ply", ply("binary_little_endian", &BINARY_PLY), mesh),
        ("text.stl", STL.as_bytes().to_vec(), mesh),
        ("binary.stl", [&[b' '; 80][..], &1_u32.to_le_bytes(), &[1; 50]].concat(), mesh),
        ("a.obj", b"v 0 0 0\nv 1 0 0 1\nv 0 1 0 1 1 1\nvn 0 0 1\nf 1//1 2 -1//1\n".to_vec(), mesh),
    ]
}

fn folder_with_data() -> tempfile::TempDir {
    let dir = tempfile::tempdir().expect("a folder can be made");
    for (name, range) in [("a.raw", 0..48), ("slice01.raw", 0..24), ("slice02.raw", 24..48)] {
        fs::write(dir.path().join(name), &voxels()[range]).expect("the folder can be written");
    }
    dir
}

/// One to four changes of the kinds that transfers, editors and attackers make.
fn mutate(bytes: &mut Vec<u8>, rng: &mut fastrand::Rng) {
    for _ in 0..rng.usize(1..=4) {
        let at = rng.usize(0..=bytes.len());
        let end = (at + rng.usize(0..20)).min(bytes.len());
        match rng.u8(0..8) {
            0 => bytes.truncate(at),
            1 => drop(bytes.drain(at..end)),
            2 => bytes.insert(at, rng.u8(..)),
            3 => bytes[at..end].fill([0, 0xff, b'9', b' ', b'\n'][rng.usize(0..5)]),
            4 => drop(bytes.splice(at..end, bytes[at..end].repeat(2))),
            // Digits and signs make other headers that are valid.
            5 | 6 => {
                let spot = bytes.iter().enumerate().skip(at).find(|(_, b)| b.is_ascii_digit());
                if let Some((spot, _)) = spot {
                    bytes[spot] = b"0123456789-.e,"[rng.usize(0..14)];
                }
            }
            _ => {
                if let Some(byte) = bytes.get_mut(at) {
                    *byte ^= 1 << rng.u8(0..8);
                }
            }
        }
    }
}

#[test]
fn valid_files_are_read() {
    let dir = folder_with_data();
    for (name, bytes, read) in valid_files() {
        let path = dir.path().join(name);
        fs::write(&path, bytes).unwrap();
        read(&path).unwrap_or_else(|e| panic!("{e}"));
    }
}

#[test]
fn mutated_files_never_panic() {
    for_each_seed(1, |mut rng| {
        let dir = folder_with_data();
        for (name, bytes, read) in valid_files() {
            let path = dir.path().join(name);
            let mut n_refused = 0;
            for _ in 0..N_MUTATIONS {
                let mut bytes = bytes.clone();
                mutate(&mut bytes, &mut rng);
                // Some file systems flush a file that is overwritten, but not a new one.
                let _ = fs::remove_file(&path);
                fs::write(&path, &bytes).unwrap();
                if let Err(err) = read(&path) {
                    let message = err.to_string();
                    assert!(!message.contains('\n'), "more than a line: {message}");
                    n_refused += 1;
                }
            }
            assert!(0 < n_refused && n_refused < N_MUTATIONS, "{name}: {n_refused} refused");
            check_peak(name);
        }
    });
}

#[test]
fn headers_that_lie_cost_nothing() {
    let dir = folder_with_data();
    let huge_nrrd = |encoding: &str| nrrd_header(encoding).replace("4 3 2", "60000 60000 1");
    let mut huge_nifti = nifti1();
    huge_nifti[42..46].copy_from_slice(&[0x60, 0x6a, 0x60, 0x6a]);
    let many_files = nrrd_header("raw").replace("4 3 2", "1 1 4000000000")
        + "data file: slice%02d.raw 1 4000000000 1\n";
    for (name, bytes) in [
        ("a.nrrd", [huge_nrrd("raw").as_bytes(), b"\n", &voxels()].concat()),
        ("b.nrrd", [huge_nrrd("gzip").as_bytes(), b"\n", &gzip(&voxels())].concat()),
        ("c.nrrd", [huge_nrrd("text").as_bytes(), b"\n1 2 3"].concat()),
        ("d.nhdr", many_files.into_bytes()),
        ("e.nii", huge_nifti.clone()),
        ("f.nii.gz", gzip(&huge_nifti)),
        ("a.json", SIDECAR.replace("[4, 3, 2]", "[60000, 60000, 1]").into_bytes()),
    ] {
        let path = dir.path().join(name);
        fs::write(&path, bytes).unwrap();
        let message = read_volume(&path).unwrap_err().to_string();
        let is_expected = message.contains("needs ") || message.contains("slice03.raw");
        assert!(is_expected, "{message}");
        check_peak(name);
    }
}

/// 64 MiB of zeros in 64 KiB: what is not asked for is not unpacked into memory.
#[test]
fn gzip_bomb_is_cut_short() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.nii.gz");
    fs::write(&path, gzip(&[nifti1(), vec![0; 64 << 20]].concat())).unwrap();
    let loaded = read_volume(&path).unwrap();
    assert_eq!(loaded.volume.grid().n_voxels(), 24);
    assert_eq!(loaded.warnings.len(), 1, "{:?}", loaded.warnings);
}

#[test]
fn empty_files_and_folders_are_refused() {
    for name in ["a.nrrd", "a.nii", "a.nii.gz", "a.hdr", "a.img", "a.json", "a.raw", "a"] {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join(name);
        fs::write(&path, "").unwrap();
        let message = read_volume(&path).unwrap_err().to_string();
        assert!(message.contains(name) && !message.contains('\n'), "{message}");
    }
    let dir = tempfile::tempdir().unwrap();
    for read in [scene, transfer] {
        let message = read(dir.path()).unwrap_err().to_string();
        assert!(message.starts_with("cannot read "), "{message}");
    }
    fs::write(dir.path().join("a.PNG"), "").unwrap();
    let message = read_volume(dir.path()).unwrap_err().to_string();
    assert!(message.contains("holds no volume of many files, but 1 .png"), "{message}");
}
