//! Where slices lie, by their positions alone.

use slabsplat_core::glam::DVec3;

use super::super::tags;
use super::written::{EXPLICIT, file, slice, text, with};
use super::{ct, read, samples};
use crate::VolumeFormat;

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

/// A tilted gantry: every slice is 2 mm further along y than the one below.
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
