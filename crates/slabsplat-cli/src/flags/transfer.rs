//! Flags of `[classify]` that say which transfer function a volume has.

use super::values::{self, ColorPoints, Ends, OpacityPoints};
use anyhow::{Context, Result, bail};
use clap::Args;
use slabsplat::io::{self, LayerFile, LoadedVolume, Stretch, TransferFit, TransferSource};
use slabsplat::{Phong, PiecewiseLinear, Shading, TransferFunction};
use std::path::PathBuf;

#[derive(Args)]
#[command(next_help_heading = "Classification and shading")]
pub(crate) struct TransferFlags {
    #[arg(long, value_name = "NAME", help = preset_help())]
    preset: Option<String>,

    #[arg(long, value_name = "NAME", help = colormap_help(), conflicts_with = "color")]
    colormap: Option<String>,

    /// Stretch a preset, a transfer file or a colour map over the values from LO to HI; alone, a gray ramp
    #[arg(long, value_name = "LO:HI", value_parser = values::range_ends, allow_hyphen_values = true)]
    window: Option<Ends>,

    /// The same from what LO percent of the voxels do not exceed to what HI percent do not
    #[arg(
        long, value_name = "LO:HI", value_parser = values::range_ends, allow_hyphen_values = true,
        conflicts_with = "window"
    )]
    percentile: Option<Ends>,

    /// What opacities are multiplied with
    #[arg(long, value_name = "FACTOR", allow_hyphen_values = true)]
    opacity_scale: Option<f64>,

    /// The length that opacities are per, in world units [default: a voxel step]
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    unit_distance: Option<f64>,

    /// A transfer function from a file: a colour map of ParaView (.json) or a volume property of 3D Slicer
    /// (.vp)
    #[arg(long, value_name = "FILE", conflicts_with = "preset")]
    transfer_file: Option<PathBuf>,

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
}

fn preset_help() -> String {
    format!(
        "A ready-made transfer function: {}; `slabsplat presets` tells what each shows",
        io::PRESET_NAMES.join(", ")
    )
}

fn colormap_help() -> String {
    format!(
        "Colours over all values, or over the window: {}; with _r behind its name, backwards",
        io::COLORMAP_NAMES.join(", ")
    )
}

impl TransferFlags {
    /// Whether a preset or a file is named, which may have opacities by gradients.
    pub(super) fn is_ready_made(&self) -> bool {
        self.preset.is_some() || self.transfer_file.is_some()
    }

    /// Lays the flags over what a file says of layers.
    pub(crate) fn lay_over(&self, layers: &mut [LayerFile]) -> Result<()> {
        let source = self.source()?;
        let curves = self.curves()?;
        let colormap = self.colormap.as_deref().map(io::colormap).transpose()?;
        for layer in layers {
            if let Some(source) = &source {
                begin_with(layer, source);
            }
            curves.lay_over(layer);
            if colormap.is_some() {
                layer.fit.colormap.clone_from(&colormap);
                layer.fit.color = None;
            }
            self.lay_numbers_over(&mut layer.fit);
            layer.check_fit()?;
            if let Some(name) = self.fit_flag().filter(|_| layer.transfer_2d.is_some()) {
                bail!(
                    "--{name} does nothing to boxes or pictures of values and gradients: add --preset"
                );
            }
        }
        Ok(())
    }

    /// Whether flags say what is seen of values, whatever was said before.
    pub(crate) fn are_by_value(&self) -> bool {
        let Self { opacity, color, preset, transfer_file, .. } = self;
        opacity.is_some() || color.is_some() || preset.is_some() || transfer_file.is_some()
    }

    /// That colours are not given to voxels that are drawn in their own.
    pub(crate) fn check_against(&self, loaded: &LoadedVolume) -> Result<()> {
        let flags = [("color", self.color.is_some()), ("colormap", self.colormap.is_some())];
        let has_colors = loaded.colors.as_ref().is_some_and(|colors| colors.voxels.is_some());
        match flags.into_iter().find(|&(_, is_given)| is_given && has_colors) {
            Some((name, _)) => bail!(
                "--{name} does nothing where voxels have colours of their own: add --colors none"
            ),
            None => Ok(()),
        }
    }

    /// Whether no flag says anything.
    pub(crate) fn are_silent(&self) -> bool {
        !self.are_by_value() && self.fit_flag().is_none()
    }

    /// The first flag that only changes what there is.
    fn fit_flag(&self) -> Option<&'static str> {
        let flags = [
            ("colormap", self.colormap.is_some()),
            ("window", self.window.is_some()),
            ("percentile", self.percentile.is_some()),
            ("opacity-scale", self.opacity_scale.is_some()),
            ("unit-distance", self.unit_distance.is_some()),
        ];
        flags.into_iter().find_map(|(name, is_given)| is_given.then_some(name))
    }

    fn source(&self) -> Result<Option<TransferSource>> {
        Ok(match (&self.preset, &self.transfer_file) {
            (Some(name), _) => Some(io::preset(name)?.source),
            (None, Some(path)) => Some(io::read_transfer(path)?),
            (None, None) => None,
        })
    }

    fn curves(&self) -> Result<Curves> {
        let opacity = self
            .opacity
            .as_ref()
            .map(|OpacityPoints(points)| PiecewiseLinear::new("opacity", points.iter().copied()));
        let color = self
            .color
            .as_ref()
            .map(|ColorPoints(points)| PiecewiseLinear::new("color", points.iter().copied()));
        Ok(Curves {
            opacity: opacity.transpose().context(CANNOT)?,
            color: color.transpose().context(CANNOT)?,
        })
    }

    fn lay_numbers_over(&self, fit: &mut TransferFit) {
        let window = self.window.map(|Ends(ends)| Stretch::Window(ends));
        let percentiles = self.percentile.map(|Ends(ends)| Stretch::Percentiles(ends));
        fit.stretch = window.or(percentiles).or(fit.stretch);
        fit.opacity_scale = self.opacity_scale.unwrap_or(fit.opacity_scale);
        fit.unit_distance = self.unit_distance.or(fit.unit_distance);
    }
}

const CANNOT: &str = "the transfer function cannot be used";

/// Points of opacity, of colour, or of both.
struct Curves {
    opacity: Option<PiecewiseLinear<1>>,
    color: Option<PiecewiseLinear<3>>,
}

impl Curves {
    /// Both are a transfer function, one of them takes the place of that of another.
    fn lay_over(&self, layer: &mut LayerFile) {
        match (&self.opacity, &self.color) {
            (Some(opacity), Some(color)) => {
                layer.transfer = Some(TransferFunction::of_curves(opacity.clone(), color.clone()));
                layer.fit = TransferFit::default();
            }
            (Some(opacity), None) => layer.fit.opacity = Some(opacity.clone()),
            (None, Some(color)) => {
                layer.fit.color = Some(color.clone());
                layer.fit.colormap = None;
            }
            (None, None) => {}
        }
    }
}

/// What was said of another transfer function does not count for this one.
fn begin_with(layer: &mut LayerFile, source: &TransferSource) {
    let has_shading = layer.shading != Shading::Phong(Phong::default());
    layer.fit = TransferFit::default();
    layer.begin_with(source.clone(), has_shading);
}
