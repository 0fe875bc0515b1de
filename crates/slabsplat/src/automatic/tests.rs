//! What is found of small volumes whose values are known.

use super::*;
use slabsplat_core::{Grid, Modality, Orientation, Samples, Scaling, View};

fn row(samples: Vec<f32>) -> Volume {
    let grid = Grid::with_spacing([samples.len(), 1, 1], [1.0, 2.0, 3.0]).unwrap();
    Volume::new(grid, Samples::F32(samples), Scaling::IDENTITY).unwrap()
}

/// Numbers from −1 to 1 that look random and are the same every time.
fn noise(voxel: [usize; 3]) -> f64 {
    let mixed = voxel.iter().fold(0x9e37_79b9_u32, |hash, &c| {
        let mixed = (hash ^ c as u32).wrapping_mul(0x85eb_ca6b);
        (mixed ^ mixed >> 13).wrapping_mul(0xc2b2_ae35) ^ mixed >> 16
    });
    f64::from(mixed) / f64::from(u32::MAX) * 2.0 - 1.0
}

/// Distance from the middle of a grid of so many voxels a side, in halves of it.
fn radius(voxel: [usize; 3], side: usize) -> f64 {
    let half = 0.5 * side as f64;
    voxel.iter().map(|&c| ((c as f64 + 0.5) / half - 1.0).powi(2)).sum::<f64>().sqrt()
}

fn cube(side: usize, sample: impl Fn([usize; 3]) -> f64) -> Volume {
    let grid = Grid::centered([side, side, side + 2], [1.5; 3]).unwrap();
    Volume::from_fn(grid, |voxel| sample(voxel) as f32)
}

#[test]
fn automatic_transfer_parts_object_from_background() {
    let mut samples: Vec<f32> = (0..800).map(|i| (i * 7 % 10) as f32).collect();
    samples.extend((0..200).map(|i| 100.0 + (i * 7 % 20) as f32));
    samples.extend([f32::NAN, f32::INFINITY]);
    let transfer = Automatic::new(row(samples)).transfer().clone();
    assert_eq!(transfer.opacity(9.0), 0.0, "background");
    assert!(0.3 < transfer.opacity(110.0), "object");
    assert!(0.8 < transfer.opacity(119.0), "{transfer:?}");
}

#[test]
fn automatic_transfer_shows_what_has_no_contrast() {
    for samples in [vec![3.0; 4], vec![f32::NAN; 2], vec![f32::INFINITY; 2], vec![0.0, 1e-45]] {
        let volume = Arc::new(row(samples.clone()));
        let automatic = Automatic::new(volume.clone());
        let last = volume.value(samples.len() - 1);
        assert!(0.0 < automatic.transfer().opacity(last), "{samples:?}");
        assert!(!automatic.description().is_empty());
    }
}

#[test]
fn automatic_transfer_finds_a_single_voxel() {
    let mut samples = vec![0.0; 40_000];
    samples[77] = 255.0;
    let transfer = Automatic::new(row(samples)).transfer().clone();
    assert!(transfer.opacity(0.0) == 0.0 && 0.5 < transfer.opacity(255.0), "{transfer:?}");
}

#[test]
fn automatic_transfer_of_neighbouring_numbers() {
    let grid = Grid::with_spacing([2, 1, 1], [1.0; 3]).unwrap();
    let samples = vec![1.0_f64.next_up(), 1.0_f64.next_up().next_up()];
    let volume = Volume::new(grid, samples.into(), Scaling::IDENTITY).unwrap();
    assert!(0.0 < Automatic::new(volume).transfer().opacity(1.0));
}

/// A stray value is no reason to draw all others in one colour.
#[test]
fn automatic_transfer_passes_over_outliers() {
    let stray = |voxel: [usize; 3]| match voxel {
        [3, 4, 5] => 1e30,
        [9, 4, 5] => -1e20,
        _ => 50.0 * f64::from(radius(voxel, 32) < 0.7) + 3.0 * noise(voxel),
    };
    let transfer = Automatic::new(cube(32, stray)).transfer().clone();
    let positions: Vec<f64> = transfer.positions().collect();
    assert!(positions.iter().all(|at| (-10.0..70.0).contains(at)), "{positions:?}");
    assert!(transfer.opacity(4.0) == 0.0 && 0.4 < transfer.opacity(50.0), "{transfer:?}");
}

