//! Flags of `[render]`.

use super::table::TableFlags;
use anyhow::{Result, bail};
use clap::Args;
use slabsplat::io::SceneFile;
use slabsplat::{BACKEND_NAMES, Method, Mode, RenderSettings};

#[derive(Args)]
#[command(next_help_heading = "Rendering")]
pub(super) struct SettingsFlags {
    #[command(flatten)]
    rows: TableFlags<RenderSettings>,

    // Not clap's to check: a scene may name a backend, too, and gets the same answer.
    #[arg(long, value_name = "NAME", help = backend_help())]
    backend: Option<String>,
}

fn backend_help() -> String {
    let names = BACKEND_NAMES.join(", ");
    format!("What executes the frame: {names}; auto is the fastest that there is")
}

impl SettingsFlags {
    /// Lays the flags over a scene, in a mode that others may mean.
    pub(super) fn lay_over(&self, file: &mut SceneFile, mode: Option<Mode>) -> Result<()> {
        let mut settings = self.rows.lay_over(file.settings.clone());
        if let Some(mode) = mode {
            if self.is_given("mode") && settings.mode != mode {
                bail!("--isosurface does nothing in the mode {}: leave one out", settings.mode);
            }
            settings.mode = mode;
        }
        file.settings = settings.checked()?;
        if let Some(backend) = &self.backend {
            file.backend.clone_from(backend);
        }
        Ok(())
    }

    /// The backend that a flag names.
    #[cfg(feature = "viewer")]
    pub(super) fn backend(&self) -> Option<&str> {
        self.backend.as_deref()
    }

    /// Whether a flag names the backend.
    pub(super) fn names_backend(&self) -> bool {
        self.backend.is_some()
    }

    /// The method, if a flag names it.
    pub(super) fn method(&self) -> Option<Method> {
        self.is_given("method").then(|| self.rows.lay_over(RenderSettings::default()).method)
    }

    fn is_given(&self, row: &str) -> bool {
        self.rows.names().any(|name| name == row)
    }
}
