//! What is known of samples whose neighbours differ alike: how far off predictions are, and to which side
//! (T.87 §A.2, §A.6, §A.7.2).

use super::super::segments::Broken;
use super::bits::Bits;
use super::presets::Coding;

/// Bits of the lower part of a code: samples of 16 bits need no more.
const MAX_K: u32 = 16;

/// Corrections of predictions are within ±128 (§A.6.2).
const CORRECTIONS: std::ops::RangeInclusive<i32> = -128..=127;

/// Of samples that are predicted.
#[derive(Clone, Copy, Debug)]
pub(super) struct Context {
    /// Sum of the sizes of errors, A.
    sizes: i64,
    /// Sum of errors, B, less what went into the correction.
    bias: i32,
    /// What is added to a prediction, C.
    pub(super) correction: i32,
    /// Samples, N.
    n: i64,
}

/// Of samples that end a run.
#[derive(Clone, Copy, Debug)]
pub(super) struct RunContext {
    sizes: i64,
    n: i64,
    /// Errors below zero, Nn.
    n_negative: i64,
    /// Whether samples to the left and above are the same, RItype.
    are_same: bool,
}

/// The first sum of sizes (§A.2.1).
fn first_sizes(coding: &Coding) -> i64 {
    i64::from(((coding.range + 32) / 64).max(2))
}

/// How many bits a number is likely to have, Golomb's parameter (§A.5.1).
fn golomb_parameter(sizes: i64, n: i64) -> Result<u32, Broken> {
    (0..=MAX_K).find(|k| sizes <= n << k).ok_or("its errors are too large")
}

impl Context {
    pub(super) fn new(coding: &Coding) -> Self {
        Self { sizes: first_sizes(coding), bias: 0, correction: 0, n: 1 }
    }

    /// Reads the error of a prediction, and learns from it.
    pub(super) fn read(&mut self, bits: &mut Bits<'_>, coding: &Coding) -> Result<i32, Broken> {
        let k = golomb_parameter(self.sizes, self.n)?;
        let mapped = bits.golomb(k, coding.limit, coding.error_bits)?;
        // Signs alternate (§A.5.2); the other way round if errors are mostly negative and nothing is small.
        let error = if mapped & 1 == 0 { mapped / 2 } else { -(mapped + 1) / 2 };
        let is_turned = coding.near == 0 && k == 0 && 2 * i64::from(self.bias) <= -self.n;
        let error = if is_turned { -error - 1 } else { error };
        self.learn(error, coding);
        Ok(error)
    }

    /// §A.6.1, §A.6.2.
    fn learn(&mut self, error: i32, coding: &Coding) {
        self.bias += error * (2 * coding.near + 1);
        self.sizes += i64::from(error.abs());
        if self.n == coding.reset {
            self.sizes >>= 1;
            self.bias >>= 1;
            self.n >>= 1;
        }
        self.n += 1;
        let n = self.n as i32;
        if self.bias <= -n {
            self.bias = (self.bias + n).max(1 - n);
            self.correction = (self.correction - 1).max(*CORRECTIONS.start());
        } else if 0 < self.bias {
            self.bias = (self.bias - n).min(0);
            self.correction = (self.correction + 1).min(*CORRECTIONS.end());
        }
    }
}

impl RunContext {
    pub(super) fn new(coding: &Coding, are_same: bool) -> Self {
        Self { sizes: first_sizes(coding), n: 1, n_negative: 0, are_same }
    }

    /// Reads the error of the sample that ends a run, whose code has up to `limit` bits.
    pub(super) fn read(
        &mut self,
        bits: &mut Bits<'_>,
        coding: &Coding,
        limit: u32,
    ) -> Result<i32, Broken> {
        let more = if self.are_same { self.n >> 1 } else { 0 };
        let k = golomb_parameter(self.sizes + more, self.n)?;
        let mapped = bits.golomb(k, limit, coding.error_bits)?;
        let kind = i32::from(self.are_same);
        // §A.7.2.2: the lowest bit says whether the sign is the one that is less likely.
        let doubled = mapped + kind;
        let size = (doubled + 1) / 2;
        let is_odd = doubled & 1 == 1;
        let is_negative = is_odd == (k != 0 || self.n <= 2 * self.n_negative);
        let error = if is_negative { -size } else { size };
        self.n_negative += i64::from(error < 0);
        self.sizes += i64::from((mapped + 1 - kind) >> 1);
        if self.n == coding.reset {
            self.sizes >>= 1;
            self.n >>= 1;
            self.n_negative >>= 1;
        }
        self.n += 1;
        Ok(error)
    }
}
