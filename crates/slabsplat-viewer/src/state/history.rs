//! Undo and redo.

/// What is now, what was before, and what was undone.
#[derive(Clone, Debug)]
pub struct History<T> {
    now: T,
    before: Vec<T>,
    undone: Vec<T>,
    /// What goes on: changes of the same kind become one step until it is settled.
    going_on: Option<&'static str>,
}

/// Steps that are retained; volumes are shared among them, so that each is small.
const MAX_STEPS: usize = 500;

impl<T: Clone> History<T> {
    /// Nothing has happened yet.
    pub fn new(now: T) -> Self {
        Self { now, before: Vec::new(), undone: Vec::new(), going_on: None }
    }

    /// What is now.
    pub fn now(&self) -> &T {
        &self.now
    }

    /// Something becomes otherwise. Changes of one kind in a row, as of a drag, are one step to be undone
    /// until [`settle`](Self::settle) says that it is over.
    pub fn change(&mut self, kind: &'static str, to: T) {
        let before = std::mem::replace(&mut self.now, to);
        self.undone.clear();
        if self.going_on.replace(kind) == Some(kind) {
            return;
        }
        if self.before.len() == MAX_STEPS {
            self.before.remove(0);
        }
        self.before.push(before);
    }

    /// What is dragged was let go.
    pub fn settle(&mut self) {
        self.going_on = None;
    }

    /// What is now becomes otherwise, and there is no way back to what it was.
    pub fn amend(&mut self, change: impl FnOnce(&mut T)) {
        change(&mut self.now);
    }

    /// Back to before the last step; whether there was one.
    pub fn undo(&mut self) -> bool {
        self.settle();
        let Some(before) = self.before.pop() else { return false };
        self.undone.push(std::mem::replace(&mut self.now, before));
        true
    }

    /// Once more what was undone last; whether there was anything.
    pub fn redo(&mut self) -> bool {
        self.settle();
        let Some(undone) = self.undone.pop() else { return false };
        self.before.push(std::mem::replace(&mut self.now, undone));
        true
    }

    /// Whether there is anything to be undone, and to be redone.
    pub fn has_steps(&self) -> [bool; 2] {
        [!self.before.is_empty(), !self.undone.is_empty()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_undone_and_redone() {
        let mut history = History::new(0);
        assert!(!history.undo() && !history.redo());
        history.change("set", 1);
        history.settle();
        history.change("set", 2);
        assert_eq!(history.has_steps(), [true, false]);
        assert!(history.undo());
        assert_eq!((*history.now(), history.has_steps()), (1, [true, true]));
        assert!(history.undo() && !history.undo());
        assert!(history.redo() && history.redo() && !history.redo());
        assert_eq!(*history.now(), 2);
        history.undo();
        history.change("other", 7);
        assert!(!history.redo(), "what was undone is gone");
        history.undo();
        assert_eq!(*history.now(), 1);
    }

    #[test]
    fn a_drag_is_one_step() {
        let mut history = History::new(0);
        for at in 1..50 {
            history.change("drag", at);
        }
        history.change("other", 50);
        history.change("drag", 51);
        history.settle();
        history.change("drag", 52);
        for expected in [51, 50, 49, 0] {
            history.undo();
            assert_eq!(*history.now(), expected);
        }
        assert!(!history.undo());
    }

    #[test]
    fn steps_are_bounded() {
        let mut history = History::new(0);
        for at in 1..=MAX_STEPS + 10 {
            history.change("set", at);
            history.settle();
        }
        let n_undone = std::iter::from_fn(|| history.undo().then_some(())).count();
        assert_eq!((n_undone, *history.now()), (MAX_STEPS, 10));
    }
}
