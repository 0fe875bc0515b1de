//! How large, and how exact, a picture may be while something moves, so that a frame takes no longer than its
//! budget.
//!
//! A larger tolerance is seen less than fewer pixels are: in small pictures of large volumes it takes a
//! quarter of the time or less, and changes them by 6 of 255 at most ("A preview" in [performance]). Of
//! small volumes it saves nothing, so that it is tried, and taken back if it does not help.
//!
//! Some of a frame's time is the voxels', and the same for any number of pixels. How much is learned whenever
//! sizes change: where nothing fits the budget, pixels that would save next to nothing are not given up.
//!
//! [performance]: https://github.com/slabsplat/slabsplat/blob/main/docs/performance.md

use slabsplat::{Finish, OpenScene, RenderSettings};

/// How many pixels of the view become one, along each side, from the finest on. What is coarser shows nothing
/// that anybody could steer by, and costs hardly less.
const DIVISORS: [f64; 8] = [1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0];

/// The larger tolerance. With more, volumes of 10⁹ voxels are drawn hardly faster; with 0.1 some take a
/// quarter of the time, and others, whose voxels are faint, still 0.86 of it, and with this a third.
const LARGER: f64 = 0.2;

/// What does not depend on pixels takes as long as this share of a whole view, as far as nobody knows better;
/// and at most.
const FIXED: f64 = 0.1;
const MAX_FIXED: f64 = 20.0;

/// Where nothing fits the budget, a frame may take so many times what the smallest takes.
const LONGER: f64 = 1.5;

/// After so many frames of a size its time is known: the first makes what those after it only use.
const SETTLED: usize = 3;

/// What is promised to fit has to fit with room to spare, or sizes go to and fro.
const HEADROOM: f64 = 0.9;

/// Share of a new measurement in what is expected.
const NEWEST: f64 = 0.4;

/// It helps if a frame takes no more than this share of what it took. Times of frames differ by a tenth or
/// two where other programs have the processor, too.
const HELPS: f64 = 0.75;

/// Where it did not help, it is tried again in pictures that are so many choices smaller.
const TRIED_AGAIN: usize = 2;

/// Chooses sizes and tolerances of moving pictures by what frames took.
#[derive(Clone, Debug)]
pub struct FrameBudget {
    budget_ms: f64,
    choice: usize,
    /// What a frame of the chosen size and tolerance takes, once one was seen.
    expected_ms: Option<f64>,
    /// How many were seen.
    n_seen: usize,
    /// What is the same for any number of pixels, as a share of the pixels of a view that take as long.
    fixed: f64,
    /// Another size, and what a frame of it has taken.
    other: Option<(usize, f64)>,
    /// What share of the time the larger tolerance takes, if that is in use.
    gain: Option<f64>,
    /// The tolerance that is tried, if one is.
    trial: Option<Trial>,
    /// The choice of size for which a larger tolerance was of no use.
    useless_at: Option<usize>,
}

/// A larger tolerance while it is not known whether it helps.
#[derive(Clone, Copy, Debug)]
struct Trial {
    /// What a frame took before.
    before_ms: f64,
    /// Whether a frame has come already: the first makes what those after it only use.
    has_begun: bool,
}

impl FrameBudget {
    /// Milliseconds of a frame, where nobody says otherwise: 30 frames a second.
    pub const USUAL_MS: f64 = 33.0;

    /// A budget of milliseconds a frame. It begins in the middle, as nobody knows what frames take.
    pub fn new(budget_ms: f64) -> Self {
        Self {
            budget_ms,
            choice: 3,
            expected_ms: None,
            n_seen: 0,
            fixed: FIXED,
            other: None,
            gain: None,
            trial: None,
            useless_at: None,
        }
    }

    /// The size of a moving picture in a view of that many pixels.
    pub fn size(&self, [width, height]: [u32; 2]) -> [u32; 2] {
        let divided = |side: u32| ((f64::from(side) / DIVISORS[self.choice]).round() as u32).max(1);
        [divided(width), divided(height)]
    }

