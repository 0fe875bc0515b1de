//! Samples of any type and magnitude are classified by every GPU as by the CPU.

use slabsplat::{Grid, Layer, Method, Samples, Scaling, Scene, TransferFunction, Volume};
use slabsplat_seeds::for_each_seed;
use slabsplat_tests::on_devices::{alone, as_it_is, on_devices, render, scene, with_host_list};
use slabsplat_tests::render::open;
use std::sync::{Arc, Mutex};

/// What two backends may differ by.
const PARITY: f32 = 1e-3;

/// The methods that classify voxels, as exactly as their samples are.
const METHODS_OF_COLORS: [Method; 3] =
    [Method::ImageAligned, Method::AxisAligned, Method::EverySample];

/// 64-bit samples that 32-bit floats could not hold.
#[test]
fn samples_of_any_magnitude() {
    let _alone = alone();
    let grid = Grid::with_spacing([3; 3], [1.0; 3]).expect("the spacing is positive");
    let magnitudes = [1e300, 1e100, 1e40, 1.0, 1e-40, 1e-100, 1e-300, 1e-310];
    let methods = [Method::ImageAligned, Method::PostClassified];
    for (magnitude, method) in magnitudes.into_iter().flat_map(|m| methods.map(|of| (m, of))) {
        let samples: Vec<f64> = (0..27).map(|i| magnitude * f64::from(i) / 26.0).collect();
        let volume = Volume::new(grid, samples.into(), Scaling::IDENTITY);
        let volume = Arc::new(volume.expect("one sample a voxel"));
        let mut scene = scene(&volume, 20, method);
        let opacities = vec![(0.0, [0.0]), (magnitude, [0.7])];
        let colors = vec![(0.0, [1.0, 0.0, 0.0]), (magnitude, [0.0, 1.0, 0.0])];
        scene.layers[0].transfer =
            TransferFunction::new(opacities, colors).expect("the points are sorted");
        let expected = render(&mut *open("cpu"), &scene).expect("it fits").image;
        on_devices(as_it_is, |name, backend, _| {
            let image = render(backend, &scene).expect("it fits").image;
            let difference = image.max_difference(&expected);
            assert!(difference < PARITY, "{name}, {magnitude:e}, {method}: {difference}");
        });
    }
}

/// Samples of every type, with extremes, and transfer functions with steps right at samples' values: the
/// same voxels are relevant, in the same colours.
#[test]
fn every_sample_type_is_classified_alike() {
    let _alone = alone();
    let mut worst = 0.0_f32;
    for_each_seed(1, |mut rng| {
        let mut cases: Vec<_> = (0..48).map(|i| typed_case(&mut rng, i)).collect();
        cases.extend((0..8).map(|i| with_host_list(typed_case(&mut rng, i))));
        worst = worst.max(assert_classified_alike(&cases));
    });
    println!("largest difference from the CPU {worst:.1e}");
}

/// Two numbers that follow each other are far enough apart for a step between them; so are 0 and 1e-300 among
/// hundreds of thousands, and samples whose scaled values all round to the step. They were one to a shader,
/// and pixels off by 0.5.
#[test]
fn steps_are_as_narrow_as_numbers() {
    let _alone = alone();
    let beside = 1e5_f64.next_up();
    let case = |samples: Samples, scaling: Scaling, opacities: Vec<(f64, [f64; 1])>| {
        let grid = Grid::with_spacing([3; 3], [1.0; 3]).expect("the spacing is positive");
        let volume = Volume::new(grid, samples, scaling).expect("one sample a voxel");
        let volume = Arc::new(volume);
        let mut scene = scene(&volume, 24, Method::ImageAligned);
        let colors = vec![(opacities[0].0, [1.0, 0.0, 0.2]), (1e5, [0.1, 1.0, 0.4])];
        scene.layers[0].transfer =
            TransferFunction::new(opacities, colors).expect("the points are sorted");
        scene
    };
    let repeated = |some: &[f64]| some.iter().copied().cycle().take(27).collect::<Vec<f64>>();
    let band = |[a, b]: [f64; 2]| vec![(a, [0.0]), (a, [0.9]), (b, [0.5]), (b, [0.0])];
    let tiny = repeated(&[0.0, 1e-300, -0.0, 3e-301, 1e5, f64::NAN, -1e-300, 2e5]);
    let near = repeated(&[1e5, beside, beside.next_up(), 1e5_f64.next_down(), 0.0]);
    let lost: Vec<f32> = repeated(&[0.0, 1e-40, -1e-40, 1e-14, -1e-14, 1.0, -1.0])
        .iter()
        .map(|&v| v as f32)
        .collect();
    let scaled = Scaling { slope: -0.3, intercept: 1e3 };
    assert_classified_alike(&[
        case(tiny.into(), Scaling::IDENTITY, band([0.0, 1e-300])),
        case(near.into(), Scaling::IDENTITY, band([1e5, beside])),
        case(lost.into(), scaled, vec![(1000.0, [0.0]), (1000.0, [0.9])]),
    ]);
}

