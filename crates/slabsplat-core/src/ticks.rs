//! Round numbers on scales, and how they are written.

/// Round numbers in a range, from its least to its greatest: 1, 2 or 5 times a power of ten apart, as near to
/// each other as a `n_steps`-th of the range allows. None if the range is empty or not finite.
pub fn round_ticks([lo, hi]: [f64; 2], n_steps: u32) -> Vec<f64> {
    let n_steps = n_steps.clamp(1, 100);
    let rough = (hi / f64::from(n_steps) - lo / f64::from(n_steps)).abs();
    if !rough.is_normal() || hi < lo {
        return Vec::new();
    }
    let step = round_number_from(rough);
    let first = (lo / step).ceil();
    let ticks = (0..=n_steps).map(|idx| (first + f64::from(idx)) * step);
    ticks.filter(|tick| lo <= *tick && *tick <= hi).collect()
}

/// The least of 1, 2 and 5 times a power of ten that is not less than a positive number.
fn round_number_from(least: f64) -> f64 {
    let power = 10.0_f64.powf(least.log10().floor());
    let rounds = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power);
    rounds.into_iter().find(|round| least <= *round).unwrap_or(least)
}

/// The greatest of 1, 2 and 5 times a power of ten that is not more than a positive number.
pub fn round_number_to(most: f64) -> f64 {
    let power = 10.0_f64.powf(most.log10().floor());
    let rounds = [5.0, 2.0, 1.0, 0.5].map(|factor| factor * power);
    rounds.into_iter().find(|round| *round <= most).unwrap_or(most)
}

/// A round number as it is written: what is left of a sum of binary fractions is none of it.
pub fn number_text(number: f64) -> String {
    let is_plain = number == 0.0 || (1e-4 < number.abs() && number.abs() < 1e7);
    if is_plain {
        let text = format!("{number:.6}");
        return text.trim_end_matches('0').trim_end_matches('.').to_owned();
    }
    let rounded: f64 = format!("{number:.5e}").parse().unwrap_or(number);
    format!("{rounded:e}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round() {
        let check = |range, expected: &[&str]| {
            let texts: Vec<String> = round_ticks(range, 5).into_iter().map(number_text).collect();
            assert_eq!(texts, expected, "{range:?}");
        };
        check([0.0, 255.0], &["0", "100", "200"]);
        check([-1024.0, 3071.0], &["-1000", "0", "1000", "2000", "3000"]);
        check([0.0, 1.0], &["0", "0.2", "0.4", "0.6", "0.8", "1"]);
        check([0.0, 2e-7], &["0", "5e-8", "1e-7", "1.5e-7", "2e-7"]);
        check([3.0, 3.0], &[]);
        check([4.0, 3.0], &[]);
        check([f64::NAN, 3.0], &[]);
        check([0.0, f64::INFINITY], &[]);
        assert_eq!(round_ticks([0.0, 100.0], 2), [0.0, 50.0, 100.0]);
        assert!(round_ticks([0.0, 1.0], u32::MAX).len() < 102);
    }

    #[test]
    fn round_numbers_are_at_most() {
        for (most, expected) in [(1.0, 1.0), (1.9, 1.0), (2.0, 2.0), (4.99, 2.0), (73.0, 50.0)] {
            assert_eq!(round_number_to(most), expected);
        }
        assert!((round_number_to(0.0031) - 0.002).abs() < 1e-15);
        for most in [1e-9, 1e-3, 1e3, 1e15] {
            assert!(
                (round_number_to(most) / most - 1.0).abs() < 1e-12
                    || round_number_to(most) == 0.5 * most
            );
        }
    }
}
