//! One picture after the other, for what is saved: it has its own size, is no pane's, and its source draws
//! nothing else.

use super::{PageSource, source};
use crate::frames::{Drawn, Event, Request, Urgency, Wake};
use slabsplat::OpenScene;
use std::future::poll_fn;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll, Waker};

/// What draws them.
pub(crate) struct Pictures {
    source: Box<dyn PageSource>,
    /// Who waits for a picture.
    waker: Arc<Mutex<Option<Waker>>>,
    n_asked: u64,
}

impl Pictures {
    /// A source like that of the page's own frames.
    pub(crate) fn open() -> Result<Self, String> {
        let waker = Arc::new(Mutex::new(None::<Waker>));
        let of_wake = waker.clone();
        let wake: Wake = Arc::new(move || {
            let waker = of_wake.lock().unwrap_or_else(PoisonError::into_inner).take();
            waker.into_iter().for_each(Waker::wake);
        });
        Ok(Self { source: source(wake)?, waker, n_asked: 0 })
    }

    /// What is drawn of a scene at rest.
    ///
    /// # Errors
    /// Why nothing is.
    pub(crate) async fn picture_of(&mut self, opened: OpenScene) -> Result<Drawn, String> {
        self.n_asked += 1;
        let (number, urgency) = (self.n_asked, Urgency::AtRest);
        self.source.ask(Request { pane: 0, number, opened, urgency, is_read_back: true });
        poll_fn(|context| self.poll(context)).await
    }

    fn poll(&mut self, context: &Context<'_>) -> Poll<Result<Drawn, String>> {
        *self.waker.lock().unwrap_or_else(PoisonError::into_inner) = Some(context.waker().clone());
        for event in self.source.events() {
            match event {
                Event::Drawn(drawn) => return Poll::Ready(Ok(*drawn)),
                Event::Failed { why, .. } => return Poll::Ready(Err(why)),
                // Nobody else has the page's textures.
                Event::Note(_) | Event::InTexture(_) => {}
            }
        }
        match self.source.ended() {
            Some(why) => Poll::Ready(Err(why)),
            None => Poll::Pending,
        }
    }

    /// What drew the last picture, as scene files call it, if that is known.
    pub(crate) fn backend(&self) -> Option<String> {
        self.source.backend()
    }
}