/// Nearly all that is seen of a ball in noise is the ball, though noise is as strong as half its contrast.
#[test]
fn automatic_transfer_is_no_box_of_noise() {
    let side = 40;
    let of_ball = |voxel: [usize; 3]| radius(voxel, side) < 0.6;
    let sum = |[x, y, z]: [usize; 3]| (1..6).map(|k| noise([x + 100 * k, y, z])).sum::<f64>();
    let volume = cube(side, |voxel| 100.0 + 100.0 * f64::from(of_ball(voxel)) + 25.0 * sum(voxel));
    let automatic = Automatic::new(volume.clone());
    let mean_opacity = |is_ball: bool| {
        let grid = volume.grid();
        let (mut sum, mut n) = (0.0, 0);
        for voxel_idx in 0..grid.n_voxels() {
            if of_ball(grid.voxel_coords(voxel_idx)) == is_ball {
                sum += automatic.transfer().opacity(volume.value(voxel_idx));
                n += 1;
            }
        }
        sum / f64::from(n)
    };
    let (air, ball) = (mean_opacity(false), mean_opacity(true));
    assert!(air < 0.004 && 0.3 < ball, "air {air}, ball {ball}: {}", automatic.description());
}

#[test]
fn automatic_kind_by_values() {
    let check = |volume: Volume, acquisition: Acquisition, expected: DataKind| {
        let automatic = Automatic::with_acquisition(volume, acquisition);
        assert_eq!(automatic.kind(), expected, "{}", automatic.description());
    };
    let side = 32;
    let standing = |orientation| Acquisition::default().orientation(orientation);
    let unknown = Acquisition::default();
    let within = |voxel, limit: f64| f64::from(radius(voxel, side) < limit);
    let labels =
        |voxel| within(voxel, 0.8) + 16.0 * within(voxel, 0.6) + 900.0 * within(voxel, 0.4);
    check(cube(side, labels), unknown, DataKind::Labels);
    check(cube(side, |voxel| within(voxel, 0.5)), unknown, DataKind::Labels);
    let body =
        |voxel| 1040.0 * within(voxel, 0.8) + 400.0 * within(voxel, 0.3) + 30.0 * noise(voxel);
    check(cube(side, |voxel| body(voxel) - 1000.0), unknown, DataKind::Hounsfield { water: 0.0 });
    check(cube(side, |voxel| body(voxel) + 24.0), unknown, DataKind::Hounsfield { water: 1024.0 });
    let mr = Acquisition::default().modality(Modality::Mr);
    let mr = mr.orientation(Orientation::Anatomical).metric();
    check(cube(side, |voxel| body(voxel) - 1000.0), mr, DataKind::Mr);
    let smooth = |voxel| (-3.0 * radius(voxel, side).powi(2)).exp();
    check(cube(side, smooth), unknown, DataKind::Field);
    check(cube(side, smooth), standing(Orientation::Anatomical), DataKind::Mr);
    let noisy = |voxel| 50.0 * within(voxel, 0.6) + 8.0 * noise(voxel);
    check(cube(side, noisy), unknown, DataKind::Scan);
    check(cube(side, noisy), standing(Orientation::Pictures), DataKind::Scan);
    let pictures = Volume::from_fn(Grid::centered([32, 32, 34], [1.0; 3]).unwrap(), |voxel| {
        noisy(voxel) as f32
    });
    check(pictures, standing(Orientation::Pictures), DataKind::Microscopy);
    check(cube(side, |_| 7.0), unknown, DataKind::Flat);
}

#[test]
fn automatic_labels_have_colors_of_their_own() {
    let grid = Grid::centered([40, 8, 8], [1.0; 3]).unwrap();
    let volume = Volume::from_fn(grid, |[x, ..]| [0_u16, 3, 4, 700][x / 10]);
    let automatic = Automatic::new(volume);
    let transfer = automatic.transfer();
    assert_eq!((transfer.opacity(0.0), transfer.opacity(1.0)), (0.0, 0.0));
    let colors = [3.0, 4.0, 700.0].map(|label| transfer.color(label));
    for (idx, color) in colors.iter().enumerate() {
        for other in &colors[..idx] {
            let apart: f64 = color.iter().zip(other).map(|(a, b)| (a - b).abs()).sum();
            assert!(0.3 < apart, "{color:?} and {other:?}");
        }
    }
    assert!(0.8 < transfer.opacity(4.0) && 0.8 < transfer.opacity(700.0));
    assert!(automatic.description().contains("3 of them"), "{}", automatic.description());
}