    /// The tolerance of a moving picture of a scene with that tolerance, never less than it; of one that is
    /// exact at rest the usual one, at least.
    pub fn tolerance(&self, of_scene: f64) -> f64 {
        let usual = RenderSettings::default().tolerance;
        let least = if of_scene == 0.0 { usual } else { of_scene };
        if self.is_larger() { least.max(LARGER) } else { least }
    }

    /// A scene as it is shown while it moves, in a view of that many pixels: small, as exact as there is time
    /// for, and with nothing drawn on it.
    pub fn preview(&self, mut opened: OpenScene, view: [u32; 2]) -> OpenScene {
        let scene = &mut opened.scene;
        [scene.image.width, scene.image.height] = self.size(view);
        scene.settings.tolerance = self.tolerance(scene.settings.tolerance);
        let below = scene.finish.background_below;
        scene.finish =
            below.map_or_else(Finish::default, |color| Finish::default().background_below(color));
        opened
    }

    /// A moving frame of the chosen size and tolerance took that long.
    pub fn took(&mut self, ms: f64) {
        if let Some(trial) = self.trial {
            let next = Trial { has_begun: true, ..trial };
            self.trial = (!trial.has_begun).then_some(next);
            if trial.has_begun {
                self.judge(ms, trial.before_ms);
            }
            return;
        }
        let expected = self.expected_ms.map_or(ms, |before| before + NEWEST * (ms - before));
        self.expected_ms = Some(expected);
        self.n_seen += 1;
        if self.n_seen < SETTLED && expected < 2.0 * self.budget_ms {
            return;
        }
        self.learn(expected);
        if self.allowed_ms(expected) < expected {
            self.do_less(expected);
        } else if 0 < self.choice
            && self.predicted(expected, self.choice - 1) < self.promised_ms(expected)
        {
            self.choose(expected, self.choice - 1);
        } else if let Some(gain) = self.gain
            && self.choice == 0
            && expected / gain < HEADROOM * self.budget_ms
        {
            self.forget(None);
            self.gain = None;
        }
    }

    /// Whether the larger tolerance is in use, be it to try it.
    fn is_larger(&self) -> bool {
        self.gain.is_some() || self.trial.is_some()
    }

    fn may_try(&self) -> bool {
        let is_hopeless = self.useless_at.is_some_and(|at| self.choice < at + TRIED_AGAIN);
        self.gain.is_none() && !is_hopeless
    }

    fn do_less(&mut self, expected: f64) {
        if self.budget_ms < expected && self.may_try() {
            self.trial = Some(Trial { before_ms: expected, has_begun: false });
        } else {
            self.shrink(expected);
        }
    }

    /// Retains a larger tolerance if it has helped; the frame is smaller in any case if it has to be.
    fn judge(&mut self, ms: f64, before_ms: f64) {
        let gain = ms / before_ms;
        if gain <= HELPS {
            self.gain = Some(gain);
            // Nothing is known of other sizes with that tolerance.
            self.forget(None);
        } else {
            self.useless_at = Some(self.choice);
            self.shrink(before_ms);
        }
    }

    fn shrink(&mut self, expected: f64) {
        let last = DIVISORS.len() - 1;
        let allowed = self.allowed_ms(expected);
        let fits = |&choice: &usize| self.predicted(expected, choice) < allowed;
        let choice = (self.choice..last).find(fits).unwrap_or(last);
        self.choose(expected, choice);
    }

    fn choose(&mut self, expected: f64, choice: usize) {
        if choice != self.choice {
            self.forget(Some((self.choice, expected)));
            self.choice = choice;
        }
    }

    /// What frames take is to be seen.
    fn forget(&mut self, other: Option<(usize, f64)>) {
        (self.expected_ms, self.n_seen, self.other) = (None, 0, other);
    }

    /// How much is the same for any number of pixels, now that two sizes were seen.
    fn learn(&mut self, expected: f64) {
        let Some((other, ms)) = self.other.take() else { return };
        let (pixels, others) = (share_of_view(self.choice), share_of_view(other));
        // From times that are as the sums of what is fixed and pixels.
        let ratio = ms / expected;
        let fixed = (others - ratio * pixels) / (ratio - 1.0);
        let grows = (others - pixels) * (ms - expected) > 0.0;
        self.fixed = if grows { fixed.clamp(0.0, MAX_FIXED) } else { MAX_FIXED };
    }

