//! What a scene file leaves open is found box by box as it is in memory: the scenes are one text.

use super::*;
use slabsplat::io::{SceneFile, VolumeSource};

/// Real volumes of each kind and format, and what is said of how they look.
const VOLUMES: &[(&str, &str)] = &[
    ("nifti/mni152_t1_1mm_uint8.nii.gz", ""),
    ("nifti/engine_256x256x128_uint8.nii.gz", "preset = \"mr-t1\""),
    ("nrrd/embryo_256_uint8.nrrd", "preset = \"gray\""),
    ("nrrd/headsq/quarter.nhdr", ""),
    ("dicom/ct_phantom_head", "percentile = [20, 99.5]"),
    ("tiff/neuron_409x415x119_uint8.tif", ""),
    ("raw/ct_thorax_256x256x133_uint8.raw", ""),
    ("mha/ct_lung_115x157x129_int16.mha", "preset = \"ct-bone\""),
];

/// The scene in memory and in boxes, as scene files that leave nothing open.
fn texts(file: &SceneFile) -> [String; 2] {
    let mut file = file.clone();
    "cpu".clone_into(&mut file.backend);
    let mut whole = OpenScene::open(&file).unwrap().to_file().unwrap();
    for layer in &mut whole.layers {
        layer.hash = None;
        layer.labels.iter_mut().for_each(|labels| labels.hash = None);
    }
    let divided = DividedScene::open(&file, 1 << 30).unwrap().to_file().unwrap();
    [whole, divided].map(|file| io::scene_text(&file, "scene.toml").unwrap())
}

pub(super) fn check(name: &str, file: &SceneFile) {
    let [whole, divided] = texts(file);
    assert!(whole == divided, "{name}:\n{whole}\n{divided}");
}

/// A scene that says no more of a volume than that.
fn parsed(path: &Path, look: &str, rest: &str) -> SceneFile {
    let text =
        format!("[volume]\npath = {:?}\n[classify]\n{look}\n{rest}", path.display().to_string());
    io::parse_scene(&text, path.with_file_name("scene.toml")).unwrap()
}

#[test]
fn out_of_core_finds_the_scenes_of_real_volumes() {
    let _alone = alone();
    for (name, look) in VOLUMES {
        let Some(path) = slabsplat_testdata::volume(name) else { continue };
        check(name, &parsed(&path, look, ""));
    }
}

/// More voxels than are looked at, in each format that boxes are read of in another way.
#[test]
fn out_of_core_finds_the_scenes_of_built_in_volumes() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    for (name, size, suffix) in [
        ("neuron", 176, "zarr"),
        ("marschner-lobb", 150, "npy"),
        ("shepp-logan", 170, "nrrd"),
        ("sphere", 180, "nii"),
        ("cube", 60, "nii"),
    ] {
        let path = folder.path().join(format!("{name}.{suffix}"));
        io::write_volume(&path, &io::builtin_volume(name, Some(size)).unwrap()).unwrap();
        check(name, &SceneFile::of_volume(VolumeSource::File(path.clone())));
        let look = ["colormap = \"turbo\"", "percentile = [1, 99]", "unit_distance = 3.0"];
        let look = look[size % 3];
        let rest = "[region]\nbox = [[3, 4, 5], [40, 50, 60]]\nindex = true\n[annotations]\naxes = true\n\
                    color_bar = true\n[camera]\nprojection = \"perspective\"\n";
        check(name, &parsed(&path, look, rest));
    }
}
