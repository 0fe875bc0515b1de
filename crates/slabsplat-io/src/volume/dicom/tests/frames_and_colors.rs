//! Many frames in one file, values of several slices, and colours.

use slabsplat_core::glam::DVec3;
use slabsplat_core::{ColorSamples, Samples};

use super::super::tags;
use super::written::{
    BIG, DEFLATED, EXPLICIT, IMPLICIT, Items, Short, Words, file, slice, text, with,
};
use super::{read, read_with, samples};
use crate::{FilesInMemory, VolumeOptions};

#[test]
fn dicom_slices_with_scalings_of_their_own_are_floats() {
    let files = [0.0, 1.0].map(|z| {
        let slope = text(&format!("{}", 0.5 + z));
        file(
            EXPLICIT,
            &with(slice(z, [4; 4]), &[(tags::SLOPE, slope), (tags::INTERCEPT, text("1"))]),
        )
    });
    let loaded = read(&files).unwrap();
    let expected = Samples::F32(vec![3.0, 3.0, 3.0, 3.0, 7.0, 7.0, 7.0, 7.0]);
    assert_eq!(loaded.volume.samples(), &expected);
    assert!(loaded.warnings[0].contains("scalings of their own"), "{:?}", loaded.warnings);
}

/// An enhanced image: frames say where they are in groups of their own, here from above to below.
#[test]
fn dicom_frames_of_one_file() {
    let shared = vec![
        (tags::PIXEL_MEASURES, Items(vec![vec![(tags::PIXEL_SPACING, text("1\\2"))]])),
        (
            tags::PLANE_ORIENTATION,
            Items(vec![vec![(tags::IMAGE_ORIENTATION, text("0\\1\\0\\0\\0\\-1"))]]),
        ),
        (tags::PIXEL_TRANSFORMATION, Items(vec![vec![(tags::SLOPE, text("2"))]])),
    ];
    let changes = [
        (tags::N_FRAMES, text("3")),
        (tags::SHARED_GROUPS, Items(vec![shared])),
        (
            tags::PER_FRAME_GROUPS,
            Items(
                [8, 4, 0]
                    .map(|x| {
                        let position = vec![(tags::IMAGE_POSITION, text(&format!("{}\\0\\0", -x)))];
                        vec![(tags::PLANE_POSITION, Items(vec![position]))]
                    })
                    .to_vec(),
            ),
        ),
        (tags::PIXEL_DATA, Words((1..=12).collect())),
    ];
    let mut elements = with(slice(0.0, [0; 4]), &changes);
    elements.retain(|(tag, _)| {
        !matches!(*tag, tags::IMAGE_POSITION | tags::IMAGE_ORIENTATION | tags::PIXEL_SPACING)
            && !matches!(*tag, tags::SLOPE | tags::INTERCEPT)
    });
    for syntax in [EXPLICIT, IMPLICIT, BIG, DEFLATED] {
        let bytes = file(syntax, &elements);
        let files = FilesInMemory::from_iter([("a", bytes.as_slice())]);
        let loaded = files.read_volume("a").unwrap_or_else(|error| panic!("{syntax}: {error}"));
        assert_eq!(loaded.warnings, [""; 0], "{syntax}");
        // The normal is −x, along which the first frame is the highest.
        assert_eq!(samples(&loaded), [9, 10, 11, 12, 5, 6, 7, 8, 1, 2, 3, 4], "{syntax}");
        assert_eq!(loaded.volume.value(0), 18.0);
        let affine = loaded.volume.grid().world_from_index();
        assert_eq!(affine.matrix3.x_axis, DVec3::new(0.0, -2.0, 0.0));
        assert_eq!(affine.matrix3.y_axis, DVec3::new(0.0, 0.0, -1.0));
        assert_eq!(affine.matrix3.z_axis, DVec3::new(4.0, 0.0, 0.0));
    }
}

#[test]
fn dicom_colors_are_channels() {
    for (planar, words) in [
        (0, [0x0201, 0x0403, 0x0605, 0x0807, 0x0a09, 0x0c0b]),
        (1, [0x0401, 0x0a07, 0x0502, 0x0b08, 0x0603, 0x0c09]),
    ] {
        let changes = [
            (tags::SAMPLES_PER_PIXEL, Short(3)),
            (tags::PLANAR, Short(planar)),
            (tags::PHOTOMETRIC, text("RGB")),
            (tags::BITS_ALLOCATED, Short(8)),
            (tags::BITS_STORED, Short(8)),
            (tags::HIGH_BIT, Short(7)),
            (tags::PIXEL_DATA, Words(words.to_vec())),
        ];
        let files = [file(EXPLICIT, &with(slice(0.0, [0; 4]), &changes))];
        let loaded = read_with(&files, &VolumeOptions::default().channel(1)).unwrap();
        assert_eq!(loaded.volume.samples(), &Samples::U8(vec![2, 5, 8, 11]), "{planar}");
        assert_eq!(loaded.choices.channel.names, ["red", "green", "blue"]);
        let all = read(&files).unwrap();
        let colors = ColorSamples::U8(vec![[1, 2, 3], [4, 5, 6], [7, 8, 9], [10, 11, 12]]);
        assert_eq!(all.volume.samples(), &colors.luminances(), "{planar}");
        let voxels = all.colors.unwrap().voxels.unwrap();
        assert_eq!(voxels.samples(), &colors, "{planar}");
    }
}

/// Gray, and red and blue as PS3.3 has them: 76.2, 85.0 and 255.5; 29.1, 255.5 and 107.3.
#[test]
fn dicom_luminance_and_differences_are_colors() {
    for (planar, words) in [
        (0, [0x8080, 0x4c80, 0xff55, 0xff1d, 0x806b, 0x8080]),
        (1, [0x4c80, 0x801d, 0x5580, 0x80ff, 0xff80, 0x806b]),
    ] {
        let changes = [
            (tags::SAMPLES_PER_PIXEL, Short(3)),
            (tags::PLANAR, Short(planar)),
            (tags::PHOTOMETRIC, text("YBR_FULL")),
            (tags::BITS_ALLOCATED, Short(8)),
            (tags::BITS_STORED, Short(8)),
            (tags::HIGH_BIT, Short(7)),
            (tags::PIXEL_DATA, Words(words.to_vec())),
        ];
        let files = [file(EXPLICIT, &with(slice(0.0, [0; 4]), &changes))];
        let of_channel = |channel| {
            let loaded = read_with(&files, &VolumeOptions::default().channel(channel)).unwrap();
            loaded.volume.samples().clone()
        };
        let expected = [[128, 254, 0, 128], [128, 0, 0, 128], [128, 0, 254, 128]];
        for (channel, expected) in expected.into_iter().enumerate() {
            assert_eq!(of_channel(channel), Samples::U8(expected.to_vec()), "{planar}, {channel}");
        }
        let wide = [(tags::BITS_STORED, Short(7)), (tags::HIGH_BIT, Short(6))];
        let error = read(&[file(EXPLICIT, &with(with(slice(0.0, [0; 4]), &changes), &wide))]);
        assert!(error.unwrap_err().contains("YBR_FULL of 7 bits"));
    }
}
