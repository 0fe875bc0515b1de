//! Files that a worker reads, one for each, so that the page goes on meanwhile. Reading that is given up ends
//! with its worker.

use super::thread::{Heard, Thread, of_volume};
use crate::handed::{Said, WithBytes};
use crate::jobs::Progress;
use crate::read_elsewhere::{LoadedHead, ToRead};
use js_sys::Array;
use slabsplat::io::{LoadedVolume, VolumeOptions};
use std::cell::RefCell;
use std::future::poll_fn;
use std::rc::Rc;
use std::task::{Context, Poll};

/// Reads a volume of bytes that are there. How far it is goes to `progress`, which may have it given up.
///
/// # Errors
/// In a sentence for people.
pub(crate) async fn read(
    name: &str,
    bytes: &[u8],
    options: &VolumeOptions,
    progress: &Progress,
) -> Result<LoadedVolume, String> {
    let result = Rc::new(RefCell::new(None));
    let thread = {
        let (result, progress, of_file) = (result.clone(), progress.clone(), name.to_owned());
        Thread::start(move |heard| {
            let came = match heard {
                Heard::Said(Said::Read(share)) => return progress.reach(share),
                Heard::Said(Said::NotRead(why) | Said::Note(why)) => Err(why),
                Heard::Said(Said::Ready | Said::Failed { .. }) => return,
                Heard::Ended(why) => Err(format!("what reads {of_file} stopped: {why}")),
                Heard::Parts(head, parts) => loaded(&head, &parts),
            };
            *result.borrow_mut() = Some(came);
            progress.wake();
        })?
    };
    let to_read = ToRead { name: name.to_owned(), options: options.clone() };
    thread.say_with(&WithBytes::ToRead(to_read), &[bytes])?;
    poll_fn(|context| poll(context, &result, progress)).await
}

fn poll(
    context: &Context<'_>,
    result: &RefCell<Option<Result<LoadedVolume, String>>>,
    progress: &Progress,
) -> Poll<Result<LoadedVolume, String>> {
    progress.set_waker(context.waker());
    match result.take() {
        Some(result) => Poll::Ready(result),
        None if progress.is_cancelled() => Poll::Ready(Err("it was given up".to_owned())),
        None => Poll::Pending,
    }
}

fn loaded(head: &str, parts: &Array) -> Result<LoadedVolume, String> {
    let head: LoadedHead = serde_json::from_str(head).map_err(|error| error.to_string())?;
    of_volume(parts, 0, |samples, colors| head.loaded(samples, colors))
}
