//! Kernels by their names: the built-in ones, and those of whoever uses the crate.

use crate::kernel::{half_chord, kernel_named};
use crate::{KERNEL_NAMES, Kernel, MAX_RADIUS, UnknownKernel};
use std::f64::consts::PI;
use std::sync::Arc;
use thiserror::Error;

/// The built-in kernels, and others that were added.
///
/// ```
/// use slabsplat_kernel::{Gaussian, Kernels};
/// use std::sync::Arc;
///
/// let mut kernels = Kernels::default();
/// assert!(kernels.named("gaussian").is_ok());
/// let error = kernels.add(Arc::new(Gaussian)).unwrap_err();
/// assert_eq!(error.to_string(), "there is a kernel \"gaussian\" already");
/// ```
#[derive(Clone, Debug, Default)]
pub struct Kernels {
    added: Vec<Arc<dyn Kernel>>,
}

/// Why a kernel cannot be added.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum KernelError {
    /// Another kernel has its name.
    #[error("there is a kernel \"{0}\" already")]
    NameTaken(String),
    /// Its radius is not above 0, or too large.
    #[error("the kernel's radius must be above 0 and at most {MAX_RADIUS} voxel steps, not {0}")]
    BadRadius(f64),
    /// It is NaN, infinite or negative within its radius, or not 0 from there on.
    #[error("the kernel is {value} at r = {r}: it must be at least 0, and 0 from its radius on")]
    BadValue {
        /// Voxel steps from its centre.
        r: f64,
        /// `h(r)`.
        value: f64,
    },
    /// Its line integrals are not those of its values.
    #[error(
        "the kernel's line integral at rho = {rho} from {} to {} is {given}, and its values sum to {summed}",
        .ends[0], .ends[1]
    )]
    NotItsIntegral {
        /// Distance of the line from the centre.
        rho: f64,
        /// Where on the line the integral begins and ends.
        ends: [f64; 2],
        /// What the kernel says.
        given: f64,
        /// What it says of its values.
        summed: f64,
    },
    /// It makes a volume denser or thinner than it is.
    #[error("the kernel integrates to {0} over its ball, and must to nearly 1: 0.9 to 1.1")]
    NotNormalized(f64),
}

/// Radii, and points along one, at which a kernel is looked at.
const N_RADII: u32 = 16;

/// Terms of a sum that stands for an integral. A kernel that ends with a step is off by one of them.
const N_TERMS: u32 = 1000;

/// Of the footprint at the centre: by how much a line integral may differ from the sum.
const MOST_OFF: f64 = 1e-2;

impl Kernels {
    /// Adds a kernel, to be used by its [`name`](Kernel::name) from now on.
    ///
    /// # Errors
    /// If there is one of that name already, or it is none that pictures can be made of: see [`Kernel`].
    pub fn add(&mut self, kernel: Arc<dyn Kernel>) -> Result<(), KernelError> {
        if self.names().any(|name| name == kernel.name()) {
            return Err(KernelError::NameTaken(kernel.name().to_owned()));
        }
        check_radius(&*kernel)?;
        check_values(&*kernel)?;
        check_integrals(&*kernel)?;
        self.added.push(kernel);
        Ok(())
    }

    /// The kernel called `name`.
    ///
    /// # Errors
    /// If it is none of [`names`](Self::names).
    pub fn named(&self, name: &str) -> Result<Arc<dyn Kernel>, UnknownKernel> {
        match self.added.iter().find(|kernel| kernel.name() == name) {
            Some(kernel) => Ok(kernel.clone()),
            None => kernel_named(name).map_err(|UnknownKernel { name, .. }| UnknownKernel {
                name,
                known: self.names().map(str::to_owned).collect(),
            }),
        }
    }

    /// The names of all kernels, the default first.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        KERNEL_NAMES.iter().copied().chain(self.added.iter().map(|kernel| kernel.name()))
    }
}

fn check_radius(kernel: &dyn Kernel) -> Result<(), KernelError> {
    let radius = kernel.radius();
    let is_good = 0.0 < radius && radius <= MAX_RADIUS;
    if is_good { Ok(()) } else { Err(KernelError::BadRadius(radius)) }
}

fn check_values(kernel: &dyn Kernel) -> Result<(), KernelError> {
    let radius = kernel.radius();
    for (idx, r) in radii(2.0 * radius) {
        let value = kernel.value(r);
        let is_good = if 2 * idx < N_RADII { 0.0 <= value } else { value == 0.0 };
        if !is_good || !value.is_finite() {
            return Err(KernelError::BadValue { r, value });
        }
    }
    let shell = |r: f64| 4.0 * PI * r * r * kernel.value(r);
    let integral = sum([0.0, radius], shell);
    let is_good = (0.9..=1.1).contains(&integral);
    if is_good { Ok(()) } else { Err(KernelError::NotNormalized(integral)) }
}

