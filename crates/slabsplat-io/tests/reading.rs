//! How files are opened, whatever their format: by content before name, with progress that is told, and on
//! several threads as on one.

#[expect(dead_code, reason = "other tests spoil more of them")]
mod small_files;

use std::io::Cursor;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use slabsplat_core::Samples;
use slabsplat_io::{
    FilesInMemory, IoError, ProgressCallback, ReadProgress, VolumeOptions, read_volume_with,
};
use small_files::{arrays, dicom, gzip, metaimage, mrc, nifti1, nifti2, nrrd_header, ome_tiff};
use small_files::{voxels, zlib};
use tiff::encoder::colortype::Gray8;
use tiff::encoder::{Compression, TiffEncoder};

/// A valid file of every format that a single file is enough for.
fn single_files() -> Vec<(&'static str, Vec<u8>)> {
    let text: String = (0..24).map(|n| format!("{} ", n * 100)).collect();
    let nrrd =
        |encoding: &str, data: &[u8]| [nrrd_header(encoding).as_bytes(), b"\n", data].concat();
    vec![
        ("raw NRRD", nrrd("raw", &voxels())),
        ("packed NRRD", nrrd("gzip", &gzip(&voxels()))),
        ("NRRD in text", nrrd("text", text.as_bytes())),
        ("NIfTI-1", nifti1()),
        ("packed NIfTI-1", gzip(&nifti1())),
        ("NIfTI-2", nifti2()),
        ("MetaImage", metaimage("True", "LOCAL", &zlib(&voxels()))),
        ("MRC", mrc()),
        ("OME-TIFF", ome_tiff()),
        ("DICOM", dicom("1.2.840.10008.1.2.1")),
        ("deflated DICOM", dicom("1.2.840.10008.1.2.1.99")),
        ("NumPy", arrays::npy(&voxels())),
        ("NumPy archive", arrays::zip(&[("a.npy", &arrays::npy(&voxels()))])),
        ("VTK's XML", arrays::vti_raw(&zlib(&voxels()))),
        ("legacy VTK", arrays::vtk("BINARY", &voxels())),
        ("Zarr 2", arrays::zarr_2(&gzip(&voxels()))),
        ("Zarr 3", arrays::zarr_3(&voxels())),
    ]
}

/// The extension of another format, of none, and none at all.
#[test]
fn content_decides_before_names() {
    for (what, bytes) in single_files() {
        for name in ["a.tif", "a.nrrd", "a.npz", "a.dcm", "a.nii.gz", "a.vti", "a.xyz", "a"] {
            let files = FilesInMemory::from_iter([(name, bytes.as_slice())]);
            let loaded = files.read_volume(name).unwrap_or_else(|error| panic!("{what}: {error}"));
            // The MRC has its columns along y.
            let mut dims = loaded.volume.grid().dims();
            dims.sort_unstable();
            assert_eq!(dims, [2, 3, 4], "{what} as {name}");
        }
    }
}

/// As some archives send it: the meta information first, and nothing before it.
#[test]
fn dicom_without_its_preamble() {
    let bytes = dicom("1.2.840.10008.1.2.1");
    assert_eq!(&bytes[128..132], b"DICM");
    let read = |bytes: &[u8]| FilesInMemory::from_iter([("a", bytes)]).read_volume("a").unwrap();
    assert_eq!(read(&bytes[132..]).volume.samples(), read(&bytes).volume.samples());
}

/// What is heard while a file is read.
fn heard(name: &str, bytes: &[u8]) -> Vec<ReadProgress> {
    let heard = Arc::new(Mutex::new(Vec::new()));
    let inside = heard.clone();
    let hear = move |progress| inside.lock().expect("nobody panicked").push(progress);
    let options = VolumeOptions::default().on_progress(hear);
    let files = FilesInMemory::from_iter([(name, bytes)]);
    files.read_volume_with(name, &options).unwrap_or_else(|error| panic!("{error}"));
    let heard = heard.lock().expect("nobody panicked");
    heard.clone()
}

