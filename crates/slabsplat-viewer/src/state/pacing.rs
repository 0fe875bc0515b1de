//! Which picture is asked for when: small ones while something moves, the whole one when all is at rest.

use crate::frames::Urgency;

/// Seconds without a change after which all is at rest.
const REST_S: f64 = 0.12;

/// Asks for pictures of what changes.
#[derive(Clone, Debug, Default)]
pub struct Pacing {
    revision: u64,
    changed_at: f64,
    number: u64,
    panes: Vec<Pane>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Pane {
    /// The request that nothing has come of.
    pending: Option<Asked>,
    /// What was asked for last.
    last: Option<(u64, Urgency)>,
}

/// A picture that is to be asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Asked {
    /// In which pane.
    pub pane: usize,
    /// A number that no request before had.
    pub number: u64,
    /// How soon.
    pub urgency: Urgency,
}

impl Pacing {
    /// What is shown has that revision now, and so many panes. `now` is in seconds, of any clock; `is_held`
    /// says whether something is dragged. Returns the pictures to be asked for.
    pub fn step(&mut self, revision: u64, n_panes: usize, now: f64, is_held: bool) -> Vec<Asked> {
        if revision != self.revision {
            (self.revision, self.changed_at) = (revision, now);
        }
        self.panes.resize(n_panes, Pane::default());
        let is_at_rest = self.is_at_rest(now, is_held);
        let mut asked = Vec::new();
        for (idx, pane) in self.panes.iter_mut().enumerate() {
            // Whoever opens something sees a small picture of it first.
            let is_whole = is_at_rest && pane.last.is_some();
            let urgency = if is_whole { Urgency::AtRest } else { Urgency::Moving };
            let is_shown = pane.last.is_some_and(|(of, how)| {
                of == revision && (how == urgency || how == Urgency::AtRest)
            });
            let waits = pane.pending.is_some_and(|pending| {
                // A picture at rest is given up for what moves.
                pending.urgency == Urgency::Moving
            });
            if is_shown || waits {
                continue;
            }
            self.number += 1;
            let request = Asked { pane: idx, number: self.number, urgency };
            pane.pending = Some(request);
            pane.last = Some((revision, urgency));
            asked.push(request);
        }
        asked
    }

    /// What was asked for under that number has come, or will not. Whether it is what is waited for: what
    /// was asked before is not shown any more.
    pub fn came(&mut self, pane: usize, number: u64) -> bool {
        let Some(pane) = self.panes.get_mut(pane) else { return false };
        let is_newest = pane.pending.is_some_and(|pending| pending.number == number);
        if is_newest {
            pane.pending = None;
        }
        is_newest
    }

    /// All is asked for once more, as by a source that has never been asked.
    pub fn forget(&mut self) {
        self.panes.clear();
    }

    /// Whether nothing is waited for.
    pub fn is_done(&self) -> bool {
        self.panes.iter().all(|pane| pane.pending.is_none())
    }

    /// Whether all panes show the whole picture of what is now, and nothing is waited for.
    pub fn is_whole(&self) -> bool {
        let whole = Some((self.revision, Urgency::AtRest));
        let is_whole = |pane: &Pane| pane.pending.is_none() && pane.last == whole;
        !self.panes.is_empty() && self.panes.iter().all(is_whole)
    }

    /// Whether what is shown is no more than a preview, or waited for.
    pub fn is_moving(&self, now: f64, is_held: bool) -> bool {
        !self.is_at_rest(now, is_held)
    }

    /// Seconds until there may be something to be asked for though nothing happens.
    pub fn wake_in(&self, now: f64) -> Option<f64> {
        let has_preview = |pane: &Pane| pane.last.is_some_and(|(_, how)| how == Urgency::Moving);
        let left = self.changed_at + REST_S - now;
        self.panes.iter().any(has_preview).then_some(left.max(0.001))
    }

    fn is_at_rest(&self, now: f64, is_held: bool) -> bool {
        !is_held && REST_S <= now - self.changed_at
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One that has shown all of a picture.
    fn at_rest(n_panes: usize) -> Pacing {
        let mut pacing = Pacing::default();
        for now in [0.0, 1.0] {
            for Asked { pane, number, .. } in pacing.step(0, n_panes, now, false) {
                assert!(pacing.came(pane, number));
            }
        }
        pacing
    }

    #[test]
    fn what_is_opened_is_drawn_at_once_and_then_whole() {
        let mut pacing = Pacing::default();
        let asked = pacing.step(1, 1, 5.0, false);
        assert_eq!(asked, [Asked { pane: 0, number: 1, urgency: Urgency::Moving }]);
        assert_eq!(pacing.step(1, 1, 5.1, false), []);
        assert!(!pacing.is_done() && pacing.came(0, 1) && pacing.is_done());
        assert!(!pacing.is_whole(), "there is a small one");
        let asked = pacing.step(1, 1, 6.0, false);
        assert_eq!(asked, [Asked { pane: 0, number: 2, urgency: Urgency::AtRest }]);
        assert!(!pacing.is_whole() && pacing.came(0, 2) && pacing.is_whole());
        assert_eq!(pacing.step(1, 1, 9.0, false), []);
    }

    #[test]
    fn what_moves_is_drawn_frame_by_frame_and_then_whole() {
        let mut pacing = at_rest(1);
        let first = pacing.step(1, 1, 1.0, true);
        assert_eq!(first[0].urgency, Urgency::Moving);
        for revision in 2..20 {
            assert_eq!(pacing.step(revision, 1, 1.01, true), [], "one at a time");
        }
        assert!(pacing.came(0, first[0].number));
        let second = pacing.step(20, 1, 1.02, true);
        assert_eq!(second.len(), 1);
        assert!(pacing.came(0, second[0].number));
        assert_eq!(pacing.step(20, 1, 1.03, false), [], "it may go on");
        assert!(pacing.wake_in(1.03).is_some_and(|seconds| seconds < REST_S));
        let whole = pacing.step(20, 1, 1.02 + REST_S, false);
        assert_eq!(whole[0].urgency, Urgency::AtRest);
        assert_eq!(pacing.wake_in(2.0), None);
        assert_eq!(pacing.step(20, 1, 9.0, false), []);
    }

    #[test]
    fn whole_pictures_are_given_up_for_what_moves() {
        let mut pacing = at_rest(2);
        let changed = pacing.step(1, 2, 2.0, false);
        changed.iter().for_each(|asked| assert!(pacing.came(asked.pane, asked.number)));
        let whole = pacing.step(1, 2, 3.0, false);
        let moving = pacing.step(2, 2, 3.1, false);
        assert_eq!((whole.len(), moving.len()), (2, 2));
        assert!(!pacing.came(0, whole[0].number), "that one is out of date");
        assert!(pacing.came(0, moving[0].number) && pacing.came(1, moving[1].number));
        assert!(!pacing.came(7, 3));
    }
}