fn check_integrals(kernel: &dyn Kernel) -> Result<(), KernelError> {
    let radius = kernel.radius();
    let along = |rho: f64| move |t: f64| kernel.value(rho.hypot(t));
    let most_off = MOST_OFF * sum([-radius, radius], along(0.0));
    for (_, rho) in radii(radius) {
        let end = half_chord(radius, rho);
        // Ends outside of the ball are no different from ends on it.
        for ends in [[-9.0, 9.0], [-9.0, 0.3 * end], [-0.6 * end, 9.0], [-0.2 * end, 0.7 * end]] {
            let given = kernel.line_integral(rho, ends[0], ends[1]);
            let summed = sum(ends.map(|t| t.clamp(-end, end)), along(rho));
            // NaN fails this.
            let is_near = (given - summed).abs() <= most_off;
            if !is_near {
                return Err(KernelError::NotItsIntegral { rho, ends, given, summed });
            }
        }
    }
    Ok(())
}

/// Numbered radii from 0 to `end`.
fn radii(end: f64) -> impl Iterator<Item = (u32, f64)> {
    (0..=N_RADII).map(move |idx| (idx, end * f64::from(idx) / f64::from(N_RADII)))
}

/// An integral by the midpoint rule, which never asks for a value at an end.
fn sum([a, b]: [f64; 2], f: impl Fn(f64) -> f64) -> f64 {
    let step = (b - a) / f64::from(N_TERMS);
    (0..N_TERMS).map(|term| f(a + step * (f64::from(term) + 0.5))).sum::<f64>() * step
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{CrawfisMax, Gaussian};

    /// Another kernel under another name, made wrong at one point.
    #[derive(Debug)]
    struct Changed<K> {
        name: &'static str,
        kernel: K,
        radius: f64,
        factor: f64,
        factor_of_integrals: f64,
    }

    impl<K: Kernel> Changed<K> {
        fn new(kernel: K) -> Self {
            let radius = kernel.radius();
            Self { name: "own", kernel, radius, factor: 1.0, factor_of_integrals: 1.0 }
        }
    }

    impl<K: Kernel> Kernel for Changed<K> {
        fn name(&self) -> &str {
            self.name
        }

        fn radius(&self) -> f64 {
            self.radius
        }

        fn value(&self, r: f64) -> f64 {
            self.factor * self.kernel.value(r)
        }

        fn line_integral(&self, rho: f64, a: f64, b: f64) -> f64 {
            self.factor * self.factor_of_integrals * self.kernel.line_integral(rho, a, b)
        }
    }

    #[test]
    fn kernels_that_are_added_are_found() {
        let mut kernels = Kernels::default();
        assert!(kernels.named("own").is_err());
        kernels.add(Arc::new(Changed::new(Gaussian))).unwrap();
        kernels.add(Arc::new(Changed { name: "other", ..Changed::new(CrawfisMax) })).unwrap();
        assert_eq!(kernels.named("own").unwrap().value(0.5), Gaussian.value(0.5));
        assert_eq!(kernels.named("other").unwrap().radius(), CrawfisMax.radius());
        assert_eq!(kernels.named("crawfis-max").unwrap().radius(), CrawfisMax.radius());
        let error = kernels.named("box").unwrap_err().to_string();
        assert_eq!(
            error,
            "there is no kernel \"box\"; there are gaussian, crawfis-max, own, other"
        );
        for name in ["own", "gaussian"] {
            let again = Changed { name, ..Changed::new(Gaussian) };
            assert_eq!(kernels.add(Arc::new(again)), Err(KernelError::NameTaken(name.to_owned())));
        }
    }

    #[test]
    fn kernels_refuse_what_is_none() {
        type Is = fn(&KernelError) -> bool;
        let bad_radius: Is = |error| matches!(error, KernelError::BadRadius(_));
        let bad_value: Is = |error| matches!(error, KernelError::BadValue { .. });
        let not_its_integral: Is = |error| matches!(error, KernelError::NotItsIntegral { .. });
        let not_normalized: Is = |error| matches!(error, KernelError::NotNormalized(_));
        let good = || Changed::new(CrawfisMax);
        for (kernel, is_expected) in [
            (Changed { radius: 0.0, ..good() }, bad_radius),
            (Changed { radius: f64::NAN, ..good() }, bad_radius),
            (Changed { radius: 2.1, ..good() }, bad_radius),
            (Changed { radius: 1.0, ..good() }, bad_value),
            (Changed { factor: -1.0, ..good() }, bad_value),
            (Changed { factor: f64::NAN, ..good() }, bad_value),
            (Changed { factor: 0.8, ..good() }, not_normalized),
            (Changed { factor: 1.3, ..good() }, not_normalized),
            (Changed { factor_of_integrals: 1.05, ..good() }, not_its_integral),
            (Changed { factor_of_integrals: f64::INFINITY, ..good() }, not_its_integral),
        ] {
            let error = Kernels::default().add(Arc::new(kernel)).unwrap_err();
            assert!(is_expected(&error), "{error}");
        }
    }
}
