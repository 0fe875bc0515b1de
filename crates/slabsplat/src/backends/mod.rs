//! Which backends there are, and which one is taken.

mod gpu;

mod at_once;
mod found;
#[cfg(any(feature = "ash", feature = "wgpu"))]
mod interfaces;
mod race;

#[cfg(test)]
mod tests;

pub use found::{FoundBackend, FoundDevice, found_backends};

#[cfg(all(feature = "wgpu", not(target_arch = "wasm32")))]
pub(crate) use interfaces::is_fast;

use at_once::at_once;
use gpu::{GPUS, Gpu};
use slabsplat_backend::Backend;
use std::fmt;
use thiserror::Error;

/// The names that scene files and flags use. `auto` takes the fastest that there is.
pub const BACKEND_NAMES: &[&str] = &[
    "auto",
    #[cfg(feature = "cpu")]
    "cpu",
    #[cfg(feature = "wgpu")]
    "wgpu",
    #[cfg(feature = "ash")]
    "ash",
];

/// Those of a build with all features.
const ALL_NAMES: &[&str] = &["auto", "cpu", "wgpu", "ash"];

pub(crate) type MakeBackend = fn() -> Box<dyn Backend>;

#[cfg(feature = "cpu")]
pub(crate) const CPU: Option<MakeBackend> = Some(|| Box::new(slabsplat_cpu::CpuBackend::new()));
#[cfg(not(feature = "cpu"))]
pub(crate) const CPU: Option<MakeBackend> = None;

/// Why there is no backend of a name.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum NoBackend {
    /// No backend is called so.
    #[error("there is no backend \"{name}\" in this build; there are {}", BACKEND_NAMES.join(", "))]
    Unknown {
        /// The name asked for.
        name: String,
    },
    /// slabsplat was built without it.
    #[error(
        "there is no backend \"{name}\" in this build, which lacks the feature \"{name}\"; there are {}",
        BACKEND_NAMES.join(", ")
    )]
    NotBuilt {
        /// The name asked for, and the feature that brings it.
        name: &'static str,
    },
    /// This machine has nothing that it runs on.
    #[error("the backend \"{name}\" is not available: {reason}")]
    Unavailable {
        /// The name asked for.
        name: &'static str,
        /// What is missing, or what failed.
        reason: String,
    },
}

/// A backend, and how it came to be that one.
#[non_exhaustive]
pub struct Choice {
    /// The backend.
    pub backend: Box<dyn Backend>,
    /// Which better ones should have worked and did not, and why; sentences for people.
    pub notes: Vec<String>,
    /// What makes another backend, should the device of this one fail. Only `auto` continues with
    /// another: who names a backend wants that one or none.
    pub fallback: Option<fn() -> Box<dyn Backend>>,
}

impl fmt::Debug for Choice {
    /// All but what it holds within.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { backend, notes, .. } = self;
        let mut text = f.debug_struct("Choice");
        text.field("backend", backend.caps()).field("notes", notes).finish_non_exhaustive()
    }
}

/// Opens the backend called `name`.
///
/// `auto` takes the first graphics card that opens, by `ash` and then by `wgpu`; otherwise the CPU,
/// which beats a driver that plays a graphics card on it. A card on the processor's chip, or of a virtual
/// machine, is taken if it draws a small scene faster than the CPU does: they race once in a program, for
/// some tenths of a second.
///
/// # Errors
/// If this build has no such backend, or this machine nothing that it runs on.
pub fn choose_backend(name: &str) -> Result<Choice, NoBackend> {
    choose_now(GPUS, name)
}

/// The same for where graphics cards are waited for: in a browser. Elsewhere it does not wait.
///
/// # Errors
/// If this build has no such backend, or this machine nothing that it runs on.
pub async fn choose_backend_async(name: &str) -> Result<Choice, NoBackend> {
    choose_among(GPUS, name).await
}

/// Opens the backend called `name`, and says nothing of others; with `auto`, [`choose_backend`] tells
/// more.
///
/// # Errors
/// If this build has no such backend, or this machine nothing that it runs on.
pub fn backend_named(name: &str) -> Result<Box<dyn Backend>, NoBackend> {
    choose_backend(name).map(|choice| choice.backend)
}

fn choose_now(gpus: &[Gpu], name: &str) -> Result<Choice, NoBackend> {
    at_once(choose_among(gpus, name)).unwrap_or_else(|| without_waiting(gpus, name))
}

async fn choose_among(gpus: &[Gpu], name: &str) -> Result<Choice, NoBackend> {
    if name == "auto" {
        return automatic(gpus).await;
    }
    let backend = match gpus.iter().find(|gpu| gpu.name == name) {
        Some(gpu) => gpu.open_named().await?,
        None => CPU.filter(|_| name == "cpu").ok_or_else(|| missing(name))?(),
    };
    Ok(Choice { backend, notes: Vec::new(), fallback: None })
}

async fn automatic(gpus: &[Gpu]) -> Result<Choice, NoBackend> {
    let mut notes = Vec::new();
    for gpu in gpus {
        match gpu.open_if_fast().await {
            Ok(Some(backend)) => return Ok(Choice { backend, notes, fallback: CPU }),
            Ok(None) => {}
            Err(note) => notes.push(note),
        }
    }
    match CPU {
        Some(make) => Ok(Choice { backend: make(), notes, fallback: None }),
        None => any(gpus, notes).await,
    }
}

/// A slow device is better than none, in a build without the CPU backend.
async fn any(gpus: &[Gpu], notes: Vec<String>) -> Result<Choice, NoBackend> {
    let mut reasons = Vec::new();
    for gpu in gpus {
        match gpu.open_named().await {
            Ok(backend) => return Ok(Choice { backend, notes, fallback: None }),
            Err(reason) => reasons.push(reason.to_string()),
        }
    }
    let reason =
        if reasons.is_empty() { "this build has none".to_owned() } else { reasons.join("; ") };
    Err(NoBackend::Unavailable { name: "auto", reason })
}

/// What there is of that name without waiting, where graphics cards are waited for.
fn without_waiting(gpus: &[Gpu], name: &str) -> Result<Choice, NoBackend> {
    let reason = "graphics cards are waited for here, as `Renderer::open_async` does".to_owned();
    match CPU.filter(|_| name == "auto") {
        Some(make) => Ok(Choice { backend: make(), notes: vec![reason], fallback: None }),
        None => {
            let name = gpus.iter().find(|gpu| gpu.name == name).map_or("auto", |gpu| gpu.name);
            Err(NoBackend::Unavailable { name, reason })
        }
    }
}

fn missing(name: &str) -> NoBackend {
    match ALL_NAMES.iter().find(|known| **known == name) {
        Some(name) => NoBackend::NotBuilt { name },
        None => NoBackend::Unknown { name: name.to_owned() },
    }
}