/// The largest difference of any device from the CPU; each finds as many relevant voxels.
fn assert_classified_alike(cases: &[Scene]) -> f32 {
    let worst = Mutex::new(0.0_f32);
    on_devices(as_it_is, |name, backend, _| {
        for scene in cases {
            let expected = render(&mut *open("cpu"), scene).expect("it fits");
            let frame = render(backend, scene).expect("it fits");
            let Layer { volume, transfer, .. } = &scene.layers[0];
            let (sample_type, scaling) = (volume.sample_type(), volume.scaling());
            let what = format!("{name}, {sample_type:?}, {scaling:?}, {transfer:?}");
            assert_eq!(frame.stats.n_voxels, expected.stats.n_voxels, "{what}");
            let difference = frame.image.max_difference(&expected.image);
            assert!(difference < PARITY, "{what}: {difference}");
            let mut worst = worst.lock().expect("no test failed");
            *worst = worst.max(difference);
        }
    });
    worst.into_inner().expect("no test failed")
}

fn typed_case(rng: &mut fastrand::Rng, number: usize) -> Scene {
    let grid = Grid::with_spacing([6, 5, 4], [1.0, 1.3, 0.8]).expect("the spacing is positive");
    let n = grid.n_voxels();
    let wide = |rng: &mut fastrand::Rng| {
        let special = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -0.0, 1e-300, -3e250];
        match rng.usize(..30) {
            idx if idx < special.len() => special[idx],
            _ => 1e5 + rng.f64(),
        }
    };
    let samples: Samples = match number % 8 {
        0 => (0..n).map(|_| rng.u8(..)).collect::<Vec<_>>().into(),
        1 => (0..n).map(|_| rng.i8(..)).collect::<Vec<_>>().into(),
        2 => (0..n).map(|_| rng.u16(60_000..)).collect::<Vec<_>>().into(),
        3 => (0..n).map(|_| rng.i16(..-30_000)).collect::<Vec<_>>().into(),
        4 => (0..n).map(|_| rng.u32(u32::MAX - 50..)).collect::<Vec<_>>().into(),
        5 => (0..n).map(|_| rng.i32(i32::MIN..i32::MIN + 50)).collect::<Vec<_>>().into(),
        6 => (0..n).map(|_| wide(rng) as f32).collect::<Vec<_>>().into(),
        _ => (0..n).map(|_| wide(rng)).collect::<Vec<_>>().into(),
    };
    let scaling = [
        Scaling::IDENTITY,
        Scaling { slope: 0.1, intercept: -7.3 },
        Scaling { slope: -0.3, intercept: 1e3 },
    ][number / 8 % 3];
    let volume = Volume::new(grid, samples, scaling).expect("one sample a voxel");
    let values: Vec<f64> = (0..n).map(|i| volume.value(i)).filter(|v| v.abs() < 1e12).collect();
    // Two steps, up and down again, at values that voxels have, and a ramp to a third.
    let mut at = [0; 3].map(|_| values[rng.usize(..values.len())]);
    at.sort_by(f64::total_cmp);
    let mut opacities = vec![(at[0], [0.0]), (at[0], [0.9])];
    if at[0] < at[1] {
        opacities.extend([(at[1], [0.5]), (at[1], [0.0])]);
    }
    if at[1] < at[2] {
        opacities.push((at[2], [0.3]));
    }
    let volume = Arc::new(volume);
    let mut scene = scene(&volume, 30, METHODS_OF_COLORS[number % 3]);
    let colors = vec![(at[0] - 1e-3, [1.0, 0.0, 0.2]), (at[2] + 1e-3, [0.1, 1.0, 0.4])];
    scene.layers[0].transfer =
        TransferFunction::new(opacities, colors).expect("the points are sorted");
    scene
}
