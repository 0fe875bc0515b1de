//! Tables against what they sample, and how they end with a cancelled frame.

use super::*;
use crate::{Gaussian, KERNEL_NAMES, Kernel, kernel_named};
use std::sync::atomic::{AtomicUsize, Ordering};

const PAPER: TableDesc = TableDesc { sections: 128, radial_samples: 256, lookup: Lookup::Nearest };
const DEFAULT: TableDesc = TableDesc { lookup: Lookup::Linear, ..PAPER };

fn desc<'a>(name: &str, width: f64, normalization: Normalization) -> SectionDesc<'a> {
    let kernel = Box::leak(Box::new(kernel_named(name).unwrap()));
    SectionDesc { kernel: &**kernel, width, kappa: 1.0, normalization, base_width: 0.5 }
}

/// Largest and mean error over a lattice of offsets and distances that hits no sample.
fn errors(desc: &SectionDesc<'_>, table: TableDesc) -> (f64, f64) {
    let sampled = SectionTable::new(desc, table);
    let (radius, width) = (desc.kernel.radius(), desc.width_in_index());
    let (n_offsets, n_radii) = (701, 211);
    let (mut worst, mut sum) = (0.0_f64, 0.0);
    for o in 0..n_offsets {
        let front =
            -radius - width + (f64::from(o) + 0.3) / f64::from(n_offsets) * (2.0 * radius + width);
        for r in 0..n_radii {
            let rho = (f64::from(r) + 0.4) / f64::from(n_radii) * radius;
            let read = sampled.sample(rho as f32, front as f32, (front + width) as f32);
            let error = (f64::from(read) - desc.weight(rho, front)).abs();
            worst = worst.max(error);
            sum += error;
        }
    }
    (worst, sum / f64::from(n_offsets * n_radii))
}

/// The measured error of the table against the exact integral, per section.
#[test]
fn section_table_error_is_small() {
    for &name in KERNEL_NAMES {
        for width in [0.25, 0.5, 1.0, 2.0, 5.0, 100.0] {
            let desc = desc(name, width, Normalization::None);
            let (worst, mean) = errors(&desc, DEFAULT);
            println!("{name} w={width}: linear {worst:.1e} (mean {mean:.1e})");
            assert!(worst < 3e-4 && mean < 3e-5, "{name} w={width}: {worst} {mean}");
            let (worst, mean) = errors(&desc, PAPER);
            println!("{name} w={width}: nearest {worst:.1e} (mean {mean:.1e})");
            assert!(worst < 2e-2 && mean < 2e-3, "{name} w={width}: {worst} {mean}");
        }
    }
}

#[test]
fn section_table_error_is_small_when_normalized() {
    for normalization in [Normalization::Paper, Normalization::Product] {
        for width in [0.75, 1.0, 2.0, 3.0, 16.0] {
            let (worst, mean) = errors(&desc("gaussian", width, normalization), DEFAULT);
            println!("{normalization} w={width}: {worst:.1e} (mean {mean:.1e})");
            assert!(worst < 3e-4 && mean < 3e-5, "{normalization} w={width}: {worst} {mean}");
        }
    }
}

#[test]
fn section_table_doubled_resolution_quarters_the_error() {
    let desc = desc("gaussian", 1.0, Normalization::None);
    let (_, coarse) = errors(&desc, DEFAULT);
    let twice = TableDesc { sections: 256, radial_samples: 512, ..DEFAULT };
    let (_, fine) = errors(&desc, twice);
    assert!(fine < 0.35 * coarse, "{coarse} {fine}");
}

/// §3.2: "symmetry allows the reuse of sections for part of the kernel width".
#[test]
fn section_table_stores_half_if_symmetric() {
    let plain = SectionTable::new(&desc("gaussian", 1.0, Normalization::None), PAPER);
    assert_eq!(plain.n_rows(), 65);
    let normalized = SectionTable::new(&desc("gaussian", 1.0, Normalization::Product), PAPER);
    assert_eq!(normalized.n_rows(), 129);
    assert_eq!(plain.sample(0.4, -1.2, -0.2), plain.sample(0.4, 0.2, 1.2));
}

