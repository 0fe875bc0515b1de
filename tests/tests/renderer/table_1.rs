//! Table 1 of the paper: two rays through a binary face, by `slabsplat::paper::table_1`, against what is
//! printed, eqs. 2 and 3 by the reference, and the kernel that is drawn with.

use slabsplat::kernel::{Gaussian, Kernel};
use slabsplat::paper::table_1::{PRINTED_RAY_1, PRINTED_RAY_2, RayRow, footprint, ray_1, ray_2};
use slabsplat_core::Compositing;
use slabsplat_tests::reference::{Premultiplied, SheetSums};

/// A sheet in which white voxels of opacity 1 weigh `weight` together.
fn sheet(weight: f64) -> Premultiplied {
    let mut sums = SheetSums::new(Compositing::Separate);
    sums.add(weight, 1.0, [1.0; 3]);
    sums.finish()
}

#[test]
fn table_1_weights() {
    for (r_squared, printed) in [(0.0, 0.446), (0.5, 0.223), (2.0, 0.0278)] {
        let weight = footprint(r_squared);
        assert!((weight - printed).abs() < 1e-4, "{r_squared}: {weight}");
    }
}

#[test]
fn table_1_first_ray() {
    let row = ray_1(footprint);
    for (ours, printed) in [
        (row.weight, PRINTED_RAY_1.weight),
        (row.opacity, PRINTED_RAY_1.opacity),
        (row.color, PRINTED_RAY_1.color),
        (row.true_color, PRINTED_RAY_1.true_color),
    ] {
        assert!((ours - printed).abs() < 1e-3, "{row:?}, printed {PRINTED_RAY_1:?}");
    }
    let by_reference = sheet(row.weight);
    assert!((row.opacity - by_reference.opacity).abs() < 1e-12, "{row:?}");
    assert!((row.color - by_reference.color[0]).abs() < 1e-12, "{row:?}");
}

#[test]
fn table_1_second_ray() {
    let mut by_reference = Premultiplied::default();
    // Opacity and premultiplied colour by eq. 2; from sheet 5 on the paper slips (model §4).
    let expected = [
        ([0.0279, 0.0008], false),
        ([0.2447, 0.0491], false),
        ([0.5816, 0.1994], true),
        ([0.6749, 0.2202], true),
        ([0.6839, 0.2204], true),
    ];
    for ((row, printed), ([opacity, color], slips)) in
        ray_2(footprint).into_iter().zip(PRINTED_RAY_2).zip(expected)
    {
        by_reference.lay_over(sheet(row.weight));
        assert!((row.opacity - by_reference.opacity).abs() < 1e-12, "{row:?}");
        assert!((row.color - by_reference.color[0]).abs() < 1e-12, "{row:?}");
        assert!((row.opacity - opacity).abs() < 1e-4, "{row:?}, not {opacity}");
        assert!((row.color - color).abs() < 1e-4, "{row:?}, not {color}");
        assert_eq!(row.sheet, printed.sheet);
        assert!((row.weight - printed.weight).abs() < 1e-4, "{row:?}, printed {printed:?}");
        let is_as_printed = (row.opacity - printed.opacity).abs() < 2e-4;
        assert_eq!(is_as_printed, !slips, "{row:?}, printed {printed:?}");
        assert!((row.color - printed.color).abs() < 2.5e-3, "{row:?}, printed {printed:?}");
    }
}

/// The kernel that pictures are drawn with ends at a radius of 2: what it lacks of the weights dims the rays,
/// and no colour, a square, by more than twice as much.
#[test]
fn table_1_by_the_kernel_that_is_drawn_with() {
    let drawn = |r_squared: f64| Gaussian.footprint(r_squared.sqrt());
    let lost = ray_1(footprint).weight - ray_1(drawn).weight;
    assert!(0.0 < lost && lost < 0.0025, "{lost}");
    let check = |drawn: RayRow, ideal: RayRow| {
        let [opacity, color] = [ideal.opacity - drawn.opacity, ideal.color - drawn.color];
        assert!(0.0 < opacity && opacity <= lost, "{drawn:?}");
        assert!(0.0 < color && color <= 2.0 * lost, "{drawn:?}");
    };
    check(ray_1(drawn), ray_1(footprint));
    check(ray_2(drawn)[4], ray_2(footprint)[4]);
}
