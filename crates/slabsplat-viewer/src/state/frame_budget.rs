//! How large a picture may be while something moves, so that a frame takes no longer than its budget.

/// How many pixels of the view become one, along each side, from the finest on. What is coarser shows nothing
/// that anybody could steer by, and costs hardly less.
const DIVISORS: [f64; 8] = [1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0];

/// Time grows with pixels by a power below 1, as some of it does not depend on them.
const GROWTH: f64 = 0.7;

/// What is promised to fit has to fit with room to spare, or sizes go to and fro.
const HEADROOM: f64 = 0.8;

/// Share of a new measurement in what is expected.
const NEWEST: f64 = 0.4;

/// Chooses sizes of moving pictures by what frames took.
#[derive(Clone, Debug)]
pub struct FrameBudget {
    budget_ms: f64,
    choice: usize,
    /// What a frame of the chosen size takes, once one was seen.
    expected_ms: Option<f64>,
}

impl FrameBudget {
    /// Milliseconds of a frame, where nobody says otherwise: 30 frames a second.
    pub const USUAL_MS: f64 = 33.0;

    /// A budget of milliseconds a frame. It begins in the middle, as nobody knows what frames take.
    pub fn new(budget_ms: f64) -> Self {
        Self { budget_ms, choice: 3, expected_ms: None }
    }

    /// The size of a moving picture in a view of that many pixels.
    pub fn size(&self, [width, height]: [u32; 2]) -> [u32; 2] {
        let divided = |side: u32| ((f64::from(side) / DIVISORS[self.choice]).round() as u32).max(1);
        [divided(width), divided(height)]
    }

    /// A moving frame of the chosen size took that long.
    pub fn took(&mut self, ms: f64) {
        let expected = self.expected_ms.map_or(ms, |before| before + NEWEST * (ms - before));
        self.expected_ms = Some(expected);
        let predicted = |choice: usize| {
            expected * (DIVISORS[self.choice] / DIVISORS[choice]).powf(2.0 * GROWTH)
        };
        let last = DIVISORS.len() - 1;
        let choice = if self.budget_ms < expected {
            let fits = |&choice: &usize| predicted(choice) < self.budget_ms;
            (self.choice..last).find(fits).unwrap_or(last)
        } else if 0 < self.choice && predicted(self.choice - 1) < HEADROOM * self.budget_ms {
            self.choice - 1
        } else {
            self.choice
        };
        if choice != self.choice {
            self.expected_ms = Some(predicted(choice));
            self.choice = choice;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sizes that are chosen for frames that take so long a pixel, beside something that all take.
    fn settled(fixed_ms: f64, ms_per_pixel: f64) -> (Vec<[u32; 2]>, f64) {
        let view = [1280, 800];
        let mut budget = FrameBudget::new(FrameBudget::USUAL_MS);
        let mut sizes = Vec::new();
        let mut ms = 0.0;
        for _ in 0..60 {
            let [width, height] = budget.size(view);
            ms = fixed_ms + ms_per_pixel * f64::from(width * height);
            budget.took(ms);
            sizes.push([width, height]);
        }
        (sizes.split_off(40), ms)
    }

    #[test]
    fn frames_fit_their_budget_and_sizes_stay() {
        for fixed_ms in [0.0, 5.0, 15.0] {
            for ms_per_pixel in [1e-6, 1e-5, 6e-5, 2e-4, 4e-4] {
                let (sizes, ms) = settled(fixed_ms, ms_per_pixel);
                assert!(ms <= FrameBudget::USUAL_MS, "{ms} of {fixed_ms} and {ms_per_pixel}");
                assert!(sizes.windows(2).all(|pair| pair[0] == pair[1]), "to and fro: {sizes:?}");
            }
        }
        assert_eq!(settled(1.0, 1e-6).0[0], [1280, 800], "what is fast is whole");
    }

    #[test]
    fn what_never_fits_is_as_small_as_it_gets() {
        assert_eq!(settled(500.0, 1e-4).0[0], [256, 160]);
        assert_eq!(FrameBudget::new(1.0).size([1, 1]), [1, 1]);
    }
}
