//! What is known of a volume for as long as frames show it.

use crate::number::Numbers;
use crate::samples::KeyCounts;
use slabsplat_backend::densities::{finite_samples, finite_values};
use slabsplat_core::{Volume, with_samples};
use slabsplat_traverse::BrickRanges;
use std::sync::{Arc, OnceLock};

/// A volume, and what a pass over all its samples finds, once someone asks.
#[derive(Debug)]
pub(crate) struct KnownVolume {
    pub(crate) volume: Arc<Volume>,
    pub(crate) numbers: Numbers,
    key_counts: OnceLock<KeyCounts>,
    brick_ranges: OnceLock<BrickRanges>,
    finite_range: OnceLock<Option<[f64; 2]>>,
}

impl KnownVolume {
    pub(crate) fn new(volume: Arc<Volume>) -> Self {
        let numbers = Numbers::new(&volume);
        Self {
            volume,
            numbers,
            key_counts: OnceLock::new(),
            brick_ranges: OnceLock::new(),
            finite_range: OnceLock::new(),
        }
    }

    /// How many samples there are of each key, for lists that the device makes.
    pub(crate) fn key_counts(&self) -> &KeyCounts {
        self.key_counts.get_or_init(|| KeyCounts::new(&self.volume))
    }

    /// The least and the largest value of every brick, for lists that the host makes.
    pub(crate) fn brick_ranges(&self) -> &BrickRanges {
        self.brick_ranges.get_or_init(|| BrickRanges::new(&self.volume))
    }

    /// The least and the largest finite value, for densities; `None` if there is none.
    pub(crate) fn finite_range(&self) -> Option<[f64; 2]> {
        *self.finite_range.get_or_init(|| {
            let samples = with_samples!(self.volume.samples(), |s| finite_samples(s));
            finite_values(samples, self.volume.scaling())
        })
    }
}