#[test]
fn section_table_rows_are_sections_between_their_faces() {
    let desc = SectionDesc { kappa: 0.8, ..desc("crawfis-max", 0.7, Normalization::None) };
    let table = SectionTable::new(&desc, DEFAULT);
    let rows = table.all_rows();
    assert_eq!((rows.len(), table.row_len()), (table.n_rows(), 258));
    assert_eq!(rows.concat(), table.weights());
    for (row_idx, row) in rows.into_iter().enumerate() {
        let [front, back] = table.faces_of_row(row_idx);
        assert!((back - front - desc.width_in_index()).abs() < 1e-12, "{row_idx}");
        for rho in [0.0, 0.4, 1.1, 1.5] {
            let half_chord = half_chord(desc.kernel.radius(), rho) as f32;
            let read = lerp_radial(row, half_chord * table.samples_per_index());
            let error = (f64::from(read) - desc.weight(rho, front)).abs();
            assert!(error < 1e-4, "{row_idx} {rho}: {error}");
        }
    }
}

#[test]
fn section_table_reads_the_nearest_row_or_two() {
    let desc = desc("gaussian", 1.0, Normalization::None);
    for (lookup, near, far) in
        [(Lookup::Nearest, (9, 0.0), (10, 0.0)), (Lookup::Linear, (9, 0.25), (9, 0.75))]
    {
        let table = SectionTable::new(&desc, TableDesc { lookup, ..PAPER });
        let at = |rows: f64| {
            let [front, back] = [0, 1].map(|face| {
                table.faces_of_row(9)[face] + rows / f64::from(table.rows().rows_per_index)
            });
            let (row_idx, t) = table.row_at(front as f32, back as f32);
            (row_idx, (64.0 * t).round() / 64.0)
        };
        assert_eq!((at(0.25), at(0.75)), (near, far), "{lookup}");
    }
}

/// Never further apart than the paper's of the thinnest slabs, nor than a quarter of a slab.
#[test]
fn section_table_rows_are_close() {
    let rows = |width: f64, table: TableDesc| {
        SectionTable::new(&desc("gaussian", width, Normalization::None), table).n_rows()
    };
    let coarse = TableDesc { radial_samples: 2, ..DEFAULT };
    assert_eq!(rows(4.0, coarse), 129, "4/128 apart over a depth of 2 + 4/2");
    assert_eq!(rows(1.0, coarse), 81, "4/128 apart over a depth of 2 + 1/2");
    assert_eq!(rows(0.04, coarse), 203, "0.04/4 apart over a depth of 2 + 0.04/2");
    assert_eq!(rows(1e-12, coarse), 2049, "4/4096 apart over a depth of 2");
    let nearest = TableDesc { lookup: Lookup::Nearest, ..coarse };
    assert_eq!(rows(1e-12, nearest), 65, "half of the paper's");
    assert_eq!(rows(9.0, nearest), 65, "half of the paper's");
    let smaller = desc("crawfis-max", 1e-12, Normalization::None);
    assert_eq!(SectionTable::new(&smaller, coarse).n_rows(), 2049, "a 4096th of its extent");
}

/// A polygon through them has the parabola's area.
#[test]
fn fitted_values_are_right_on_average() {
    let parabola: Vec<f64> = (0..6).map(|x: i32| f64::from(3 * x * x - 5 * x)).collect();
    let fitted: Vec<f64> = fitted(&parabola).collect();
    assert_eq!([fitted[0], fitted[5]], [parabola[0], parabola[5]], "the ends stay");
    let integral = |x: f64| x * x * x - 2.5 * x * x;
    for (x, pair) in fitted.windows(2).enumerate().take(4).skip(1) {
        let x = x as f64;
        let area = 0.5 * (pair[0] + pair[1]);
        assert!((area - (integral(x + 1.0) - integral(x))).abs() < 1e-12, "{x}: {area}");
    }
}

