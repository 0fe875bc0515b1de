//! The values of a volume in boxes, as transfer functions are stretched to them.

use super::DividedError;
use super::survey::Survey;
use crate::small_samples::SmallSamples;
use crate::transfer::{Bins, VolumeValues};
use slabsplat_core::{Samples, Volume, with_samples};
use slabsplat_io::IoError;
use std::cell::{OnceCell, RefCell};

/// All values of a volume, which are read if somebody asks for them: those of samples of 16 bits once. What
/// fails is remembered, and there are no values then.
pub(super) struct BoxValues<'a, 'e> {
    survey: Survey<'a, 'e>,
    rows: OnceCell<Volume>,
    /// Each value that samples may have, and how many do.
    counted: OnceCell<Option<Vec<(f64, u64)>>>,
    failure: RefCell<Option<DividedError>>,
}

impl<'a, 'e> BoxValues<'a, 'e> {
    pub(super) fn new(survey: Survey<'a, 'e>) -> Self {
        Self {
            survey,
            rows: OnceCell::new(),
            counted: OnceCell::new(),
            failure: RefCell::new(None),
        }
    }

    /// Why there are no values, if they could not be read.
    pub(super) fn failure(&self) -> Option<DividedError> {
        self.failure.take()
    }

    /// Finds some numbers of each piece, and joins them.
    fn of_pieces(
        &self,
        nothing: &[f64],
        look: impl Fn(&Volume, &mut [f64]),
        join: impl Fn(f64, f64) -> f64,
    ) -> Option<Vec<f64>> {
        let of_own = || -> Result<Samples, IoError> {
            let mut own = nothing.to_vec();
            for of in self.survey.own_pieces() {
                look(&self.survey.source.read(of)?.volume, &mut own);
            }
            Ok(Samples::F64(own))
        };
        if self.failure.borrow().is_some() {
            return None;
        }
        let joined = self.survey.all(of_own()).and_then(|all| {
            let mut joined = nothing.to_vec();
            for of_share in &all {
                let Samples::F64(of_share) = of_share else { return Err(DividedError::Differing) };
                let pairs = joined.iter_mut().zip(of_share);
                pairs.for_each(|(joined, of)| *joined = join(*joined, *of));
            }
            Ok(joined)
        });
        joined.map_err(|error| self.failure.replace(Some(error))).ok()
    }

    /// Each value, if samples are of 16 bits or fewer.
    fn counted(&self) -> Option<&[(f64, u64)]> {
        let count = || {
            let small = self.small()?;
            let add = |volume: &Volume, all: &mut [f64]| {
                let of_piece = with_samples!(volume.samples(), |s| small.counts(s.iter()));
                all.iter_mut().zip(of_piece).for_each(|(all, n)| *all += n as f64);
            };
            let counts = self.of_pieces(&vec![0.0; small.n()], add, |a, b| a + b)?;
            let counts = counts.into_iter().map(|n| n as u64).collect();
            let scaling = self.survey.source.first().volume.scaling();
            Some(small.with_values(&[counts], scaling))
        };
        self.counted.get_or_init(count).as_deref()
    }

    fn small(&self) -> Option<SmallSamples> {
        SmallSamples::of(self.survey.source.first().volume.sample_type())
    }

    fn is_small(&self) -> bool {
        self.small().is_some()
    }

    /// The least and the largest of what is found in each piece.
    fn ends(&self, of: impl Fn(&Volume) -> Option<[f64; 2]>) -> Option<[f64; 2]> {
        let nothing = [f64::INFINITY; 2];
        // The largest is the least of their negatives.
        let look = |volume: &Volume, ends: &mut [f64]| {
            if let Some([lo, hi]) = of(volume) {
                (ends[0], ends[1]) = (lo.min(ends[0]), (-hi).min(ends[1]));
            }
        };
        let ends = self.of_pieces(&nothing, look, f64::min)?;
        let range = [ends[0], -ends[1]];
        (range[0] <= range[1]).then_some(range)
    }
}

impl VolumeValues for BoxValues<'_, '_> {
    fn rows(&self) -> &Volume {
        self.rows.get_or_init(|| {
            self.survey.rows().unwrap_or_else(|error| {
                self.failure.replace(Some(error));
                Volume::clone(&self.survey.source.first().volume)
            })
        })
    }

    fn range(&self) -> Option<[f64; 2]> {
        match self.is_small() {
            true => self.extremes_where(&|_| true),
            false => self.ends(|volume| volume.summary().range),
        }
    }

    fn counts(&self, bins: Bins) -> Vec<u64> {
        let mut counts = vec![0; bins.n_bins];
        if self.is_small() {
            for (value, n) in self.counted().unwrap_or_default() {
                if let Some(bin) = bins.bin_of(*value) {
                    counts[bin] += n;
                }
            }
            return counts;
        }
        let add = |volume: &Volume, all: &mut [f64]| {
            let of_piece = bins.counts(volume);
            all.iter_mut().zip(of_piece).for_each(|(all, n)| *all += n as f64);
        };
        let all = self.of_pieces(&vec![0.0; bins.n_bins], add, |a, b| a + b);
        all.map_or(counts, |all| all.into_iter().map(|n| n as u64).collect())
    }

    fn extremes_where(&self, is_one: &(dyn Fn(f64) -> bool + Sync)) -> Option<[f64; 2]> {
        if !self.is_small() {
            return self.ends(|volume| volume.extremes_where(is_one));
        }
        let values = self.counted()?.iter().map(|(value, _)| *value);
        let ends = values.filter(|value| is_one(*value)).map(|value| [value, value]);
        ends.reduce(|[lo, hi], [value, _]| [lo.min(value), hi.max(value)])
    }
}
