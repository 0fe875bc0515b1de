//! Flags of `[camera]` and `[image]`, and cameras as people say them.

use super::values;
use anyhow::{Result, bail};
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use slabsplat::glam::DVec3;
use slabsplat::io::{Background, SceneFile};
use slabsplat::{Aim, Fit, ProjectionKind, Viewpoint};

#[derive(Args)]
#[command(next_help_heading = "Camera and image")]
pub(super) struct CameraFlags {
    /// Parallel rays, or rays from the eye
    #[arg(long, value_parser = projection_parser())]
    projection: Option<ProjectionKind>,

    /// The side that the picture is taken from; left and right of a body are its own [default: before it, a
    /// little to the side and above, or as the scene file says]
    #[arg(long, value_parser = viewpoint_parser(), conflicts_with = "eye")]
    view: Option<Viewpoint>,

    /// Degrees by which the camera goes to its own right, around what it looks at
    #[arg(long, value_name = "DEGREES", default_value_t = 0.0, allow_hyphen_values = true)]
    azimuth: f64,

    /// Degrees by which it rises
    #[arg(long, value_name = "DEGREES", default_value_t = 0.0, allow_hyphen_values = true)]
    elevation: f64,

    /// Degrees by which the picture turns counter-clockwise
    #[arg(long, value_name = "DEGREES", default_value_t = 0.0, allow_hyphen_values = true)]
    roll: f64,

    /// What fills the picture: what is visible, or all of the volume [default: visible, where the camera is
    /// found]
    #[arg(long, value_parser = fit_parser(), conflicts_with = "eye")]
    fit: Option<Fit>,

    /// By how much all is magnified
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, allow_hyphen_values = true)]
    zoom: f64,

    /// Parts of its width and height by which the picture moves to the right and upwards
    #[arg(
        long, value_name = "X,Y", value_parser = values::pair, default_value = "0,0",
        hide_default_value = true, allow_hyphen_values = true
    )]
    pan: values::Pair,

    /// The point of the world in the middle of the picture; the camera looks in the same direction as before
    #[arg(long, value_name = "X,Y,Z", value_parser = values::vector, allow_hyphen_values = true)]
    look_at: Option<DVec3>,

    /// Where the picture is taken from, in world units; needs --target or --look-at
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
    #[arg(long, visible_alias = "fov", value_name = "DEGREES", allow_hyphen_values = true)]
    fov_y: Option<f64>,

    /// Pixels in a row
    #[arg(long, value_name = "PIXELS")]
    width: Option<u32>,

    /// Rows of pixels
    #[arg(long, value_name = "PIXELS")]
    height: Option<u32>,

    /// Colour behind the volume: a name of CSS, #rgb, #rrggbb, #rrggbbaa, or R,G,B or R,G,B,A from 0 to 1
    /// each, opaque without A; two of them are the upper and the lower end of a gradient
    #[arg(
        long, value_name = "COLOR[:COLOR]", value_parser = str::parse::<Background>,
        allow_hyphen_values = true
    )]
    background: Option<Background>,

    /// Samples of a pixel, whose mean it is, in a square: 1, 4, 9, 16, 25, 36, 49 or 64; time and memory grow
    /// with them
    #[arg(long, value_name = "N")]
    samples: Option<u32>,
}

impl CameraFlags {
    pub(super) fn lay_over(&self, file: &mut SceneFile) -> Result<()> {
        let camera = &mut file.camera;
        let is_aimed = self.target.or(self.look_at).or(camera.target).or(camera.eye).is_some();
        if self.eye.is_some() && !is_aimed {
            bail!(
                "--eye says where the picture is taken from, but not what it shows: add --target X,Y,Z, or \
                 leave it out and name a side by --view"
            );
        }
        camera.projection = self.projection.or(camera.projection);
        camera.eye = self.eye.or(camera.eye);
        let target = self.target.or(self.look_at.filter(|_| self.eye.is_some()));
        camera.target = target.or(camera.target);
        camera.up = self.up.or(camera.up);
        camera.view_height = self.view_height.or(camera.view_height);
        camera.fov_y = self.fov_y.or(camera.fov_y);
        let image = &mut file.image;
        image.width = self.width.unwrap_or(image.width);
        image.height = self.height.unwrap_or(image.height);
        let finish = &mut file.finish;
        if let Some(Background { above, below, .. }) = self.background {
            (image.background, finish.background_below) = (above, below);
        }
        finish.samples = self.samples.unwrap_or(finish.samples);
        file.unsaid.background &= self.background.is_none();
        image.checked()?;
        finish.clone().checked()?.sampled(image)?;
        Ok(())
    }

    /// How the camera is aimed.
    pub(super) fn aim(&self) -> Result<Aim> {
        let values::Pair(pan) = self.pan;
        let aim = Aim::default()
            .viewpoint(self.view)
            .azimuth_degrees(self.azimuth)
            .elevation_degrees(self.elevation)
            .roll_degrees(self.roll)
            .fit(self.fit)
            .zoom(self.zoom)
            .pan(pan)
            .look_at(self.look_at);
        Ok(aim.checked()?)
    }
}

fn viewpoint_parser() -> impl TypedValueParser<Value = Viewpoint> {
    PossibleValuesParser::new(Viewpoint::NAMES).try_map(|name| name.parse::<Viewpoint>())
}

fn fit_parser() -> impl TypedValueParser<Value = Fit> {
    PossibleValuesParser::new(Fit::NAMES).try_map(|name| name.parse::<Fit>())
}

fn projection_parser() -> impl TypedValueParser<Value = ProjectionKind> {
    PossibleValuesParser::new(ProjectionKind::NAMES).try_map(|name| name.parse::<ProjectionKind>())
}
