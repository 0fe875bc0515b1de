//! Flags of `[[lights]]`.

use super::values;
use anyhow::{Result, bail};
use clap::Args;
use slabsplat::io::SceneFile;
use slabsplat::{Light, Shading};

#[derive(Args)]
#[command(next_help_heading = "Classification and shading")]
pub(super) struct LightFlags {
    /// Where light comes from, headlight or a direction towards it, and in which colour, white if it does not
    /// say; may be given several times [default: headlight]
    #[arg(
        long = "light", value_name = "X,Y,Z[:R,G,B]", value_parser = values::light,
        allow_hyphen_values = true
    )]
    lights: Vec<Light>,
}

impl LightFlags {
    pub(super) fn lay_over(&self, file: &mut SceneFile) -> Result<()> {
        if self.lights.is_empty() {
            return Ok(());
        }
        if file.layers.iter().all(|layer| layer.shading == Shading::None) {
            bail!("--light does nothing without shading: add --shading phong");
        }
        Light::check_all(&self.lights)?;
        file.lights.clone_from(&self.lights);
        file.unsaid.lights = false;
        Ok(())
    }
}
