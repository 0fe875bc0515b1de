//! Flags of `[render]`.

use super::table::TableFlags;
use anyhow::Result;
use clap::Args;
use slabsplat::io::SceneFile;
use slabsplat::{BACKEND_NAMES, Method, RenderSettings};

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
    pub(super) fn lay_over(&self, file: &mut SceneFile) -> Result<()> {
        file.settings = self.rows.lay_over(file.settings.clone()).checked()?;
        if let Some(backend) = &self.backend {
            file.backend.clone_from(backend);
        }
        Ok(())
    }

    /// The method, if a flag names it.
    pub(super) fn method(&self) -> Option<Method> {
        let is_given = self.rows.names().any(|name| name == "method");
        is_given.then(|| self.rows.lay_over(RenderSettings::default()).method)
    }
}
