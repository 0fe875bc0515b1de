//! Which backends there are.

use slabsplat_backend::Backend;
use thiserror::Error;

/// The names that scene files and flags use. `auto` takes the fastest that there is.
pub const BACKEND_NAMES: &[&str] = &[
    "auto",
    #[cfg(feature = "cpu")]
    "cpu",
];

/// There is no backend of that name in this build.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("there is no backend \"{name}\" in this build; there are {}", BACKEND_NAMES.join(", "))]
pub struct UnknownBackend {
    /// The name asked for.
    pub name: String,
}

/// Makes the backend called `name`.
///
/// # Errors
/// If this build has no such backend.
pub fn backend_named(name: &str) -> Result<Box<dyn Backend>, UnknownBackend> {
    match name {
        #[cfg(feature = "cpu")]
        "auto" | "cpu" => Ok(Box::new(slabsplat_cpu::CpuBackend::new())),
        _ => Err(UnknownBackend { name: name.to_owned() }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn backend_names_are_found() {
        let err = backend_named("cray").err().unwrap().to_string();
        assert!(err.starts_with("there is no backend \"cray\" in this build"), "{err}");
        #[cfg(feature = "cpu")]
        for &name in BACKEND_NAMES {
            assert!(backend_named(name).is_ok(), "{name}");
        }
    }
}
