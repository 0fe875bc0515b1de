//! Flags of `[camera]` and `[image]`.

use super::values::{self, Background};
use anyhow::Result;
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use slabsplat::ProjectionKind;
use slabsplat::glam::DVec3;
use slabsplat::io::SceneFile;

#[derive(Args)]
#[command(next_help_heading = "Camera and image")]
pub(super) struct CameraFlags {
    /// Parallel rays, or rays from the eye
    #[arg(long, value_parser = projection_parser())]
    projection: Option<ProjectionKind>,

    /// Where the picture is taken from, in world units
    #[arg(long, value_name = "X,Y,Z", value_parser = values::vector, allow_hyphen_values = true)]
    eye: Option<DVec3>,

    /// What is looked at
    #[arg(long, value_name = "X,Y,Z", value_parser = values::vector, allow_hyphen_values = true)]
    target: Option<DVec3>,

    /// What points upwards in the picture
    #[arg(long, value_name = "X,Y,Z", value_parser = values::vector, allow_hyphen_values = true)]
    up: Option<DVec3>,

    /// Orthographic: world units from the lower to the upper edge
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    view_height: Option<f64>,

    /// Perspective: degrees from the lower to the upper edge
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    fov_y: Option<f64>,

    /// Pixels in a row
    #[arg(long, value_name = "PIXELS")]
    width: Option<u32>,

    /// Rows of pixels
    #[arg(long, value_name = "PIXELS")]
    height: Option<u32>,

    /// Colour behind the volume, 0 to 1 each; opaque without A
    #[arg(
        long, value_name = "R,G,B,A", value_parser = values::background, allow_hyphen_values = true
    )]
    background: Option<Background>,
}

impl CameraFlags {
    pub(super) fn lay_over(&self, file: &mut SceneFile) -> Result<()> {
        let camera = &mut file.camera;
        camera.projection = self.projection.or(camera.projection);
        camera.eye = self.eye.or(camera.eye);
        camera.target = self.target.or(camera.target);
        camera.up = self.up.or(camera.up);
        camera.view_height = self.view_height.or(camera.view_height);
        camera.fov_y = self.fov_y.or(camera.fov_y);
        let image = &mut file.image;
        image.width = self.width.unwrap_or(image.width);
        image.height = self.height.unwrap_or(image.height);
        image.background = self.background.map_or(image.background, |Background(color)| color);
        image.checked()?;
        Ok(())
    }
}

fn projection_parser() -> impl TypedValueParser<Value = ProjectionKind> {
    PossibleValuesParser::new(ProjectionKind::NAMES).try_map(|name| name.parse::<ProjectionKind>())
}
