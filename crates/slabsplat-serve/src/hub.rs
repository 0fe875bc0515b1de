//! Whose turn it is: what viewers ask for and have not got, on one side of a thread that draws.
//!
//! A viewer has a place for one request a pane, and for two pictures, of different panes: one may be drawn
//! while the other is encoded. While pictures wait to be sent to it, nothing is drawn for it, so that whoever
//! does not read costs no more than that, and gets the newest when it does. Viewers have their turns one
//! after the other, and so have a viewer's panes.

use crate::message::{Ask, Encoded, Urgency, note};
use slabsplat::FrameHandle;
use std::collections::{BTreeMap, VecDeque};
use std::ops::Bound::{Excluded, Unbounded};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use tokio::sync::Notify;

/// Names a viewer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct ViewerId(u64);

/// What viewers, and the thread that draws, share.
#[derive(Debug, Default)]
pub(crate) struct Hub {
    state: Mutex<State>,
    has_changed: Condvar,
}

#[derive(Debug, Default)]
struct State {
    viewers: BTreeMap<u64, Viewer>,
    /// Who came last, and who had the last turn.
    newest: u64,
    served: u64,
    under_way: Option<UnderWay>,
    /// What everybody should know.
    notes: Vec<String>,
    ends: bool,
}

#[derive(Debug)]
struct UnderWay {
    viewer: u64,
    pane: usize,
    urgency: Urgency,
    frame: FrameHandle,
}

#[derive(Debug, Default)]
struct Viewer {
    /// The newest request of each pane, in the order in which panes have their turns.
    waiting: Vec<Ask>,
    /// How many requests have had their turn, of which nothing has come yet.
    n_begun: usize,
    /// Panes and messages.
    pictures: VecDeque<(usize, Vec<u8>)>,
    texts: VecDeque<String>,
    end: Option<End>,
    wake: Arc<Notify>,
}

/// Why a viewer's connection is closed from here: a code of WebSockets, and a sentence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct End {
    pub(crate) code: u16,
    pub(crate) why: &'static str,
}

/// What is sent to a viewer.
#[derive(Debug, PartialEq)]
pub(crate) enum Outgoing {
    Text(String),
    Picture(Vec<u8>),
    End(End),
}

/// A request whose turn it is.
#[derive(Debug)]
pub(crate) struct Turn {
    pub(crate) viewer: ViewerId,
    pub(crate) ask: Ask,
    pub(crate) frame: FrameHandle,
}

/// Pictures of a viewer that are drawn, encoded or wait to be sent.
const MAX_PICTURES: usize = 2;

/// Texts that wait for a viewer; of more, the oldest are dropped.
const MAX_TEXTS: usize = 16;

/// Notes that are retained for who comes later.
const MAX_NOTES: usize = 4;

impl Hub {
    /// A viewer has come. The other value wakes whoever sends to it.
    pub(crate) fn join(&self) -> (ViewerId, Arc<Notify>) {
        let mut state = self.locked();
        state.newest += 1;
        let id = state.newest;
        let viewer = Viewer { texts: state.notes.iter().cloned().collect(), ..Viewer::default() };
        let wake = viewer.wake.clone();
        state.viewers.insert(id, viewer);
        (ViewerId(id), wake)
    }

    /// A viewer has gone; nothing is drawn for it any more.
    pub(crate) fn leave(&self, ViewerId(id): ViewerId) {
        let mut state = self.locked();
        state.viewers.remove(&id);
        if let Some(under_way) = state.under_way.as_ref().filter(|it| it.viewer == id) {
            under_way.frame.cancel();
        }
    }

    /// Asks for a picture.
    pub(crate) fn ask(&self, ViewerId(id): ViewerId, ask: Ask) {
        let mut state = self.locked();
        if let Some(under_way) = &state.under_way
            && under_way.viewer == id
            && under_way.gives_way_to(&ask)
        {
            under_way.frame.cancel();
        }
        if let Some(viewer) = state.viewers.get_mut(&id) {
            viewer.ask(ask);
        }
        drop(state);
        self.has_changed.notify_one();
    }

    /// Tells a viewer something.
    pub(crate) fn tell(&self, ViewerId(id): ViewerId, text: String) {
        if let Some(viewer) = self.locked().viewers.get_mut(&id) {
            viewer.tell(text);
        }
    }

    /// Tells all viewers something, and who comes later.
    pub(crate) fn tell_all(&self, what: &str) {
        let mut state = self.locked();
        let text = note(what);
        state.viewers.values_mut().for_each(|viewer| viewer.tell(text.clone()));
        if state.notes.len() < MAX_NOTES && !state.notes.contains(&text) {
            state.notes.push(text);
        }
    }

