//! Table 1 of the paper: two rays through a binary face, as arithmetic with eqs. 2 and 3.
//!
//! Printed beside what follows is what the paper prints. Its second ray slips at sheet 5 (model §4).

use slabsplat_core::Compositing;
use slabsplat_tests::reference::{Premultiplied, SheetSums};

/// Eq. 3 with base 2 at a squared distance in voxel steps.
fn weight(r_squared: f64) -> f64 {
    0.446 * (-2.0 * r_squared).exp2()
}

/// A sheet in which white voxels of opacity 1 weigh `weight` together.
fn sheet(weight: f64) -> Premultiplied {
    let mut sums = SheetSums::new(Compositing::Separate);
    sums.add(weight, 1.0, [1.0; 3]);
    sums.finish()
}

#[test]
fn table_1_weights() {
    for (r_squared, printed) in [(0.0, 0.446), (0.5, 0.223), (2.0, 0.0278)] {
        let weight = weight(r_squared);
        assert!((weight - printed).abs() < 1e-4, "{r_squared}: {weight}");
    }
}

#[test]
fn table_1_first_ray() {
    let weight = weight(0.0) + 2.0 * weight(0.5) + 2.0 * weight(2.0);
    let sheet = sheet(weight);
    // Printed: opacity 0.947, premultiplied colour 0.898, true colour 0.948.
    assert!((sheet.opacity - 0.947).abs() < 1e-3, "{sheet:?}");
    assert!((sheet.color[0] - 0.898).abs() < 1e-3, "{sheet:?}");
    assert!((sheet.color[0] / sheet.opacity - 0.948).abs() < 1e-3, "{sheet:?}");
}

#[test]
fn table_1_second_ray() {
    let mut ray = Premultiplied::default();
    // Squared distance; opacity and premultiplied colour by eq. 2, and as printed.
    for (r_squared, [opacity, color], [printed_opacity, printed_color], slips) in [
        (2.0, [0.0279, 0.0008], [0.0278, 0.0007], false),
        (0.5, [0.2447, 0.0491], [0.2446, 0.0483], false),
        (0.0, [0.5816, 0.1994], [0.592, 0.198], true),
        (0.5, [0.6749, 0.2202], [0.683, 0.218], true),
        (2.0, [0.6839, 0.2204], [0.6912, 0.218], true),
    ] {
        ray.lay_over(sheet(weight(r_squared)));
        assert!((ray.opacity - opacity).abs() < 1e-4, "{ray:?}, not {opacity}");
        assert!((ray.color[0] - color).abs() < 1e-4, "{ray:?}, not {color}");
        let is_as_printed = (ray.opacity - printed_opacity).abs() < 2e-4;
        assert_eq!(is_as_printed, !slips, "{ray:?}, printed {printed_opacity}");
        assert!((ray.color[0] - printed_color).abs() < 2.5e-3, "{ray:?}, printed {printed_color}");
    }
}
