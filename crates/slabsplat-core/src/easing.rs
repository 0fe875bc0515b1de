//! How time passes between two key frames, by the names of CSS
//! (<https://www.w3.org/TR/css-easing-1/#easing-functions>).

use crate::choices::named;

/// How fast a change begins and ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Easing {
    /// Evenly.
    #[default]
    Linear,
    /// It begins slowly.
    EaseIn,
    /// It ends slowly.
    EaseOut,
    /// It begins and ends slowly.
    EaseInOut,
}

named!(Easing {
    Linear = "linear",
    EaseIn = "ease-in",
    EaseOut = "ease-out",
    EaseInOut = "ease-in-out",
});

impl Easing {
    /// The part of the change that is behind when a part of the time is, both 0 … 1.
    ///
    /// ```
    /// use slabsplat_core::Easing;
    ///
    /// assert_eq!(Easing::Linear.ease(0.3), 0.3);
    /// assert_eq!(Easing::EaseInOut.ease(0.5), 0.5);
    /// assert!(Easing::EaseIn.ease(0.1) < 0.03);
    /// ```
    pub fn ease(self, time: f64) -> f64 {
        let time = time.clamp(0.0, 1.0);
        let [x1, x2] = match self {
            Self::Linear => return time,
            Self::EaseIn => [0.42, 1.0],
            Self::EaseOut => [0.0, 0.58],
            Self::EaseInOut => [0.42, 0.58],
        };
        bezier([0.0, 1.0], parameter_of(time, [x1, x2]))
    }
}

/// One coordinate of the cubic curve from 0 to 1 with these two control points.
fn bezier([a, b]: [f64; 2], t: f64) -> f64 {
    let u = 1.0 - t;
    3.0 * u * u * t * a + 3.0 * u * t * t * b + t * t * t
}

/// Where the curve has that x, which rises along it.
fn parameter_of(x: f64, controls: [f64; 2]) -> f64 {
    let [mut low, mut high] = [0.0, 1.0];
    // Halved until nothing lies between two numbers.
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || high <= middle {
            return middle;
        }
        let x_there = bezier(controls, middle);
        if x_there == x {
            return middle;
        }
        if x_there < x { low = middle } else { high = middle }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn easing_goes_from_0_to_1_and_never_back() {
        for easing in Easing::ALL {
            assert_eq!([0.0, 1.0].map(|t| easing.ease(t)), [0.0, 1.0], "{easing}");
            assert_eq!([-1.0, 2.0].map(|t| easing.ease(t)), [0.0, 1.0], "{easing}");
            let steps = (0..=100).map(|n| easing.ease(f64::from(n) / 100.0)).collect::<Vec<_>>();
            assert!(steps.windows(2).all(|pair| pair[0] < pair[1]), "{easing}");
        }
    }

    /// Values of `cubic-bezier` that browsers give, to four digits.
    #[test]
    fn easing_is_that_of_css() {
        let check = |easing: Easing, at: f64, expected: f64| {
            let value = easing.ease(at);
            assert!((value - expected).abs() < 1e-4, "{easing} at {at}: {value}");
        };
        check(Easing::EaseIn, 0.5, 0.3154);
        check(Easing::EaseOut, 0.5, 0.6846);
        check(Easing::EaseInOut, 0.25, 0.1292);
        check(Easing::EaseInOut, 0.75, 0.8708);
    }
}
