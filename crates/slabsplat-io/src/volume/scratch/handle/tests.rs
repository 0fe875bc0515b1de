//! Volumes that one opens and others share, within one process and as bytes that are none.

use crate::volume::write_volume;
use crate::{LayerFile, ScratchDesc, VolumeBoxes, VolumeSource};
use slabsplat_core::glam::{DAffine3, DMat3, DVec3};
use slabsplat_core::{Grid, Scaling, Volume};
use slabsplat_seeds::for_each_seed;
use std::path::PathBuf;

/// A packed volume, and its layer.
fn layer(folder: &tempfile::TempDir, rng: &mut fastrand::Rng) -> LayerFile {
    let dims = [0; 3].map(|_| 1 + rng.usize(..12));
    let steps = DMat3::from_diagonal(DVec3::new(0.1 + rng.f64(), 2.0, 1.0 / 3.0));
    let origin = DVec3::new(rng.f64() * 100.0, -4.0, 5.0);
    let grid = Grid::new(dims, DAffine3::from_mat3_translation(steps, origin)).expect("a grid");
    let samples: Vec<i16> = (0..grid.n_voxels()).map(|_| rng.i16(..)).collect();
    let scaling = Scaling { slope: 0.5 + rng.f64(), intercept: rng.f64() };
    let path = folder.path().join("a.nii.gz");
    let volume = Volume::new(grid, samples.into(), scaling).expect("as many samples as voxels");
    write_volume(&path, &volume).expect("writable folder");
    of_file(path)
}

fn of_file(path: PathBuf) -> LayerFile {
    LayerFile::of_volume(VolumeSource::File(path))
}

fn said_of(boxes: &VolumeBoxes) -> String {
    let first = boxes.first();
    format!(
        "{:?} {:?} {:?} {:?} {:?} {:?}",
        boxes.grid(),
        first.volume.scaling(),
        first.acquisition,
        first.choices,
        first.warnings,
        first.format
    )
}

#[test]
fn shared_scratch_is_read_as_by_who_made_it() {
    for_each_seed(10, |mut rng| {
        let dir = tempfile::tempdir().unwrap();
        let layer = layer(&dir, &mut rng);
        let first = layer.open_boxes(&ScratchDesc::default().folder(dir.path())).unwrap();
        let handle = first.scratch_handle().unwrap().unwrap();
        let second = layer.open_boxes(&ScratchDesc::default().shared(&handle)).unwrap();
        assert_eq!(said_of(&first), said_of(&second));
        assert_eq!(first.scratch().unwrap().n_bytes, second.scratch().unwrap().n_bytes);
        // Who has opened it does not need the other any more.
        let voxels = first.grid().dims().map(|n| rng.usize(..n)..n);
        let expected = first.read(voxels.clone()).unwrap().volume;
        drop(first);
        let found = second.read(voxels).unwrap().volume;
        assert_eq!((expected.grid(), expected.samples()), (found.grid(), found.samples()));
    });
}

/// What is gone, what is another file, and what is no handle.
#[test]
fn shared_scratch_that_is_not_there_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let layer = layer(&dir, &mut fastrand::Rng::with_seed(5));
    let first = layer.open_boxes(&ScratchDesc::default()).unwrap();
    let handle = first.scratch_handle().unwrap().unwrap();
    let error = |handle: &[u8]| {
        layer.open_boxes(&ScratchDesc::default().shared(handle)).unwrap_err().to_string()
    };
    for n in 0..handle.len() {
        assert!(error(&handle[..n]).contains("what another process has unpacked"), "{n}");
    }
    let changed = |key: &str, value: serde_json::Value| {
        let mut json: serde_json::Value = serde_json::from_slice(&handle).unwrap();
        *json.pointer_mut(key).unwrap() = value;
        serde_json::to_vec(&json).unwrap()
    };
    for (key, value) in [
        ("/file/identity/1", 1.into()),
        ("/file/descriptor", (-1).into()),
        ("/samples/0", 99.into()),
        ("/format", 99.into()),
        ("/dims/2", 0.into()),
        ("/dims/2", 1000.into()),
        ("/world_from_index/0", 0.0.into()),
    ] {
        assert!(error(&changed(key, value)).contains("cannot be opened"), "{key}");
    }
    drop(first);
    assert!(error(&handle).contains("cannot be opened"), "it is gone");
    // What need not be unpacked has nothing to be shared.
    let plain = of_file(dir.path().join("b.nii"));
    let grid = Grid::with_spacing([3, 2, 2], [1.0; 3]).unwrap();
    let volume = Volume::new(grid, vec![7_u8; 12].into(), Scaling::IDENTITY).unwrap();
    write_volume(dir.path().join("b.nii"), &volume).unwrap();
    let boxes = plain.open_boxes(&ScratchDesc::default()).unwrap();
    assert_eq!(boxes.scratch_handle().unwrap(), None);
}
