//! Polynomials against the rows that they are fitted to.

use super::*;
use crate::{KERNEL_NAMES, SectionDesc, TableDesc, kernel_named};
use slabsplat_core::{Lookup, Normalization};

/// Largest and mean difference from the exact integral over the whole disc of radius `R`, at rows and
/// half way between them.
fn errors(name: &str, width: f64, normalization: Normalization, degree: Degree) -> (f64, f64) {
    let kernel = kernel_named(name).unwrap();
    let desc = SectionDesc { kernel: &*kernel, width, kappa: 1.0, normalization, base_width: 0.5 };
    let table = TableDesc { sections: 128, radial_samples: 256, lookup: Lookup::Linear };
    let table = SectionTable::new(&desc, table);
    let polynomials = RadialPolynomials::of_sections(&table, degree);
    let radius = kernel.radius();
    let (mut worst, mut sum, mut n) = (0.0_f64, 0.0, 0.0);
    for step in 1..2 * table.n_rows() - 2 {
        let depth = 0.5 * step as f64 / f64::from(table.rows().rows_per_index);
        let front = depth - radius - width;
        let near = (-(front + width)).max(front).max(0.0);
        for i in 0..200 {
            let part = (f64::from(i) + 0.4) / 200.0;
            let rho = radius * part.sqrt();
            let exact = desc.weight(rho, front);
            let x = (2.0 * part - 1.0) as f32;
            let faces = [front, front + width].map(|f| (f * chord_units_per_index(radius)) as f32);
            let [a, b] = [step / 2, step.div_ceil(2)].map(|row| polynomials.weight(row, x, faces));
            let fitted = 0.5 * (a + b);
            let inside = rho * rho < radius * radius - near * near;
            let error = if inside { (f64::from(fitted) - exact).abs() } else { 0.0 };
            (worst, sum, n) = (worst.max(error), sum + error, n + 1.0);
        }
    }
    (worst, sum / n)
}

#[test]
fn polynomials_are_the_sections() {
    for &name in KERNEL_NAMES {
        for width in [0.25, 0.5, 1.0, 2.0, 4.0] {
            for degree in [Degree::High, Degree::Low] {
                let (worst, mean) = errors(name, width, Normalization::None, degree);
                println!("{name} w={width} {degree:?}: {worst:.1e} (mean {mean:.1e})");
                let most = match (degree, name) {
                    (Degree::High, _) => [2e-4, 1.5e-5],
                    (Degree::Low, "gaussian") => [3e-4, 3e-5],
                    (Degree::Low, _) => [1e-3, 2e-4],
                };
                assert!(worst < most[0] && mean < most[1], "{name} w={width} {degree:?}");
            }
        }
        let (worst, mean) = errors(name, 2.0, Normalization::Product, Degree::High);
        println!("{name} product: {worst:.1e} (mean {mean:.1e})");
        assert!(worst < 2e-4 && mean < 1.5e-5, "{name} product");
    }
}

/// Over all extinctions that a voxel may have; between a faint and an opaque one it is a bound.
#[test]
fn errors_of_pixels_are_the_most_that_shows() {
    for (weight, slack) in [(0.0, 1.01), (0.02, 1.4), (0.3, 1.01), (1.0, 1.01)] {
        for off in [1e-4, -1e-4] {
            let shows = |step: i32| {
                let mu = extinction(1.0) * f64::from(step) / 1000.0;
                ((-mu * weight).exp() - (-mu * (weight + off)).exp()).abs()
            };
            let most = (0..=1000).map(shows).fold(0.0, f64::max);
            let Errors { of_weight, of_pixel } = Errors::of(off, weight);
            let ratio = of_pixel / most;
            assert!((0.99..slack).contains(&ratio), "{off} of {weight}: {ratio}");
            assert_eq!(of_weight, 1e-4);
        }
    }
}