/// Bone is opaque, and soft tissue lets it be seen.
#[test]
fn automatic_hounsfield_shows_bone() {
    let side = 32;
    let bone = |voxel| 60.0 * f64::from(radius(voxel, side) < 0.85) + 40.0 * noise(voxel);
    let volume = cube(side, |voxel| match radius(voxel, side) {
        r if r < 0.4 => 900.0 + bone(voxel),
        r if r < 0.85 => bone(voxel),
        _ => -1000.0,
    });
    let automatic = Automatic::new(volume);
    let transfer = automatic.transfer();
    assert!(0.6 < transfer.opacity(700.0) && transfer.opacity(40.0) < 0.1, "{transfer:?}");
    assert_eq!(transfer.opacity(-900.0), 0.0);
    assert!(automatic.layer().gradient_opacity.is_some());
    let sharp = RenderSettings::default().method(slabsplat_core::Method::PostClassified);
    let scene = automatic.scene(ImageDesc::default(), sharp);
    assert_eq!(scene.layers[0].gradient_opacity, None, "which post-classified has not");
}

/// Whatever the number of threads.
#[test]
fn automatic_is_the_same_every_time() {
    let volume = Arc::new(cube(48, |voxel| 40.0 * (1.0 - radius(voxel, 48)) + noise(voxel)));
    let with_threads = |n| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        pool.install(|| {
            Automatic::new(volume.clone()).scene(ImageDesc::default(), RenderSettings::default())
        })
    };
    assert_eq!(with_threads(1), with_threads(5));
}

/// All corners of the grid lie inside the picture, and close to an edge of it.
#[test]
fn automatic_camera_fits_the_volume() {
    let grid = Grid::with_spacing([20, 15, 6], [1.0, 1.2, 3.0]).unwrap();
    let volume = Volume::new(grid, vec![1_u8; grid.n_voxels()].into(), Scaling::IDENTITY).unwrap();
    let automatic = Automatic::new(volume);
    for (width, height) in [(100, 100), (200, 50), (50, 200)] {
        let image = ImageDesc::new(width, height);
        for is_perspective in [false, true] {
            let camera = automatic.camera(&image, is_perspective);
            let view = View::new(&grid, &camera, &image).unwrap();
            let from_index = view.from_index(&grid);
            let mut farthest: f64 = 0.0;
            for corner in grid.corners_in_world() {
                let at = from_index.transform(grid.index_from_world().transform_point3(corner));
                let scale = view.pixels_per_world(at.z);
                let x = (at.x * scale).abs() / (0.5 * f64::from(width));
                let y = (at.y * scale).abs() / (0.5 * f64::from(height));
                farthest = farthest.max(x).max(y);
            }
            assert!(
                (0.8..0.95).contains(&farthest),
                "{width}x{height} {is_perspective}: {farthest}"
            );
        }
    }
}

/// Which way a head stands is not a matter of what is shown of it.
#[cfg(feature = "files")]
#[test]
fn head_stands_on_its_neck_with_any_transfer_function() {
    use slabsplat_io::{LoadedVolume, parse_scene};

    let side = 24;
    // A skull that becomes narrower towards the last slice, cut at both ends.
    let head = cube(side, |[x, y, z]| {
        let across = radius([x, y, side / 2], side);
        let rim = 0.9 - 0.5 * z as f64 / side as f64;
        let bone = if rim - 0.15 < across { 900.0 } else { 40.0 };
        1024.0 + if across < rim { bone } else { -1000.0 } + 20.0 * noise([x, y, z])
    });
    let up = |keys: &str| {
        let scene = format!("volume = {{ path = \"a.nrrd\" }}\n[classify]\n{keys}");
        let file = parse_scene(&scene, "a.toml").unwrap();
        let loaded = vec![LoadedVolume::computed(head.clone())];
        let opened = crate::OpenScene::with_volumes(loaded, &file).unwrap();
        opened.scene.camera.up()
    };
    for keys in ["", "preset = \"ct-bone\"", "opacity = [[1100, 0.0], [1300, 0.5]]"] {
        assert!(up(keys).z < -0.5, "{keys}: {}", up(keys));
    }
}
