//! Pictures of real volumes as somebody gets them who says nothing: how much of the picture they fill, how
//! bright they are, how much is opaque. Where a volume is not, a line says that it was skipped.
//!
//! The ranges are those of pictures that were looked at; `cargo xtask sheet` makes them large.

use slabsplat::{Image, OpenScene, Renderer, io};

/// A picture's side in pixels.
const SIDE: u32 = 96;

/// What a picture may be like.
struct Expected {
    path: &'static str,
    kind: &'static str,
    /// Mean of red, green and blue of the opaque pixels, of 255.
    brightness: [f64; 2],
    /// Share of pixels that are opaque.
    opaque: [f64; 2],
}

const VOLUMES: &[Expected] = &[
    Expected {
        path: "nifti/mni152_t1_1mm_uint8.nii.gz",
        kind: "MR",
        brightness: [120.0, 190.0],
        opaque: [0.5, 0.8],
    },
    Expected {
        path: "mha/ct_lung_115x157x129_int16.mha",
        kind: "CT in Hounsfield units",
        brightness: [100.0, 200.0],
        opaque: [0.02, 0.4],
    },
    Expected {
        path: "nrrd/headsq_64x64x93_int16.nrrd",
        kind: "CT in Hounsfield units",
        brightness: [110.0, 200.0],
        opaque: [0.2, 0.7],
    },
    Expected {
        path: "nrrd/tooth/tooth.nhdr",
        kind: "a scan",
        brightness: [120.0, 200.0],
        opaque: [0.25, 0.6],
    },
    Expected {
        path: "mha/nucleon.mha",
        kind: "a smooth field",
        brightness: [70.0, 180.0],
        opaque: [0.1, 0.6],
    },
    Expected {
        path: "mha/fuel.mha",
        kind: "a smooth field",
        brightness: [70.0, 190.0],
        opaque: [0.01, 0.4],
    },
    Expected {
        path: "tiff/neuron_409x415x119_uint8.tif",
        kind: "microscopy",
        brightness: [70.0, 200.0],
        opaque: [0.005, 0.2],
    },
];

#[test]
fn pictures_without_flags_fill_and_are_bright() {
    let mut renderer = Renderer::open("cpu", |_| ()).unwrap();
    for expected in VOLUMES {
        let Some(path) = slabsplat_testdata::volume(expected.path) else { continue };
        let mut file = io::SceneFile::of_volume(io::VolumeSource::File(path));
        (file.image.width, file.image.height) = (SIDE, SIDE);
        let mut opened = OpenScene::open(&file).unwrap();
        let name = expected.path;
        assert_eq!(opened.scene.image.background[3], 1.0, "{name}: the background is opaque");
        assert!(opened.found[0].starts_with(expected.kind), "{name}: {}", opened.found[0]);
        // Without it, pixels tell by their opacity what they show.
        opened.scene.image.background = [0.0; 4];
        let image = renderer.render(&opened.scene).unwrap().image;
        let (filled, brightness, opaque) = (filled(&image), brightness(&image), opaque(&image));
        let text =
            format!("{name}: {filled:.3} filled, {brightness:.0} bright, {opaque:.3} opaque");
        println!("{text}");
        assert!((0.9..=0.98).contains(&filled), "{text}");
        let is_in = |[least, most]: [f64; 2], value: f64| least <= value && value <= most;
        assert!(is_in(expected.brightness, brightness) && is_in(expected.opaque, opaque), "{text}");
    }
}

/// The part of the shorter side, here either, that what is seen takes.
fn filled(image: &Image) -> f64 {
    let (width, height) = (image.width(), image.height());
    let is_seen = |x: u32, y: u32| 0.08 < image.pixel(x, y)[3];
    let columns = (0..width).filter(|&x| (0..height).any(|y| is_seen(x, y)));
    let rows = (0..height).filter(|&y| (0..width).any(|x| is_seen(x, y)));
    let span = |columns: &mut dyn Iterator<Item = u32>| {
        let columns: Vec<u32> = columns.collect();
        columns.last().map_or(0, |last| last + 1 - columns[0])
    };
    f64::from(span(&mut { columns }).max(span(&mut { rows }))) / f64::from(width)
}

fn opaque_pixels(image: &Image) -> impl Iterator<Item = &[f32; 4]> {
    image.pixels().iter().filter(|pixel| 0.9 < pixel[3])
}

fn brightness(image: &Image) -> f64 {
    let sums = opaque_pixels(image).map(|[r, g, b, _]| f64::from(r + g + b));
    255.0 * sums.sum::<f64>() / (3.0 * opaque_pixels(image).count() as f64)
}

fn opaque(image: &Image) -> f64 {
    opaque_pixels(image).count() as f64 / image.pixels().len() as f64
}
