//! Futures that are ready at once.
//!
//! All of wgpu's are, outside of browsers: it has them because browsers need them. So this is no
//! executor and needs none.

use std::pin::pin;
use std::task::{Context, Poll, Waker};

/// What the future gives, if it need not wait for it.
pub(crate) fn at_once<T>(future: impl Future<Output = T>) -> Option<T> {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(value) => Some(value),
        Poll::Pending => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ready_tells_what_would_wait() {
        assert_eq!(at_once(async { 7 }), Some(7));
        assert_eq!(at_once(std::future::pending::<u32>()), None);
    }
}
