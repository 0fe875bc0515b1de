//! What is to be seen: a volume, turned.

use std::error::Error;
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use crate::screen::{Screen, asked, asked_number};
use slabsplat::glam::DVec3;
use slabsplat::{Automatic, Camera, ImageDesc, RenderSettings, Scene, Volume, io};

/// A volume, and from where it is seen.
pub(crate) struct View {
    automatic: Automatic,
    /// Pixels of the picture's sides.
    n_pixels: u32,
    /// Radians to the side, and up.
    turned: [f64; 2],
    /// Whether nobody has drawn it so.
    is_new: bool,
}

/// The eye stays this far from the axis, which is upwards in the picture.
const LEAST_FROM_POLE: f64 = 0.1;

impl View {
    /// As the page's address says.
    pub(crate) fn asked_for(screen: &Screen) -> Result<Self, Box<dyn Error>> {
        let name = asked("volume").unwrap_or_else(|| "neuron".to_owned());
        let volume = io::builtin_volume(&name, Some(asked_number("voxels", 64)?))?;
        let mut view = Self {
            automatic: Automatic::new(volume),
            n_pixels: screen.canvas.width(),
            turned: [0.0; 2],
            is_new: true,
        };
        view.turn([asked_number("turn", 0.0_f64)?.to_radians(), 0.0]);
        Ok(view)
    }

    /// Shows another volume.
    pub(crate) fn show(&mut self, volume: Arc<Volume>) {
        self.automatic = Automatic::new(volume);
        self.turn([-self.turned[0], -self.turned[1]]);
    }

    /// Turned further, to the side and up, in radians.
    pub(crate) fn turn(&mut self, by: [f64; 2]) {
        self.turned = [self.turned[0] + by[0], self.turned[1] + by[1]];
        self.is_new = true;
    }

    /// The scene, if it is not what was there before.
    pub(crate) fn changed(&mut self) -> Option<Scene> {
        std::mem::take(&mut self.is_new).then(|| {
            let [width, height] = [self.n_pixels; 2];
            let image = ImageDesc::new(width, height).background([0.0, 0.0, 0.0, 1.0]);
            let start = self.automatic.camera(&image, true);
            let scene = self.automatic.scene(image, RenderSettings::default());
            scene.camera(turned(&start, &mut self.turned))
        })
    }
}

/// The camera somewhere else on the sphere around its target. It does not go over the pole.
fn turned(start: &Camera, [to_side, up]: &mut [f64; 2]) -> Camera {
    let from_target = start.eye() - start.target();
    let height = (from_target.z / from_target.length()).asin();
    let highest = FRAC_PI_2 - LEAST_FROM_POLE;
    *up = up.clamp(-highest - height, highest - height);
    let (sin, cos) = (height + *up).sin_cos();
    let azimuth = from_target.y.atan2(from_target.x) + *to_side;
    let direction = DVec3::new(cos * azimuth.cos(), cos * azimuth.sin(), sin);
    let eye = start.target() + from_target.length() * direction;
    Camera::new(eye, start.target(), DVec3::Z, start.projection()).expect("it is off the pole")
}
