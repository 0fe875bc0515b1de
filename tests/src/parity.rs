//! Whether backends draw scenes at random as the float64 reference and as the CPU does, at the tolerances of
//! model §9.

use fastrand::Rng;
use slabsplat::{Image, Scene};
use std::fmt::{self, Debug, Display, Formatter};

use crate::reference::{self, ReferenceImage};
use crate::render::{backends, pictures};

/// What a pixel may differ from the reference at most, and on average over a picture.
const MAX_DIFFERENCE: f64 = 1e-3;
const MEAN_DIFFERENCE: f64 = 1e-4;

/// What a pixel may differ from that of the CPU backend.
const FROM_CPU: f32 = 1e-3;

/// What a backend may make of a scene within its tolerance: it merges what the definition says.
#[derive(Clone, Debug)]
pub struct WithinTolerance {
    tolerance: f64,
    merged: ReferenceImage,
    exact: ReferenceImage,
}

/// The part of a tolerance that a GPU backend may use up with shorter polynomials.
const SHARE_OF_POLYNOMIALS: f64 = 0.05;

impl WithinTolerance {
    /// What the reference makes of a scene.
    pub fn new(scene: &Scene) -> Self {
        let merged = reference::render_within_tolerance(scene);
        Self { tolerance: scene.settings.tolerance, merged, exact: reference::render(scene) }
    }

    /// How far a backend's picture is from what merges and from the exact one, but for pixels that are
    /// undecided; and of the CPU, which may use up `share_of_footprints` of a tolerance with simpler ones.
    ///
    /// # Panics
    /// If it is further than it may be.
    pub fn check(
        &self,
        (backend, image): (&str, &Image),
        undecided: &[bool],
        share_of_footprints: f64,
        what: &impl Debug,
    ) -> [f64; 2] {
        let Self { tolerance, .. } = *self;
        let [merged, exact] = [&self.merged, &self.exact]
            .map(|expected| expected.clone().leaving(undecided, image).compare(image).max);
        let share = if backend == "cpu" { share_of_footprints } else { SHARE_OF_POLYNOMIALS };
        let most = 1e-3 + share * tolerance;
        assert!(merged < most, "{merged} off what merges, {tolerance}: {backend}, {what:?}");
        assert!(exact < 1e-3 + tolerance, "{exact} of {tolerance}: {backend}, {what:?}");
        [merged, exact]
    }
}

/// What came of some scenes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Parity {
    n_scenes: u32,
    max: f64,
    max_from_cpu: f32,
}

impl Parity {
    /// Draws a scene of some kind, which names it should it fail.
    ///
    /// # Panics
    /// If a backend's picture differs by more than the tolerances.
    pub fn check(&mut self, rng: &mut Rng, kind: &impl Debug, scene: &Scene) {
        let expected = reference::render(scene);
        let pictures = pictures(some_backends(rng), scene);
        let (_, by_cpu) = &pictures[0];
        for (backend, image) in &pictures {
            let (off, from_cpu) = (expected.compare(image), image.max_difference(by_cpu));
            let what = format!("{backend}, {kind:?}, w {}", scene.settings.slab_width);
            assert!(off.max < MAX_DIFFERENCE, "{:?}: {}: {what}", off.worst_pixel, off.max);
            assert!(off.mean < MEAN_DIFFERENCE, "{}: {what}", off.mean);
            assert!(from_cpu < FROM_CPU, "{from_cpu} off the CPU: {what}");
            self.max = self.max.max(off.max);
            self.max_from_cpu = self.max_from_cpu.max(from_cpu);
        }
        self.n_scenes += 1;
    }
}

impl Display for Parity {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { n_scenes, max, max_from_cpu } = self;
        write!(f, "{n_scenes} scenes: at most {max:.1e}, from the CPU {max_from_cpu:.1e}")
    }
}

/// The CPU, and for every other scene one of the others: a driver that plays a GPU takes its time.
fn some_backends(rng: &mut Rng) -> impl Iterator<Item = &'static str> {
    let (cpu, others) = backends().split_first().expect("there is always the CPU");
    let other = others.get(rng.usize(..2 * others.len().max(1)));
    [cpu].into_iter().chain(other).copied()
}
