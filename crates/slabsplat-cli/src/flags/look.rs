//! Flags of `[classify]` and `[shading]`.

use super::table::{TableFlags, flag_name};
use super::transfer::TransferFlags;
use super::values::{self, OpacityPoints};
use anyhow::{Result, bail};
use clap::{Args, ValueEnum};
use slabsplat::io::{LoadedVolume, MeshFile, SceneFile, TransferImageFile};
use slabsplat::{
    Isosurface, Mode, Phong, PiecewiseLinear, Shading, TransferBox, TransferFunction2d,
};

/// Flags of functions of the value alone.
const BY_VALUE: [&str; 9] = [
    "opacity",
    "color",
    "preset",
    "transfer_file",
    "colormap",
    "window",
    "percentile",
    "opacity_scale",
    "unit_distance",
];

#[derive(Args)]
#[command(next_help_heading = "Classification and shading")]
pub(super) struct LookFlags {
    #[command(flatten)]
    transfer: TransferFlags,

    /// A box of values and of how much values change in a voxel step there, opaque and white unless these
    /// follow, as "60,120,5,inf:0.4:1,0.8,0.6"; may be given several times
    #[arg(
        long = "transfer-box", value_name = "V0,V1,G0,G1[:OPACITY[:R,G,B]]",
        value_parser = values::transfer_box, allow_hyphen_values = true,
        conflicts_with_all = BY_VALUE
    )]
    transfer_boxes: Vec<TransferBox>,

    /// A picture (PNG, EXR) of colours and opacities: values from left to right, gradients from below to
    /// above
    #[arg(
        long, value_name = "FILE:V0,V1,G0,G1", value_parser = values::transfer_image,
        conflicts_with = "transfer_boxes", conflicts_with_all = BY_VALUE
    )]
    transfer_image: Option<TransferImageFile>,

    /// What opacity is multiplied with, by how much values change in a voxel step there: points of a
    /// function, as "0:0,20:1"
    #[arg(
        long, value_name = "GRADIENT:FACTOR,..", value_parser = values::opacity,
        allow_hyphen_values = true
    )]
    gradient_opacity: Option<OpacityPoints>,

    /// A surface of one density, opaque and of the density's colour unless these follow, as
    /// "80:0.4:0.9,0.7,0.6"; may be given several times, and means --mode isosurfaces
    #[arg(
        long = "isosurface", value_name = "VALUE[:OPACITY[:R,G,B]]", value_parser = values::isosurface,
        allow_hyphen_values = true
    )]
    isosurfaces: Vec<Isosurface>,

    /// How thick the lines of meshes are, in world units; by default 1/400 of a mesh's size
    #[arg(long, value_name = "WIDTH", value_parser = values::width, allow_hyphen_values = true)]
    line_width: Option<f64>,

    /// The diameter of the points of meshes, in world units; by default 1/100 of a mesh's size
    #[arg(long, value_name = "SIZE", value_parser = values::width, allow_hyphen_values = true)]
    point_size: Option<f64>,

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
    /// Lays the flags over what a file says of how layers and meshes look.
    pub(super) fn lay_over(&self, file: &mut SceneFile) -> Result<()> {
        file.unsaid.shading &= self.shading.is_none() && self.phong.names().next().is_none();
        let transfer_2d = self.transfer_2d()?;
        let by_gradient = self.gradient_opacity.as_ref().map(|OpacityPoints(points)| {
            PiecewiseLinear::new("--gradient-opacity", points.clone())
        });
        let by_gradient = by_gradient.transpose()?;
        for layer in &mut file.layers {
            if transfer_2d.is_some() || self.transfer.are_by_value() {
                layer.transfer_2d.clone_from(&transfer_2d);
                layer.transfer_image.clone_from(&self.transfer_image);
            }
            if by_gradient.is_some() {
                layer.gradient_opacity.clone_from(&by_gradient);
            }
            if !self.isosurfaces.is_empty() {
                layer.isosurfaces.clone_from(&self.isosurfaces);
            }
        }
        self.transfer.lay_over(&mut file.layers)?;
        // A preset may bring its own light.
        let usual = Shading::Phong(Phong::default());
        file.unsaid.shading &= file.layers.iter().all(|layer| layer.shading == usual);
        for layer in &mut file.layers {
            layer.shading = self.shading_over(layer.shading)?;
        }
        for mesh in &mut file.meshes {
            mesh.shading = self.shading_over(mesh.shading)?;
        }
        Ok(())
    }

    /// Makes the lines and points of all meshes as thick as flags say.
    pub(super) fn thicken(&self, meshes: &mut [MeshFile]) -> Result<()> {
        let flags = [("line-width", self.line_width), ("point-size", self.point_size)];
        let given = flags.into_iter().find(|(_, width)| width.is_some());
        if let (Some((name, _)), []) = (given, &*meshes) {
            bail!("--{name} does nothing without a mesh: add --mesh FILE");
        }
        for mesh in meshes {
            mesh.line_width = self.line_width.or(mesh.line_width);
            mesh.point_size = self.point_size.or(mesh.point_size);
        }
        Ok(())
    }

    /// That flags do something to a volume.
    pub(super) fn check_against(&self, loaded: &LoadedVolume) -> Result<()> {
        self.transfer.check_against(loaded)
    }

    /// The mode that flags about looks mean.
    pub(super) fn mode(&self) -> Option<Mode> {
        (!self.isosurfaces.is_empty()).then_some(Mode::Isosurfaces)
    }

    /// Whether a flag says what gradients do to opacity.
    pub(super) fn says_gradients(&self) -> bool {
        self.gradient_opacity.is_some() || self.transfer.is_ready_made()
    }

    fn transfer_2d(&self) -> Result<Option<TransferFunction2d>> {
        let boxes = || TransferFunction2d::Boxes(self.transfer_boxes.clone());
        match &self.transfer_image {
            Some(image) => Ok(Some(image.load()?)),
            None => Ok((!self.transfer_boxes.is_empty()).then(boxes)),
        }
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