    /// Closes a viewer's connection once what it is sent at the moment is sent.
    pub(crate) fn close(&self, ViewerId(id): ViewerId, end: End) {
        if let Some(viewer) = self.locked().viewers.get_mut(&id) {
            viewer.close(end);
        }
    }

    /// What is to be sent to a viewer next. If it is a picture, another may be drawn.
    pub(crate) fn take(&self, ViewerId(id): ViewerId) -> Option<Outgoing> {
        let mut state = self.locked();
        let viewer = state.viewers.get_mut(&id)?;
        if let Some(end) = viewer.end {
            return Some(Outgoing::End(end));
        }
        if let Some(text) = viewer.texts.pop_front() {
            return Some(Outgoing::Text(text));
        }
        let (_, picture) = viewer.pictures.pop_front()?;
        drop(state);
        self.has_changed.notify_one();
        Some(Outgoing::Picture(picture))
    }

    /// The next request, as soon as there is one; `None` at the end.
    pub(crate) fn next(&self) -> Option<Turn> {
        let mut state = self.locked();
        loop {
            if state.ends {
                return None;
            }
            if let Some(turn) = state.next() {
                return Some(turn);
            }
            state = self.has_changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// A request was drawn, and can no longer be given up.
    pub(crate) fn drawn(&self) {
        self.locked().under_way = None;
    }

    /// What came of a request that was drawn.
    pub(crate) fn done(&self, turn: &Turn, result: &Result<Encoded, String>) {
        let message = result.as_ref().map(|encoded| encoded.message(&turn.ask));
        let mut state = self.locked();
        let Some(viewer) = state.viewers.get_mut(&turn.viewer.0) else { return };
        viewer.n_begun -= 1;
        match message {
            Ok(message) => viewer.show(turn.ask.pane, message),
            Err(why) => viewer.tell(turn.ask.failed(why)),
        }
        drop(state);
        self.has_changed.notify_one();
    }

    /// A request was given up; unless there is a newer one for its pane, it has another turn.
    pub(crate) fn put_off(&self, turn: Turn) {
        let mut state = self.locked();
        state.under_way = None;
        let Some(viewer) = state.viewers.get_mut(&turn.viewer.0) else { return };
        viewer.n_begun -= 1;
        if !viewer.waiting.iter().any(|waiting| waiting.pane == turn.ask.pane) {
            viewer.waiting.push(turn.ask);
        }
    }

    /// Ends it: nothing more is drawn, and viewers are told to go.
    pub(crate) fn end(&self, end: End) {
        let mut state = self.locked();
        state.ends = true;
        state.viewers.values_mut().for_each(|viewer| viewer.close(end));
        if let Some(under_way) = &state.under_way {
            under_way.frame.cancel();
        }
        drop(state);
        self.has_changed.notify_one();
    }

    /// Whether nobody is there.
    pub(crate) fn is_empty(&self) -> bool {
        self.locked().viewers.is_empty()
    }

    fn locked(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    fn next(&mut self) -> Option<Turn> {
        let after = self.viewers.range((Excluded(self.served), Unbounded));
        let mut in_order = after.chain(self.viewers.range(..=self.served));
        let id = in_order.find_map(|(id, viewer)| viewer.is_ready().then_some(*id))?;
        let viewer = self.viewers.get_mut(&id)?;
        viewer.n_begun += 1;
        let ask = viewer.waiting.remove(0);
        let frame = FrameHandle::new();
        let (pane, urgency) = (ask.pane, ask.urgency);
        self.under_way = Some(UnderWay { viewer: id, pane, urgency, frame: frame.clone() });
        self.served = id;
        Some(Turn { viewer: ViewerId(id), ask, frame })
    }
}

impl UnderWay {
    fn gives_way_to(&self, ask: &Ask) -> bool {
        self.urgency == Urgency::AtRest && (self.pane == ask.pane || ask.urgency == Urgency::Moving)
    }
}

impl Viewer {
    fn is_ready(&self) -> bool {
        let has_room = self.n_begun + self.pictures.len() < MAX_PICTURES;
        has_room && self.end.is_none() && !self.waiting.is_empty()
    }

    /// Has a picture sent, instead of an older one of the same pane that still waits.
    fn show(&mut self, pane: usize, message: Vec<u8>) {
        self.pictures.retain(|(other, _)| *other != pane);
        self.pictures.push_back((pane, message));
        self.wake.notify_one();
    }

    fn ask(&mut self, ask: Ask) {
        match self.waiting.iter_mut().find(|waiting| waiting.pane == ask.pane) {
            Some(place) => *place = ask,
            None => self.waiting.push(ask),
        }
    }

    fn tell(&mut self, text: String) {
        if MAX_TEXTS <= self.texts.len() {
            self.texts.pop_front();
        }
        self.texts.push_back(text);
        self.wake.notify_one();
    }

    fn close(&mut self, end: End) {
        self.end.get_or_insert(end);
        self.wake.notify_one();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ask(pane: usize, number: u64, urgency: Urgency) -> Ask {
        Ask { pane, number, urgency, layers: None, scene: String::new() }
    }

    fn encoded() -> Encoded {
        Encoded { format: "png", bytes: vec![7], ms: 1.0, n_voxels: 0, notes: Vec::new() }
    }

    /// What has its turn next: pane and number.
    fn draw(hub: &Hub) -> (ViewerId, usize, u64) {
        let turn = hub.next().unwrap();
        hub.drawn();
        hub.done(&turn, &Ok(encoded()));
        (turn.viewer, turn.ask.pane, turn.ask.number)
    }

    #[test]
    fn hub_draws_the_newest_of_each_pane_in_turn() {
        let hub = Hub::default();
        let ((a, _), (b, _)) = (hub.join(), hub.join());
        for number in 0..5 {
            hub.ask(a, ask(0, number, Urgency::Moving));
            hub.ask(a, ask(1, number, Urgency::Moving));
        }
        hub.ask(b, ask(0, 9, Urgency::Moving));
        assert_eq!(draw(&hub), (a, 0, 4));
        assert_eq!(draw(&hub), (b, 0, 9));
        assert_eq!(draw(&hub), (a, 1, 4));
        // Nobody has taken a picture, so that nothing is drawn until somebody does.
        hub.ask(a, ask(1, 5, Urgency::Moving));
        assert!(hub.locked().next().is_none());
        assert!(matches!(hub.take(a), Some(Outgoing::Picture(_))));
        assert_eq!(draw(&hub), (a, 1, 5));
        // It replaces the other one of its pane.
        assert!(matches!(hub.take(a), Some(Outgoing::Picture(_))));
        assert_eq!(hub.take(a), None);
        // One may be drawn while the other is encoded, but no third.
        (0..3).for_each(|pane| hub.ask(a, ask(pane, 6, Urgency::Moving)));
        let turns = [hub.next().unwrap(), hub.next().unwrap()];
        assert!(hub.locked().next().is_none());
        hub.done(&turns[0], &Err("no".to_owned()));
        assert!(matches!(hub.take(a), Some(Outgoing::Text(_))));
        assert_eq!(draw(&hub), (a, 2, 6));
    }

    #[test]
    fn hub_gives_up_what_is_at_rest() {
        let hub = Hub::default();
        let ((a, _), (b, _)) = (hub.join(), hub.join());
        let begun = |pane, urgency| {
            hub.ask(a, ask(pane, 1, urgency));
            hub.next().unwrap()
        };
        let turn = begun(0, Urgency::AtRest);
        hub.ask(b, ask(0, 1, Urgency::Moving));
        hub.ask(a, ask(1, 2, Urgency::AtRest));
        assert!(!turn.frame.is_cancelled(), "another viewer's, or another pane at rest");
        hub.ask(a, ask(1, 3, Urgency::Moving));
        assert!(turn.frame.is_cancelled());
        hub.put_off(turn);
        assert_eq!((draw(&hub), draw(&hub)), ((b, 0, 1), (a, 1, 3)));
        hub.take(a);
        assert_eq!(draw(&hub), (a, 0, 1), "it has another turn");
        hub.take(a);
        let turn = begun(0, Urgency::AtRest);
        hub.ask(a, ask(0, 2, Urgency::AtRest));
        assert!(turn.frame.is_cancelled());
        hub.put_off(turn);
        assert_eq!(draw(&hub), (a, 0, 2), "the older one is forgotten");
        hub.take(a);
        let turn = begun(0, Urgency::Moving);
        hub.ask(a, ask(0, 2, Urgency::Moving));
        assert!(!turn.frame.is_cancelled(), "what moves is seen");
        hub.leave(a);
        assert!(turn.frame.is_cancelled());
        hub.done(&turn, &Ok(encoded()));
        hub.end(End { code: 1001, why: "" });
        assert!(hub.next().is_none() && matches!(hub.take(b), Some(Outgoing::End(_))));
    }

    #[test]
    fn hub_holds_few_texts() {
        let hub = Hub::default();
        hub.tell_all("the CPU draws");
        let (a, _) = hub.join();
        assert_eq!(hub.take(a), Some(Outgoing::Text(note("the CPU draws"))));
        (0..100).for_each(|number| hub.tell(a, number.to_string()));
        let texts: Vec<_> = std::iter::from_fn(|| hub.take(a)).collect();
        assert_eq!((texts.len(), &texts[0]), (MAX_TEXTS, &Outgoing::Text("84".to_owned())));
    }
}
