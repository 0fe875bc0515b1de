//! Sections whose slab faces cut the rays of a footprint at different offsets (model §2), for kernels that
//! are a product.
//!
//! Where a grid's steps differ in length, faces are *tilted* against rays in index space, and a section's
//! weight depends on two numbers of a pixel: its distance from the centre, and the offset of the cut. A
//! Gaussian is a function across the ray times one along it, so that the weight still takes only polynomials
//! of one number each, which are fitted here:
//!
//! ```text
//! H = g(ρ)·(A(back) − A(front)),    A(s) = ∫₀ˢ a,    h(√(ρ² + s²)) = g(ρ)·a(s)
//! ```
//!
//! `front` and `back` are where the faces cut the ray, but no further than where it leaves the kernel's ball,
//! `±√(R² − ρ²)`. So nothing is approximated but two smooth functions.

use crate::radial_polynomials::polynomial;
use crate::{Kernel, RadialPolynomials};

/// What stands for all sections of one kernel, whatever the width of slabs.
#[derive(Clone, Debug, PartialEq)]
pub struct TiltedSections {
    across: [f32; N_ACROSS],
    along: [f32; N_ALONG],
    radius: f32,
}

/// Coefficients of `g`. Normals are made of its slope, and it is off at the same points in all sections: with
/// nine coefficients a normal zoomed in on is off by a thousandth.
const N_ACROSS: usize = 11;

/// Coefficients of `A(s)/s`, which is a mean and so even smoother.
const N_ALONG: usize = 9;

/// A kernel whose sections are further from a product than this part of its footprint's peak is none.
const MOST_OFF: f64 = 1e-4;

/// Points along a radius at which products are compared with sections.
const N_POINTS: usize = 8;

impl TiltedSections {
    /// Those of a kernel seen with `kappa` index units of ray to a `unit` of depth; `None` if it is no
    /// product.
    pub fn new(kernel: &dyn Kernel, kappa: f64) -> Option<Self> {
        let radius = kernel.radius();
        let u_of = |x: f64| radius * (0.5 * (x + 1.0)).sqrt();
        // Nodes lie within the ball: a kernel may end with a step.
        let across = |x: f64| kernel.value(u_of(x)) / (kernel.value(0.0) * kappa);
        let along = |x: f64| kernel.line_integral(0.0, 0.0, u_of(x)) / u_of(x);
        let sections = Self {
            across: RadialPolynomials::smooth(across),
            along: RadialPolynomials::smooth(along),
            radius: radius as f32,
        };
        let position = |idx: usize| radius * idx as f64 / N_POINTS as f64;
        let is_off = |rho: f64, s: f64| {
            let exact = kernel.line_integral(rho, 0.0, s) / kappa;
            let off = exact - f64::from(sections.weight(rho as f32, [0.0, s as f32]));
            MOST_OFF * kernel.footprint(0.0) / kappa < off.abs()
        };
        let pairs =
            (0..N_POINTS).flat_map(|i| (0..=N_POINTS).map(move |j| (position(i), position(j))));
        pairs.into_iter().all(|(rho, s)| !is_off(rho, s)).then_some(sections)
    }

    /// The coefficients of `g` in `x = 2·(ρ/R)² − 1`, from the constant on.
    #[inline(always)]
    pub fn across(&self) -> &[f32; N_ACROSS] {
        &self.across
    }

    /// The coefficients of `A(s)/s` in `x = 2·(s/R)² − 1`, from the constant on.
    #[inline(always)]
    pub fn along(&self) -> &[f32; N_ALONG] {
        &self.along
    }

    /// The weight, at distance `rho` below `R`, of the section between faces that cut the ray that many index
    /// units behind its point nearest to the voxel.
    pub fn weight(&self, rho: f32, faces: [f32; 2]) -> f32 {
        let x_of = |u: f32| 2.0 * (u / self.radius).powi(2) - 1.0;
        let end = (self.radius * self.radius - rho * rho).max(0.0).sqrt();
        let [front, back] = faces.map(|face| {
            let s = face.clamp(-end, end);
            s * polynomial(&self.along, x_of(s))
        });
        polynomial(&self.across, x_of(rho)) * (back - front)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{SectionDesc, kernel_named};
    use slabsplat_core::Normalization;
    use slabsplat_seeds::for_each_seed;

    #[test]
    fn tilted_sections_are_exact() {
        let kernel = kernel_named("gaussian").unwrap();
        for_each_seed(1, |mut rng| {
            let [mut worst, mut worst_slope] = [0.0_f64; 2];
            for _ in 0..40 {
                let (kappa, width) = (0.05 + rng.f64(), 0.1 + 3.0 * rng.f64());
                let normalization = Normalization::None;
                let desc =
                    SectionDesc { kernel: &*kernel, width, kappa, normalization, base_width: 0.5 };
                let sections = TiltedSections::new(&*kernel, kappa).unwrap();
                for _ in 0..100 {
                    let rho = (2.0 - PIXEL) * rng.f64();
                    let front = 5.0 * rng.f64() - 3.0;
                    let faces = [front, front + desc.width_in_index()].map(|face| face as f32);
                    let error = |rho: f64| {
                        let weight = f64::from(sections.weight(rho as f32, faces));
                        kappa * (weight - desc.weight(rho, front))
                    };
                    worst = worst.max(error(rho).abs());
                    let slope = (error(rho + PIXEL) - error(rho)) / PIXEL;
                    worst_slope = worst_slope.max(slope.abs());
                }
            }
            println!("worst {worst:.2e}, slope {worst_slope:.2e}");
            assert!(worst < 2e-6, "{worst}");
            // With 6e-5 a pixel of seed 112 of `parity_of_densities_zoomed_in` was off by more than 10⁻³.
            assert!(worst_slope < 2e-5, "{worst_slope}");
        });
    }

    /// In index units.
    const PIXEL: f64 = 1.0 / 64.0;

    /// It is in two pieces, each of which would be a sum of products.
    #[test]
    fn tilted_sections_are_of_products_only() {
        let kernel = kernel_named("crawfis-max").unwrap();
        assert_eq!(TiltedSections::new(&*kernel, 1.0), None);
    }
}
