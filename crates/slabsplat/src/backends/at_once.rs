//! Futures of drivers that need no waiting, as all are outside of browsers: so this is no executor.

use std::pin::pin;
use std::task::{Context, Poll, Waker};

/// What the future gives, if it need not wait for it.
pub(super) fn at_once<T>(future: impl Future<Output = T>) -> Option<T> {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(value) => Some(value),
        Poll::Pending => None,
    }
}
