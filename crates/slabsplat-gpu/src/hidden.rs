//! What a frame leaves out since it was hidden in the frame before.
//!
//! Tiles of the device remember in which sheet they were saturated (`shaders/tile_limits.wgsl`); the host
//! knows whether the next frame is like the last one, and by how much all sheets have moved. What is left out
//! is a guess that the device checks, so that a frame may go out twice: where that happens, the frames after
//! it are drawn without a guess, twice as many each time.

use crate::job::Job;
use crate::params::{Frame, Layer};

/// Sheets that are tossed behind those in which tiles were saturated. A surface that a camera turns by a
/// degree or two moves by a few, beside what the tiles around a tile allow for.
const MARGIN: i32 = 8;

/// Frames without a guess after one that was wrong, at most.
const MOST_FRAMES_WITHOUT: u32 = 64;

/// What is known of the last frame, and how good guesses have been.
#[derive(Debug, Default)]
pub(crate) struct Hidden {
    last: Option<Last>,
    /// How many frames are still to be drawn without a guess, and how many after the next wrong one.
    n_without: u32,
    n_without_next: u32,
}

/// The frame whose tiles the device has.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Last {
    image_size: [u32; 2],
    method: u32,
    /// The sheet in which the centre of the first layer is.
    center: i32,
}

impl Last {
    /// `None` if it is not sheets alone that saturate tiles: `every-sample` has none, and meshes end rays in
    /// between.
    fn of(job: &Job) -> Option<Self> {
        let Job { frame, params, surfaces: None, depth_sort: None, .. } = job else { return None };
        let &Frame { image_size, method, .. } = frame;
        Some(Self { image_size, method, center: sheet_of_center(frame, params.first()?) })
    }
}

/// Slices are numbered along an axis of the volume, and stay where they are.
fn sheet_of_center(frame: &Frame, layer: &Layer) -> i32 {
    let slab = (layer.depth[3] / layer.slab_thickness).round();
    if slab.is_finite() { (slab as i32).saturating_sub(frame.first_slab) } else { 0 }
}

impl Hidden {
    /// What [`Job::sheets_behind`] should be of the frame after the last one.
    pub(crate) fn sheets_behind(&mut self, job: &Job) -> Option<i32> {
        self.behind(Last::of(job)?)
    }

    fn behind(&mut self, now: Last) -> Option<i32> {
        let last = self.last?;
        if self.n_without > 0 {
            self.n_without -= 1;
            return None;
        }
        let is_alike = last.image_size == now.image_size && last.method == now.method;
        is_alike.then(|| now.center.saturating_sub(last.center).saturating_add(MARGIN))
    }

    /// The frame that the device is given, if it is.
    pub(crate) fn follow(&mut self, job: Option<&Job>) {
        self.last = job.and_then(Last::of);
    }

    /// What a frame left out was not all hidden.
    pub(crate) fn was_wrong(&mut self) {
        self.n_without = self.n_without_next;
        self.n_without_next = (2 * self.n_without_next).clamp(1, MOST_FRAMES_WITHOUT);
    }

    /// What a frame left out was hidden.
    pub(crate) fn was_right(&mut self) {
        self.n_without_next /= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAST: Last = Last { image_size: [64; 2], method: 0, center: 20 };

    /// What a frame is told that follows `LAST` and has its centre in a sheet.
    fn told(hidden: &mut Hidden, now: Last) -> Option<i32> {
        hidden.last = Some(LAST);
        hidden.behind(now)
    }

    #[test]
    fn frames_that_are_alike_move_with_their_centre() {
        let mut hidden = Hidden::default();
        assert_eq!(hidden.behind(LAST), None, "there was no frame before");
        assert_eq!(told(&mut hidden, LAST), Some(MARGIN));
        assert_eq!(told(&mut hidden, Last { center: 13, ..LAST }), Some(MARGIN - 7));
        assert_eq!(
            told(&mut hidden, Last { center: i32::MAX, ..LAST }),
            Some(i32::MAX - 20 + MARGIN)
        );
        assert_eq!(told(&mut hidden, Last { image_size: [64, 65], ..LAST }), None);
        assert_eq!(told(&mut hidden, Last { method: 1, ..LAST }), None);
    }

    #[test]
    fn wrong_guesses_are_made_ever_more_rarely() {
        let mut hidden = Hidden::default();
        let mut without = Vec::new();
        for _ in 0..9 {
            hidden.was_wrong();
            let n = (0..).find(|_| told(&mut hidden, LAST).is_some());
            without.push(n.expect("there is one more guess"));
        }
        assert_eq!(without, [0, 1, 2, 4, 8, 16, 32, 64, 64]);
        hidden.was_right();
        hidden.was_right();
        hidden.was_wrong();
        assert_eq!((0..).find(|_| told(&mut hidden, LAST).is_some()), Some(16));
    }
}
