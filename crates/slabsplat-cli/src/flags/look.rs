//! Flags of `[classify]` and `[shading]`.

use super::table::{TableFlags, flag_name};
use super::values::{self, ColorPoints, OpacityPoints};
use anyhow::{Context, Result, bail};
use clap::{Args, ValueEnum};
use slabsplat::io::{self, SceneFile};
use slabsplat::{Automatic, Phong, Shading, TransferFunction, Volume};
use std::path::PathBuf;

#[derive(Args)]
#[command(next_help_heading = "Classification and shading")]
pub(super) struct LookFlags {
    /// Opacity per voxel step: points of a piecewise-linear function, as "80:0,255:0.9"
    #[arg(
        long, value_name = "VALUE:OPACITY,..", value_parser = values::opacity,
        allow_hyphen_values = true
    )]
    opacity: Option<OpacityPoints>,

    /// Colour: points of a piecewise-linear function, as "0:0,0,0;255:1,0.9,0.8"
    #[arg(
        long, value_name = "VALUE:R,G,B;..", value_parser = values::color,
        allow_hyphen_values = true
    )]
    color: Option<ColorPoints>,

    /// A ready-made transfer function, as ct-bone
    #[arg(long, value_name = "NAME")]
    preset: Option<String>,

    /// A transfer function from a ParaView colour map (.json)
    #[arg(long, value_name = "FILE", conflicts_with = "preset")]
    transfer_file: Option<PathBuf>,

    /// What light does to a voxel
    #[arg(long, value_name = "MODEL")]
    shading: Option<Model>,

    #[command(flatten)]
    phong: TableFlags<Phong>,
}

#[derive(Clone, Copy, ValueEnum)]
enum Model {
    Phong,
    None,
}

impl LookFlags {
    /// All but the points, which may need the volume.
    pub(super) fn lay_over(&self, file: &mut SceneFile) -> Result<()> {
        file.shading = self.shading_over(file.shading)?;
        if let Some(name) = &self.preset {
            file.transfer = Some(io::preset_transfer(name)?);
        }
        if let Some(path) = &self.transfer_file {
            file.transfer = Some(io::read_color_map(path)?);
        }
        Ok(())
    }

    /// Points of opacity and of colour replace those of the scene, or of the automatic function.
    pub(super) fn lay_points_over(&self, file: &mut SceneFile, volume: &Volume) -> Result<()> {
        if self.opacity.is_none() && self.color.is_none() {
            return Ok(());
        }
        let was = file.transfer.take().unwrap_or_else(|| Automatic::new(volume).transfer().clone());
        let opacity = match &self.opacity {
            Some(OpacityPoints(points)) => points.clone(),
            None => was.opacity_points().points().to_vec(),
        };
        let color = match &self.color {
            Some(ColorPoints(points)) => points.clone(),
            None => was.color_points().points().to_vec(),
        };
        let transfer = TransferFunction::new(opacity, color);
        file.transfer = Some(transfer.context("the transfer function cannot be used")?);
        Ok(())
    }

    fn shading_over(&self, was: Shading) -> Result<Shading> {
        let phong = match (self.shading, was) {
            (Some(Model::None), _) | (None, Shading::None) => {
                return self.unlit().map(|()| Shading::None);
            }
            (Some(Model::Phong), Shading::None) => Phong::default(),
            (_, Shading::Phong(phong)) => phong,
        };
        Ok(Shading::Phong(self.phong.lay_over(phong).checked()?))
    }

    /// Without shading, a flag about light would be a wish not granted.
    fn unlit(&self) -> Result<()> {
        let Some(name) = self.phong.names().next() else { return Ok(()) };
        bail!("--{} does nothing without shading: add --shading phong", flag_name(name))
    }
}
