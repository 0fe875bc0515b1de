//! What is known of a volume for as long as frames show it.

use crate::number::Numbers;
use crate::samples::KeyCounts;
use slabsplat_core::Volume;
use slabsplat_traverse::BrickRanges;
use std::sync::{Arc, OnceLock};

/// A volume, and what a pass over all its samples finds, once someone asks.
#[derive(Debug)]
pub(crate) struct KnownVolume {
    pub(crate) volume: Arc<Volume>,
    pub(crate) numbers: Numbers,
    key_counts: OnceLock<KeyCounts>,
    brick_ranges: OnceLock<BrickRanges>,
}

impl KnownVolume {
    pub(crate) fn new(volume: Arc<Volume>) -> Self {
        let numbers = Numbers::new(&volume);
        Self { volume, numbers, key_counts: OnceLock::new(), brick_ranges: OnceLock::new() }
    }

    /// How many samples there are of each key, for lists that the device makes.
    pub(crate) fn key_counts(&self) -> &KeyCounts {
        self.key_counts.get_or_init(|| KeyCounts::new(&self.volume))
    }

    /// The least and the largest value of every brick, for lists that the host makes.
    pub(crate) fn brick_ranges(&self) -> &BrickRanges {
        self.brick_ranges.get_or_init(|| BrickRanges::new(&self.volume))
    }
}
