//! Flags of `[classify]` and `[shading]`.

use super::table::{TableFlags, flag_name};
use super::values::{self, ColorPoints, OpacityPoints};
use anyhow::{Context, Result, bail};
use clap::{Args, ValueEnum};
use slabsplat::io::{self, SceneFile, TransferImageFile};
use slabsplat::{
    Isosurface, Layer, Mode, Phong, PiecewiseLinear, Shading, TransferBox, TransferFunction,
    TransferFunction2d,
};
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

    /// A box of values and of how much values change in a voxel step there, opaque and white unless these
    /// follow, as "60,120,5,inf:0.4:1,0.8,0.6"; may be given several times
    #[arg(
        long = "transfer-box", value_name = "V0,V1,G0,G1[:OPACITY[:R,G,B]]",
        value_parser = values::transfer_box, allow_hyphen_values = true,
        conflicts_with_all = ["opacity", "color", "preset", "transfer_file"]
    )]
    transfer_boxes: Vec<TransferBox>,

    /// A picture (PNG, EXR) of colours and opacities: values from left to right, gradients from below to
    /// above
    #[arg(
        long, value_name = "FILE:V0,V1,G0,G1", value_parser = values::transfer_image,
        conflicts_with_all = ["opacity", "color", "preset", "transfer_file", "transfer_boxes"]
    )]
    transfer_image: Option<TransferImageFile>,

    /// What opacity is multiplied with, by how much values change in a voxel step there: points of a
    /// function, as "0:0,20:1"
    #[arg(
        long, value_name = "GRADIENT:FACTOR,..", value_parser = values::opacity,
        allow_hyphen_values = true
    )]
    gradient_opacity: Option<OpacityPoints>,

    /// A ready-made transfer function, as ct-bone
    #[arg(long, value_name = "NAME")]
    preset: Option<String>,

    /// A transfer function from a ParaView colour map (.json)
    #[arg(long, value_name = "FILE", conflicts_with = "preset")]
    transfer_file: Option<PathBuf>,

    /// A surface of one density, opaque and of the density's colour unless these follow, as
    /// "80:0.4:0.9,0.7,0.6"; may be given several times, and means --mode isosurfaces
    #[arg(
        long = "isosurface", value_name = "VALUE[:OPACITY[:R,G,B]]", value_parser = values::isosurface,
        allow_hyphen_values = true
    )]
    isosurfaces: Vec<Isosurface>,

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
    /// All but points of opacity or of colour alone: the others may have to be found from the volume.
    pub(super) fn lay_over(&self, file: &mut SceneFile) -> Result<()> {
        let transfer = self.whole_transfer()?;
        let transfer_2d = self.transfer_2d()?;
        let by_gradient = self.gradient_opacity.as_ref().map(|OpacityPoints(points)| {
            PiecewiseLinear::new("--gradient-opacity", points.clone())
        });
        let by_gradient = by_gradient.transpose()?;
        for layer in &mut file.layers {
            layer.shading = self.shading_over(layer.shading)?;
            if transfer_2d.is_some() || self.are_by_value() {
                layer.transfer_2d.clone_from(&transfer_2d);
                layer.transfer_image.clone_from(&self.transfer_image);
            }
            layer.transfer = transfer.clone().or_else(|| layer.transfer.take());
            if by_gradient.is_some() {
                layer.gradient_opacity.clone_from(&by_gradient);
            }
            if !self.isosurfaces.is_empty() {
                layer.isosurfaces.clone_from(&self.isosurfaces);
            }
        }
        for mesh in &mut file.meshes {
            mesh.shading = self.shading_over(mesh.shading)?;
        }
        Ok(())
    }

    /// The mode that flags about looks mean.
    pub(super) fn mode(&self) -> Option<Mode> {
        (!self.isosurfaces.is_empty()).then_some(Mode::Isosurfaces)
    }

    /// Whether flags say what is seen of values.
    fn are_by_value(&self) -> bool {
        let Self { opacity, color, preset, transfer_file, .. } = self;
        opacity.is_some() || color.is_some() || preset.is_some() || transfer_file.is_some()
    }

    fn transfer_2d(&self) -> Result<Option<TransferFunction2d>> {
        let boxes = || TransferFunction2d::Boxes(self.transfer_boxes.clone());
        match &self.transfer_image {
            Some(image) => Ok(Some(image.load()?)),
            None => Ok((!self.transfer_boxes.is_empty()).then(boxes)),
        }
    }

    /// The transfer function that flags say as a whole.
    fn whole_transfer(&self) -> Result<Option<TransferFunction>> {
        Ok(match (&self.opacity, &self.color, &self.preset, &self.transfer_file) {
            (Some(OpacityPoints(opacity)), Some(ColorPoints(color)), ..) => {
                Some(transfer(opacity.clone(), color.clone())?)
            }
            (_, _, Some(name), _) => Some(io::preset_transfer(name)?),
            (_, _, _, Some(path)) => Some(io::read_color_map(path)?),
            _ => None,
        })
    }

    /// Whether there are points of opacity or of colour without the others.
    pub(super) fn are_points_alone(&self) -> bool {
        self.opacity.is_none() != self.color.is_none()
    }

    /// Points of opacity and of colour replace those of the scene, or of the automatic function.
    pub(super) fn lay_points_over(&self, layers: &mut [Layer]) -> Result<()> {
        if !self.are_points_alone() {
            return Ok(());
        }
        for layer in layers {
            let opacity = match &self.opacity {
                Some(OpacityPoints(points)) => points.clone(),
                None => layer.transfer.opacity_points().points().to_vec(),
            };
            let color = match &self.color {
                Some(ColorPoints(points)) => points.clone(),
                None => layer.transfer.color_points().points().to_vec(),
            };
            layer.transfer = transfer(opacity, color)?;
        }
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

fn transfer(
    opacity: Vec<(f64, [f64; 1])>,
    color: Vec<(f64, [f64; 3])>,
) -> Result<TransferFunction> {
    TransferFunction::new(opacity, color).context("the transfer function cannot be used")
}