#[test]
fn lerp_radial_draws_lines_between_samples() {
    let row = [0.0, 1.0, 5.0, 3.0, 3.0];
    for (position, expected) in
        [(0.0, 0.0), (0.5, 0.5), (1.0, 1.0), (1.25, 2.0), (1.75, 4.0), (2.5, 4.0), (3.0, 3.0)]
    {
        assert_eq!(lerp_radial(&row, position), expected, "{position}");
    }
}

/// A slab of 10¹² steps cuts what one of 4 does, and one no wider than the base is plain.
#[test]
fn section_table_of_extreme_widths() {
    let wide = SectionTable::new(&desc("gaussian", 1e12, Normalization::None), DEFAULT);
    assert!(wide.n_rows() <= 130);
    let half = wide.sample(0.5, 0.0, 1e12);
    let exact = desc("gaussian", 9.0, Normalization::None).weight(0.5, 0.0);
    assert!((f64::from(half) - exact).abs() < 1e-4, "{half} {exact}");
    let based = SectionDesc { base_width: 1e9, ..desc("gaussian", 1e9, Normalization::Product) };
    assert!(SectionTable::new(&based, DEFAULT).n_rows() <= 130);
}

/// Also where a slab is thinner than the paper's rows are apart.
#[test]
fn section_table_of_thin_slabs() {
    let (worst, _) = errors(&desc("gaussian", 0.04, Normalization::None), DEFAULT);
    assert!(worst < 1.2e-5, "{worst}");
}

/// A kernel that cancels a frame when it is asked for its so-manieth integral.
#[derive(Debug)]
struct Cancelling {
    frame: FrameHandle,
    at_integral: usize,
    n_integrals: AtomicUsize,
}

impl Kernel for Cancelling {
    fn name(&self) -> &str {
        "cancelling"
    }

    fn radius(&self) -> f64 {
        Gaussian.radius()
    }

    fn value(&self, r: f64) -> f64 {
        Gaussian.value(r)
    }

    fn line_integral(&self, rho: f64, a: f64, b: f64) -> f64 {
        if self.n_integrals.fetch_add(1, Ordering::Relaxed) == self.at_integral {
            self.frame.cancel();
        }
        Gaussian.line_integral(rho, a, b)
    }
}

/// Not a row later: after the very sample at which it is cancelled.
#[test]
fn section_table_stops_when_cancelled() {
    for normalization in [Normalization::None, Normalization::Paper] {
        for at_integral in [0, 1, 70, 7000] {
            let kernel = Cancelling {
                frame: FrameHandle::new(),
                at_integral,
                n_integrals: AtomicUsize::new(0),
            };
            let desc = SectionDesc { kernel: &kernel, ..desc("gaussian", 4.0, normalization) };
            let made = SectionTable::for_frame(&desc, DEFAULT, &kernel.frame);
            assert_eq!(made, Err(Cancelled));
            // Of one sample: the section, and those of the hierarchy over eight of half a step.
            let most_of_sample = 1 + 1 + 8;
            let n_integrals = kernel.n_integrals.into_inner();
            assert!(n_integrals <= at_integral + most_of_sample, "{n_integrals}");
        }
    }
}

#[test]
fn section_table_is_zero_where_nothing_is_cut() {
    let table = SectionTable::new(&desc("gaussian", 1.0, Normalization::None), DEFAULT);
    for (rho, front) in [(0.0, 2.0), (0.0, -3.0), (0.0, 50.0), (2.0, -0.5), (9.0, -0.5)] {
        assert_eq!(table.sample(rho, front, front + 1.0), 0.0, "{rho} {front}");
    }
}
