//! What was made of something, cached for as long as it is made of the same.

use std::sync::{Arc, Weak};

/// The last value that was made, and what it was made of. Both the [`Planner`](crate::Planner) and backends
/// keep tables, lists and buffers so.
#[derive(Clone, Debug)]
pub struct Cached<K, V>(Option<(K, V)>);

impl<K, V> Default for Cached<K, V> {
    fn default() -> Self {
        Self(None)
    }
}

impl<K: PartialEq, V> Cached<K, V> {
    /// The value made of `key`. A cached one made of another key is dropped first, as two need not fit
    /// at a time, and `make` makes it anew.
    pub fn made_of(&mut self, key: K, make: impl FnOnce(&K) -> V) -> &mut V {
        if !self.0.as_ref().is_some_and(|(made_of, _)| *made_of == key) {
            self.0 = None;
        }
        let made = || {
            let value = make(&key);
            (key, value)
        };
        &mut self.0.get_or_insert_with(made).1
    }

    /// The same where `make` may fail; then nothing is cached.
    ///
    /// # Errors
    /// If `make` does.
    pub fn try_made_of<E>(
        &mut self,
        key: K,
        make: impl FnOnce(&K) -> Result<V, E>,
    ) -> Result<&mut V, E> {
        let cached = match self.0.take().filter(|(made_of, _)| *made_of == key) {
            Some(cached) => cached,
            None => {
                let value = make(&key)?;
                (key, value)
            }
        };
        Ok(&mut self.0.insert(cached).1)
    }

    /// The same where a key is dear to copy: `is_it` says whether the cached value was made of it, and `make`
    /// makes both anew.
    pub fn made_unless(
        &mut self,
        is_it: impl FnOnce(&K) -> bool,
        make: impl FnOnce() -> (K, V),
    ) -> &mut V {
        if !self.0.as_ref().is_some_and(|(made_of, _)| is_it(made_of)) {
            self.0 = None;
        }
        &mut self.0.get_or_insert_with(make).1
    }

    /// What is cached, whatever it was made of.
    pub fn value(&self) -> Option<&V> {
        self.0.as_ref().map(|(_, value)| value)
    }
}

/// The name of something shared, the same only as itself: comparing pointers is free, and comparing volumes
/// is not. It keeps nothing alive.
#[derive(Debug)]
pub struct ByIdentity<T>(Weak<T>);

impl<T> ByIdentity<T> {
    /// The name of what is shared.
    pub fn of(shared: &Arc<T>) -> Self {
        Self(Arc::downgrade(shared))
    }
}

impl<T> PartialEq for ByIdentity<T> {
    fn eq(&self, other: &Self) -> bool {
        self.0.ptr_eq(&other.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cached_is_made_once_a_key() {
        let mut cached = Cached::default();
        let mut n_made = 0;
        for key in [1, 1, 2, 2, 1] {
            let value = cached.made_of(key, |key| {
                n_made += 1;
                10 * key
            });
            assert_eq!(*value, 10 * key);
        }
        assert_eq!((n_made, cached.value()), (3, Some(&10)));
        for key in [1, 2, 2] {
            let is_it = |made_of: &i32| *made_of == key;
            let value = cached.made_unless(is_it, || {
                n_made += 1;
                (key, 10 * key)
            });
            assert_eq!(*value, 10 * key);
        }
        assert_eq!(n_made, 4);
    }

    #[test]
    fn cached_is_nothing_after_a_failure() {
        let mut cached = Cached::default();
        let made = |cached: &mut Cached<i32, i32>, key, value: Result<i32, ()>| {
            cached.try_made_of(key, |_| value).copied()
        };
        assert_eq!(made(&mut cached, 1, Ok(10)), Ok(10));
        assert_eq!(made(&mut cached, 1, Err(())), Ok(10), "it need not be made");
        assert_eq!(made(&mut cached, 2, Err(())), Err(()));
        assert_eq!(cached.value(), None);
        assert_eq!(made(&mut cached, 2, Ok(20)), Ok(20));
    }

    #[test]
    fn cached_by_identity_tells_twins_apart() {
        let [a, b] = [0, 1].map(|_| Arc::new("alike"));
        assert!(ByIdentity::of(&a) == ByIdentity::of(&a));
        assert!(ByIdentity::of(&a) != ByIdentity::of(&b));
        let gone = ByIdentity::of(&a);
        drop(a);
        assert!(gone != ByIdentity::of(&Arc::new("alike")), "its place is not given to another");
    }
}
