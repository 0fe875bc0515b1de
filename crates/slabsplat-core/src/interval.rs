//! Which numbers a setting may be, and how an error says so.

use std::fmt;

use thiserror::Error;

/// The numbers between two ends.
///
/// ```
/// use slabsplat_core::Interval;
///
/// let opacities = Interval::above(0.0).at_most(1.0);
/// assert!(opacities.contains(1.0) && !opacities.contains(0.0));
/// assert_eq!(opacities.to_string(), "above 0 and at most 1");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    low: End,
    high: End,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum End {
    Included(f64),
    Excluded(f64),
}

/// A number that its setting cannot be.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{name} must be {range}, not {}", Brief(*value))]
#[non_exhaustive]
pub struct OutOfRange {
    /// Which setting.
    pub name: &'static str,
    /// What it may be.
    pub range: Interval,
    /// What was given.
    pub value: f64,
}

/// A number as a person would write it: `1e12`, not thirteen digits.
struct Brief(f64);

impl Interval {
    /// All finite numbers greater than `low`.
    pub const fn above(low: f64) -> Self {
        Self { low: End::Excluded(low), high: End::Excluded(f64::INFINITY) }
    }

    /// All finite numbers from `low` on.
    pub const fn at_least(low: f64) -> Self {
        Self { low: End::Included(low), high: End::Excluded(f64::INFINITY) }
    }

    /// Those of them that are not greater than `high`.
    #[must_use]
    pub const fn at_most(self, high: f64) -> Self {
        Self { high: End::Included(high), ..self }
    }

    /// Those of them that are less than `high`.
    #[must_use]
    pub const fn below(self, high: f64) -> Self {
        Self { high: End::Excluded(high), ..self }
    }

    /// Whether the number is one of these; NaN never is.
    pub fn contains(&self, value: f64) -> bool {
        let is_above = match self.low {
            End::Included(low) => low <= value,
            End::Excluded(low) => low < value,
        };
        let is_below = match self.high {
            End::Included(high) => value <= high,
            End::Excluded(high) => value < high,
        };
        is_above && is_below
    }
}

impl fmt::Display for Interval {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.low, self.high) {
            (End::Included(low), End::Included(high)) => {
                return write!(f, "between {} and {}", Brief(low), Brief(high));
            }
            (End::Included(low), _) => write!(f, "at least {}", Brief(low))?,
            (End::Excluded(low), _) => write!(f, "above {}", Brief(low))?,
        }
        match self.high {
            End::Included(high) => write!(f, " and at most {}", Brief(high)),
            End::Excluded(f64::INFINITY) => f.write_str(" and finite"),
            End::Excluded(high) => write!(f, " and below {}", Brief(high)),
        }
    }
}

impl fmt::Display for Brief {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(value) = *self;
        let is_long = value != 0.0 && !(1e-4..1e6).contains(&value.abs());
        if is_long && value.is_finite() { write!(f, "{value:e}") } else { write!(f, "{value}") }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interval_ends() {
        let check = |interval: Interval, inside: &[f64], outside: &[f64]| {
            assert!(inside.iter().all(|&value| interval.contains(value)), "{interval}");
            assert!(!outside.iter().any(|&value| interval.contains(value)), "{interval}");
        };
        let never = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
        check(Interval::above(0.0), &[5e-324, f64::MAX], &[0.0, -1.0]);
        check(Interval::at_least(0.0), &[0.0, -0.0, 1e300], &[-5e-324]);
        check(Interval::above(0.0).at_most(1.0), &[1.0, 0.5], &[0.0, 1.0_f64.next_up()]);
        check(Interval::at_least(0.0).below(1.0), &[0.0, 1.0_f64.next_down()], &[1.0]);
        check(Interval::at_least(0.0), &[], &never);
    }

    #[test]
    fn interval_in_words() {
        let check = |range: Interval, value: f64, expected: &str| {
            assert_eq!(OutOfRange { name: "it", range, value }.to_string(), expected);
        };
        let widths = Interval::above(0.0).at_most(1e12);
        check(widths, -1.0, "it must be above 0 and at most 1e12, not -1");
        check(widths, 1e308, "it must be above 0 and at most 1e12, not 1e308");
        check(widths, f64::NAN, "it must be above 0 and at most 1e12, not NaN");
        let counts = Interval::at_least(2.0).at_most(4096.0);
        check(counts, 1.0, "it must be between 2 and 4096, not 1");
        check(Interval::at_least(0.0).below(1.0), 1.0, "it must be at least 0 and below 1, not 1");
        let finite = Interval::at_least(0.0);
        check(finite, f64::INFINITY, "it must be at least 0 and finite, not inf");
    }
}
