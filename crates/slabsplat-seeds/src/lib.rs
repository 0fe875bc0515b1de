//! The random numbers of tests. A test that passes today passes tomorrow: its seeds are fixed. Others are
//! tried on purpose, by the hundred, and one that fails can be named.
//!
//! | environment | seeds |
//! | --- | --- |
//! | nothing | 1, 2, … up to as many as the test takes |
//! | `SLABSPLAT_SEED=7` | 7 |
//! | `SLABSPLAT_SEEDS=100..300` | 100 to 299; `cargo xtask test --seeds 200` makes up the first |
//!
//! Only a dev-dependency: nothing that draws a picture knows of this crate.
//!
//! ```
//! slabsplat_seeds::for_each_seed(2, |mut rng| {
//!     let (a, b) = (rng.u32(..1000), rng.u32(..1000));
//!     assert_eq!(a + b, b + a);
//! });
//! ```

use fastrand::Rng;
use std::ops::Range;

/// One seed, to repeat a failure.
pub const SEED: &str = "SLABSPLAT_SEED";

/// Many, as `first..end`.
pub const SEEDS: &str = "SLABSPLAT_SEEDS";

/// Runs `test` once for each seed: for the first `n_fixed`, unless the environment names others. If it
/// panics, the seed is printed.
///
/// # Panics
/// If `test` does, or the environment holds no seeds.
pub fn for_each_seed(n_fixed: u64, mut test: impl FnMut(Rng)) {
    for_each_numbered_seed(n_fixed, |_, rng| test(rng));
}

/// The same for tests that deal out a large number of cases among seeds: `test` gets the seed, too.
///
/// # Panics
/// As [`for_each_seed`].
pub fn for_each_numbered_seed(n_fixed: u64, mut test: impl FnMut(u64, Rng)) {
    let named = |variable: &str| std::env::var(variable).ok();
    let seeds = seeds(named(SEED).as_deref(), named(SEEDS).as_deref(), n_fixed);
    for seed in seeds.unwrap_or_else(|error| panic!("{error}")) {
        let _named_if_it_panics = Seed(seed);
        test(seed, Rng::with_seed(seed));
    }
}

fn seeds(one: Option<&str>, many: Option<&str>, n_fixed: u64) -> Result<Range<u64>, String> {
    let number = |text: &str| text.trim().parse::<u64>().ok();
    match (one, many) {
        (Some(one), _) => number(one)
            .map(|seed| seed..seed.saturating_add(1))
            .ok_or_else(|| format!("{SEED} is a whole number below 2^64, not {one:?}")),
        (None, Some(many)) => many
            .split_once("..")
            .and_then(|(first, end)| Some(number(first)?..number(end)?))
            .filter(|seeds| !seeds.is_empty())
            .ok_or_else(|| format!("{SEEDS} is two whole numbers, first..end, not {many:?}")),
        (None, None) => Ok(1..1 + n_fixed),
    }
}

/// The seed of the test that runs.
struct Seed(u64);

impl Drop for Seed {
    fn drop(&mut self) {
        if std::thread::panicking() {
            println!("to repeat this: {SEED}={}", self.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_are_those_that_are_named() {
        assert_eq!(seeds(None, None, 3), Ok(1..4));
        assert_eq!(seeds(Some("7"), Some("1..9"), 3), Ok(7..8));
        assert_eq!(seeds(None, Some("100..300"), 3), Ok(100..300));
        for bad in ["", "x", "-1", "1..2"] {
            let error = seeds(Some(bad), None, 3).unwrap_err();
            assert!(error.starts_with("SLABSPLAT_SEED is a whole number"), "{error}");
        }
        for bad in ["", "3", "3..", "5..5", "9..5"] {
            let error = seeds(None, Some(bad), 3).unwrap_err();
            assert!(error.starts_with("SLABSPLAT_SEEDS is two whole numbers"), "{error}");
        }
    }
}
