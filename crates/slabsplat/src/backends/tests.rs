//! Choices among graphics cards that are not there.

use super::gpu::{Opened, Opening};
use super::*;
use slabsplat_backend::{BackendError, Caps, Frame, FrameCost, FramePlan, FrameStats};
use slabsplat_core::{FrameHandle, Image, Method};
use std::future::{poll_fn, ready};
use std::mem::replace;
use std::pin::pin;
use std::sync::atomic::{AtomicU64, Ordering};
use std::task::{Context, Poll, Waker};
use std::time::Duration;

/// A backend that has a name and nothing else.
struct Named(Caps);

impl Backend for Named {
    fn caps(&self) -> &Caps {
        &self.0
    }

    fn submit(&mut self, _: &FramePlan<'_>, _: &FrameHandle) -> Result<(), BackendError> {
        Ok(())
    }

    fn poll_image(&mut self, _: &FrameHandle) -> Result<Poll<Frame>, BackendError> {
        Err(BackendError::UnknownFrame)
    }
}

fn opened(name: &'static str, is_fast: Option<bool>) -> Result<Opened, String> {
    let caps = Caps::new(name, "Fake 3000", Method::ALL);
    Ok(Opened { backend: Box::new(Named(caps)), is_fast })
}

fn listed(is_fast: bool) -> Result<Vec<FoundDevice>, String> {
    Ok(vec![FoundDevice {
        name: "Fake 3000".to_owned(),
        driver: None,
        kind: "other",
        is_fast,
        max_binding_bytes: None,
        memory_bytes: None,
        is_timed: false,
    }])
}

fn at_once_is(opened: Result<Opened, String>) -> Opening {
    Box::pin(ready(opened))
}

const CARD: Gpu =
    Gpu { name: "card", devices: || listed(true), open: || at_once_is(opened("card", Some(true))) };
const PLAYED: Gpu = Gpu {
    name: "played",
    devices: || listed(false),
    open: || at_once_is(opened("played", Some(false))),
};
const BROKEN: Gpu = Gpu {
    name: "broken",
    devices: || listed(true),
    open: || at_once_is(Err("it sparks".to_owned())),
};
/// It has not been seen to draw anything.
const DUBIOUS: Gpu =
    Gpu { name: "dubious", devices: || listed(true), open: || at_once_is(opened("dubious", None)) };
const NOTHING: Gpu = Gpu {
    name: "nothing",
    devices: || Err("there is no driver".to_owned()),
    open: || at_once_is(Err("there is no driver".to_owned())),
};
/// As in browsers: it is there when it is asked a second time.
const WAITED_FOR: Gpu =
    Gpu { name: "late", devices: || listed(true), open: || Box::pin(opened_later()) };

async fn opened_later() -> Result<Opened, String> {
    let mut has_waited = false;
    let wait = poll_fn(|_| match replace(&mut has_waited, true) {
        true => Poll::Ready(()),
        false => Poll::Pending,
    });
    wait.await;
    opened("late", Some(true))
}

/// Which backend is chosen, and the notes.
fn choice(gpus: &[Gpu], name: &str) -> Result<(&'static str, Vec<String>), NoBackend> {
    choose_now(gpus, name).map(|choice| (choice.backend.caps().name, choice.notes))
}

#[test]
fn auto_takes_the_first_card() {
    let check = |gpus: &[Gpu], expected| {
        assert_eq!(choice(gpus, "auto"), Ok((expected, Vec::new())));
    };
    check(&[CARD, NOTHING], "card");
    check(&[NOTHING, CARD], "card");
    check(&[PLAYED, CARD], "card");
}

#[test]
#[cfg(feature = "cpu")]
fn auto_takes_the_cpu_rather_than_software() {
    assert_eq!(choice(&[PLAYED, NOTHING], "auto"), Ok(("cpu", Vec::new())));
    assert_eq!(choice(&[], "auto"), Ok(("cpu", Vec::new())));
}

#[test]
#[cfg(feature = "cpu")]
fn auto_takes_no_card_that_loses_a_race() {
    assert_eq!(choice(&[DUBIOUS], "auto"), Ok(("cpu", Vec::new())));
    assert_eq!(choice(&[DUBIOUS, CARD], "auto"), Ok(("card", Vec::new())));
    assert_eq!(choice(&[DUBIOUS], "dubious"), Ok(("dubious", Vec::new())));
}

/// A backend whose frames take as long as it says, the first one ten times as long, by a clock of ours.
struct Runner<'a> {
    caps: Caps,
    /// In milliseconds.
    clock: &'a AtomicU64,
    takes: u64,
    has_begun: bool,
}