    fn predicted(&self, expected: f64, choice: usize) -> f64 {
        let time = |choice: usize| self.fixed + share_of_view(choice);
        expected * time(choice) / time(self.choice)
    }

    /// What a frame may take: the budget, and if nothing fits that hardly more than the smallest.
    fn allowed_ms(&self, expected: f64) -> f64 {
        let least = self.predicted(expected, DIVISORS.len() - 1);
        if least < self.budget_ms { self.budget_ms } else { LONGER * least }
    }

    fn promised_ms(&self, expected: f64) -> f64 {
        HEADROOM * self.allowed_ms(expected)
    }
}

/// How many of a view's pixels a picture has.
fn share_of_view(choice: usize) -> f64 {
    DIVISORS[choice].powi(-2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::Urgency;
    use crate::state::{Document, Pacing};
    use slabsplat::Renderer;
    use slabsplat::io::{SceneFile, VolumeSource};

    const VIEW: [u32; 2] = [1280, 800];

    /// Sizes and tolerances that are chosen in the end, and what frames then take, if a frame takes `ms` of
    /// so many pixels and with such a tolerance.
    fn settled(ms: impl Fn(f64, f64) -> f64) -> (Vec<([u32; 2], f64)>, f64) {
        let mut budget = FrameBudget::new(FrameBudget::USUAL_MS);
        let mut chosen = Vec::new();
        let mut last = 0.0;
        for _ in 0..80 {
            let [width, height] = budget.size(VIEW);
            let tolerance = budget.tolerance(0.05);
            last = ms(f64::from(width * height), tolerance);
            budget.took(last);
            chosen.push(([width, height], tolerance));
        }
        (chosen.split_off(60), last)
    }

    /// The same of a volume that is drawn no faster with a larger tolerance.
    fn settled_small(fixed_ms: f64, ms_per_pixel: f64) -> (Vec<([u32; 2], f64)>, f64) {
        settled(|pixels, _| fixed_ms + ms_per_pixel * pixels)
    }

    fn is_steady(chosen: &[([u32; 2], f64)]) -> bool {
        chosen.windows(2).all(|pair| pair[0] == pair[1])
    }

    #[test]
    fn frames_fit_their_budget_and_sizes_stay() {
        for fixed_ms in [0.0, 5.0, 15.0] {
            for ms_per_pixel in [1e-6, 1e-5, 6e-5, 2e-4, 4e-4] {
                let (chosen, ms) = settled_small(fixed_ms, ms_per_pixel);
                assert!(ms <= FrameBudget::USUAL_MS, "{ms} of {fixed_ms} and {ms_per_pixel}");
                assert!(is_steady(&chosen), "to and fro: {chosen:?}");
                assert_eq!(chosen[0].1, 0.05, "a tolerance that does not help is not taken");
            }
        }
        assert_eq!(settled_small(1.0, 1e-6).0[0].0, VIEW, "what is fast is whole");
    }

    #[test]
    fn what_never_fits_gives_up_pixels_that_cost_much() {
        let (chosen, ms) = settled_small(40.0, 4e-4);
        assert!(is_steady(&chosen) && chosen[0].0 == [320, 200], "{chosen:?}");
        // Those of a view take a tenth of the time.
        let (chosen, _) = settled_small(500.0, 5e-5);
        assert!(is_steady(&chosen) && chosen[0].0 == VIEW, "{chosen:?}");
        let (chosen, ms_between) = settled_small(44.0, 2.3e-5);
        assert!(is_steady(&chosen) && 256 < chosen[0].0[0], "{chosen:?}");
        assert!(ms < LONGER * 57.0 && ms_between < LONGER * 45.0, "{ms}, {ms_between}");
        assert_eq!(FrameBudget::new(1.0).size([1, 1]), [1, 1]);
    }

    /// As of 10⁹ voxels in docs/performance.md, where most of the time does not depend on pixels.
    #[test]
    fn a_larger_tolerance_goes_before_fewer_pixels() {
        let ms = |pixels: f64, tolerance: f64| {
            let of_voxels = if tolerance < 0.1 {
                100.0
            } else if tolerance < 0.2 {
                24.0
            } else {
                15.0
            };
            of_voxels + 5e-5 * pixels
        };
        let (chosen, last) = settled(ms);
        let (size, tolerance) = chosen[0];
        assert!(is_steady(&chosen), "{chosen:?}");
        assert!(LARGER <= tolerance && last <= FrameBudget::USUAL_MS, "{tolerance}, {last} ms");
        assert!(400 < size[0], "{size:?}");
        let (_, too_long) = settled(|pixels, _| ms(pixels, 0.05));
        assert!(FrameBudget::USUAL_MS < too_long);
    }

    #[test]
    fn a_tolerance_is_taken_back_where_there_is_time() {
        let mut budget = FrameBudget::new(FrameBudget::USUAL_MS);
        let mut draw = |ms: &dyn Fn(f64, f64) -> f64| {
            for _ in 0..80 {
                let [width, height] = budget.size(VIEW);
                budget.took(ms(f64::from(width * height), budget.tolerance(0.0)));
            }
            (budget.size(VIEW), budget.tolerance(0.0))
        };
        let (_, tolerance) = draw(&|_, tolerance| 2.0 / tolerance);
        assert!(LARGER <= tolerance);
        // Another transfer function, of which little is visible.
        assert_eq!(draw(&|_, tolerance| 0.1 / tolerance), (VIEW, 0.05));
    }

    #[test]
    fn a_preview_is_never_more_exact_than_its_scene() {
        let mut budget = FrameBudget::new(FrameBudget::USUAL_MS);
        assert_eq!((budget.tolerance(0.0), budget.tolerance(0.01)), (0.05, 0.01));
        while !budget.is_larger() {
            budget.took(1e3);
        }
        assert_eq!((budget.tolerance(0.0), budget.tolerance(0.3)), (0.2, 0.3));
    }

    /// Whatever previews are, at rest it is the scene: to the last bit, by the renderer that drew them.
    #[test]
    fn a_picture_at_rest_is_exactly_the_scene() {
        let source = VolumeSource::Builtin { name: "neuron".to_owned(), size: Some(24) };
        let mut document =
            Document::open(&SceneFile::of_volume(source), String::new(), [48, 36]).unwrap();
        document.change("tolerance", |state| state.opened.scene.settings.tolerance = 0.0);
        let mut budget = FrameBudget::new(FrameBudget::USUAL_MS);
        let (mut pacing, mut renderer) =
            (Pacing::default(), Renderer::open("cpu", |_| {}).unwrap());
        let mut drawn = Vec::new();
        for step in 0..20 {
            let is_held = step < 15;
            if is_held {
                document.move_camera(|camera| camera.orbited(0.1));
            }
            for asked in pacing.step(document.revision(), 1, f64::from(step), is_held) {
                let scene = document.pane(0);
                let opened = match asked.urgency {
                    Urgency::AtRest => scene,
                    Urgency::Moving => budget.preview(scene, [48, 36]),
                };
                let picture = renderer.picture(&opened.scene, opened.acquisition).unwrap();
                pacing.came(0, asked.number);
                budget.took(90.0);
                drawn.push((asked.urgency, opened.scene.settings.tolerance, picture.frame.image));
            }
        }
        let (urgency, tolerance, image) = drawn.pop().unwrap();
        assert_eq!((urgency, tolerance), (Urgency::AtRest, 0.0));
        assert!(drawn.iter().any(|(_, tolerance, _)| LARGER <= *tolerance), "previews had less");
        let shown = document.pane(0);
        let mut alone = Renderer::open("cpu", |_| {}).unwrap();
        assert_eq!(image, alone.picture(&shown.scene, shown.acquisition).unwrap().frame.image);
    }
}