#[test]
fn progress_is_told_by_every_reader() {
    for (what, bytes) in single_files() {
        let heard = heard("a", &bytes);
        let shares: Vec<f64> = heard.iter().map(ReadProgress::share).collect();
        assert_eq!((shares.first(), shares.last()), (Some(&0.0), Some(&1.0)), "{what}: {heard:?}");
        assert!(shares.is_sorted(), "{what}: {shares:?}");
        assert!(heard.iter().all(|progress| progress.n_bytes == heard[0].n_bytes), "{what}");
    }
}

/// Whether before anything was read, or once something was.
#[test]
fn reading_is_stopped_in_every_format() {
    for (what, bytes) in single_files() {
        for from in [0, 1] {
            let stop = move |progress: ReadProgress| match from <= progress.n_done {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            };
            let mut options = VolumeOptions::default();
            options.progress = Some(ProgressCallback::stopping(stop));
            let files = FilesInMemory::from_iter([("a", bytes.as_slice())]);
            let result = files.read_volume_with("a", &options);
            assert!(matches!(result, Err(IoError::Cancelled)), "{what}: {result:?}");
        }
    }
}

/// No more is read of a large file than what is being read when it is stopped.
#[test]
fn reading_ends_soon_after_it_is_stopped() {
    let path = std::env::temp_dir().join(format!("slabsplat-stopped-{}.raw", std::process::id()));
    // 256 MiB of nothing, which takes no room.
    let file = std::fs::File::create(&path).unwrap();
    file.set_len(256 << 20).unwrap();
    let header = path.with_extension("nhdr");
    let name = path.file_name().unwrap().to_str().unwrap();
    let text = format!(
        "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 256 1024 1024\nencoding: raw\ndata file: {name}\n"
    );
    std::fs::write(&header, text).unwrap();
    let most = Arc::new(AtomicU64::new(0));
    let of_hearer = most.clone();
    let mut options = VolumeOptions::default();
    options.progress = Some(ProgressCallback::stopping(move |progress| {
        of_hearer.fetch_max(progress.n_done, Ordering::Relaxed);
        if progress.n_done < 32 << 20 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    }));
    let result = read_volume_with(&header, &options);
    let most = most.load(Ordering::Relaxed);
    for path in [&path, &header] {
        std::fs::remove_file(path).unwrap();
    }
    assert!(matches!(result, Err(IoError::Cancelled)), "{result:?}");
    assert!((32 << 20..=40 << 20).contains(&most), "{most} bytes");
}

/// Parts enough for every thread, each with values of its own.
#[test]
fn parts_on_threads_keep_their_places() {
    let mut tiff = Cursor::new(Vec::new());
    let encoder = TiffEncoder::new(&mut tiff).unwrap();
    let mut encoder = encoder.with_compression(Compression::Lzw);
    let mut zarr = vec![(
        "a.zarr/.zarray".to_owned(),
        br#"{"zarr_format": 2, "shape": [200, 2, 3], "chunks": [1, 2, 3], "dtype": "|u1", "order": "C",
            "compressor": {"id": "gzip"}, "fill_value": 9, "filters": null}"#
            .to_vec(),
    )];
    let mut expected = Vec::new();
    for part in 0..200_u8 {
        let samples: Vec<u8> =
            (0..6).map(|pixel| part.wrapping_mul(7).wrapping_add(pixel)).collect();
        encoder.write_image::<Gray8>(3, 2, &samples).unwrap();
        zarr.push((format!("a.zarr/{part}.0.0"), gzip(&samples)));
        expected.extend(samples);
    }
    let tiff = tiff.into_inner();
    let loaded = FilesInMemory::from_iter([("a.tif", &tiff[..])]).read_volume("a.tif").unwrap();
    assert_eq!(loaded.volume.samples(), &Samples::U8(expected.clone()));
    // A chunk that is not there.
    zarr.remove(101);
    expected[600..606].fill(9);
    let files = zarr.iter().map(|(name, bytes)| (name.as_str(), bytes.as_slice()));
    let loaded = FilesInMemory::from_iter(files).read_volume("a.zarr").unwrap();
    assert_eq!(loaded.volume.samples(), &Samples::U8(expected));
    // One that is cut off is named.
    zarr[50].1.truncate(12);
    let files = zarr.iter().map(|(name, bytes)| (name.as_str(), bytes.as_slice()));
    let error = FilesInMemory::from_iter(files).read_volume("a.zarr").unwrap_err().to_string();
    assert!(error.contains("a.zarr/49.0.0"), "{error}");
}