impl Backend for Runner<'_> {
    fn caps(&self) -> &Caps {
        &self.caps
    }

    fn submit(&mut self, _: &FramePlan<'_>, _: &FrameHandle) -> Result<(), BackendError> {
        let factor = if replace(&mut self.has_begun, true) { 1 } else { 10 };
        self.clock.fetch_add(factor * self.takes, Ordering::Relaxed);
        Ok(())
    }

    fn poll_image(&mut self, _: &FrameHandle) -> Result<Poll<Frame>, BackendError> {
        let image = Image::from_pixels(0, 0, Vec::new());
        Ok(Poll::Ready(Frame::new(image, FrameStats::default(), FrameCost::default())))
    }
}

#[test]
fn races_are_won_by_the_faster() {
    let clock = AtomicU64::new(0);
    let now = || Duration::from_millis(clock.load(Ordering::Relaxed));
    let runner = |takes| Runner {
        caps: Caps::new("runner", "Fake 3000", Method::ALL),
        clock: &clock,
        takes,
        has_begun: false,
    };
    let is_faster = |card, cpu| race::is_faster(&mut runner(card), &mut runner(cpu), now);
    assert!(is_faster(7, 8), "the first frame, of 70 ms, does not count");
    assert!(!is_faster(8, 7));
    assert!(!is_faster(7, 7), "whoever is no faster is not worth the memory");
    let mut broken = Named(Caps::new("broken", "Fake 3000", Method::ALL));
    assert!(!race::is_faster(&mut broken, &mut runner(9), now));
    assert!(race::is_faster(&mut runner(9), &mut broken, now));
}

#[test]
fn auto_tells_what_it_could_not_open() {
    let (name, notes) = choice(&[NOTHING, BROKEN, CARD], "auto").unwrap();
    assert_eq!(name, "card");
    assert_eq!(notes, ["the backend \"broken\" could not open Fake 3000: it sparks"]);
}

#[test]
#[cfg(feature = "cpu")]
fn auto_alone_goes_on_elsewhere() {
    let fallback = |gpus: &[Gpu], name| choose_now(gpus, name).unwrap().fallback;
    let make = fallback(&[CARD], "auto").unwrap();
    assert_eq!(make().caps().name, "cpu");
    assert!(fallback(&[CARD], "card").is_none(), "who names a backend wants that one");
    assert!(fallback(&[], "auto").is_none(), "the CPU has nothing to fall back on");
}

#[test]
#[cfg(not(feature = "cpu"))]
fn auto_without_the_cpu() {
    assert_eq!(choice(&[NOTHING, PLAYED], "auto"), Ok(("played", Vec::new())));
    let error = |gpus: &[Gpu]| choice(gpus, "auto").unwrap_err().to_string();
    assert!(error(&[]).contains("this build has none"));
    assert!(error(&[NOTHING]).contains("\"nothing\" is not available: there is no driver"));
}

#[test]
fn card_that_is_waited_for() {
    let mut choice = pin!(choose_among(&[WAITED_FOR], "auto"));
    let mut poll = || choice.as_mut().poll(&mut Context::from_waker(Waker::noop()));
    assert!(poll().is_pending());
    let Poll::Ready(choice) = poll() else { panic!("it has waited once") };
    assert_eq!(choice.unwrap().backend.caps().name, "late");
    let error = choose_now(&[WAITED_FOR], "late").err().unwrap().to_string();
    assert!(error.contains("\"late\" is not available: graphics cards are waited for"), "{error}");
}

#[test]
#[cfg(feature = "cpu")]
fn auto_does_not_wait() {
    let (name, notes) = choice(&[WAITED_FOR], "auto").unwrap();
    assert_eq!((name, notes.len()), ("cpu", 1), "{notes:?}");
}

#[test]
fn named_takes_what_is_named() {
    assert_eq!(choice(&[CARD, PLAYED], "played"), Ok(("played", Vec::new())));
    let error = choice(&[CARD, BROKEN], "broken").unwrap_err();
    assert_eq!(error.to_string(), "the backend \"broken\" is not available: it sparks");
}

#[test]
fn names_of_this_build() {
    let error = backend_named("cray").err().unwrap().to_string();
    assert!(error.starts_with("there is no backend \"cray\" in this build; there are"), "{error}");
    for &name in ALL_NAMES {
        let lacks = matches!(backend_named(name), Err(NoBackend::NotBuilt { .. }));
        assert_eq!(lacks, !BACKEND_NAMES.contains(&name), "{name}");
    }
}

#[test]
fn found_backends_are_those_of_this_build() {
    let mut found: Vec<&str> = found_backends().iter().map(|backend| backend.name).collect();
    let mut expected: Vec<&str> = BACKEND_NAMES.iter().copied().filter(|n| *n != "auto").collect();
    found.sort_unstable();
    expected.sort_unstable();
    assert_eq!(found, expected);
}