#[test]
fn polynomials_of_neighboring_rows() {
    let kernel = kernel_named("gaussian").unwrap();
    let (kernel, normalization) = (&*kernel, Normalization::None);
    let desc = SectionDesc { kernel, width: 4.0, kappa: 1.0, normalization, base_width: 0.5 };
    let table = TableDesc { sections: 8, radial_samples: 64, lookup: Lookup::Linear };
    let table = SectionTable::new(&desc, table);
    let fit = RadialPolynomials::of_sections(&table, Degree::High);
    let last = table.n_rows() - 1;
    for row_idx in 0..last {
        assert_eq!(fit.around(row_idx), [fit.row(row_idx), fit.row(row_idx + 1)]);
        assert_ne!(fit.row(row_idx), fit.row(row_idx + 1));
    }
    assert_eq!(fit.around(last), [fit.last_row(); 2]);
    let footprint = FootprintTable::new(kernel, 1.0, 64);
    let whole = RadialPolynomials::of_footprint(&footprint, Degree::High);
    for (a, b) in fit.last_row().iter().zip(whole.row(0)) {
        assert!((a - b).abs() < 1e-6, "{a} {b}");
    }
}

#[test]
fn disc_ends_before_the_zeros() {
    // Eleven samples from the edge to the middle, and the last once more.
    let row =
        |n_zeros: usize| (0..12).map(|i| if i < n_zeros { 0.0 } else { 1.0 }).collect::<Vec<f32>>();
    for (n_zeros, expected) in [(0, 1.0), (1, 1.0), (4, 1.0 - 0.09), (10, 1.0 - 0.81), (12, 0.0)] {
        assert!((disc_of(&row(n_zeros)) - expected).abs() < 1e-12, "{n_zeros}");
    }
    assert_eq!(domain(&[0.2, 0.3, 0.8, 1.0], 0), 0.5, "at least a half");
    assert_eq!(domain(&[0.2, 0.3, 0.8, 1.0], 1), 0.8, "and as far as a neighbour");
}

/// An opaque voxel has an extinction of 13.8. Where it ends, nothing hides what its weight is off:
/// without the chord that was up to 5e-4 of a pixel, for every voxel of an edge.
#[test]
fn polynomials_keep_edges_of_opaque_voxels() {
    let table = TableDesc { sections: 128, radial_samples: 256, lookup: Lookup::Linear };
    for (kappa, width) in
        [0.5, 1.0, 2.0].iter().flat_map(|&kappa| [0.1, 0.3, 1.0, 2.0, 4.0].map(|w| (kappa, w)))
    {
        let kernel = kernel_named("gaussian").unwrap();
        let (kernel, normalization) = (&*kernel, Normalization::None);
        let desc = SectionDesc { kernel, width, kappa, normalization, base_width: 0.5 };
        let fit = RadialPolynomials::of_sections(&SectionTable::new(&desc, table), Degree::High);
        println!("κ = {kappa}, w = {width}: {:.1e}", fit.pixel_error());
        let error = fit.pixel_error();
        assert!(0.0 < error && error < 1.5e-4, "κ = {kappa}, w = {width}: {error}");
    }
}

#[test]
fn polynomials_know_their_errors() {
    for &name in KERNEL_NAMES {
        let table = FootprintTable::new(&*kernel_named(name).unwrap(), 1.0, 256);
        let [low, high] = [Degree::Low, Degree::High]
            .map(|degree| RadialPolynomials::of_footprint(&table, degree));
        assert!(low.row(0)[8..] == [0.0; 4] && high.row(0)[11] != 0.0);
        assert!(0.0 < high.error() && high.error() < low.error(), "{name}");
        let n_samples = (table.row().len() - 2) as f64;
        for step in 0..300 {
            let part = (f64::from(step) + 0.5) / 300.0;
            let half_chord = (1.0 - part).sqrt() * n_samples;
            let weight = f64::from(lerp_radial(table.row(), half_chord as f32));
            for fit in [&low, &high] {
                let off =
                    f64::from(fit.weight(0, (2.0 * part - 1.0) as f32, WHOLE.map(|f| f as f32)))
                        - weight;
                assert!(off.abs() < 1.1 * fit.error(), "{name} {part}: {off}");
            }
        }
    }
}
