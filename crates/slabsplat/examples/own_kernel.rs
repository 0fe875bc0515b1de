//! A reconstruction kernel of one's own: `cargo run --release -p slabsplat --example own_kernel [PICTURE]`.

use slabsplat::{Automatic, ImageDesc, Kernel, KernelName, RenderSettings, Renderer, io};
use std::error::Error;
use std::f64::consts::PI;
use std::path::{Path, PathBuf};
use std::sync::Arc;

fn main() -> Result<(), Box<dyn Error>> {
    let picture = std::env::args().nth(1).unwrap_or_else(|| "own-kernel.png".to_owned());
    draw(&PathBuf::from(picture))
}

/// Draws a volume by the kernel below.
pub(crate) fn draw(picture: &Path) -> Result<(), Box<dyn Error>> {
    let volume = io::builtin_volume("marschner-lobb", None)?;
    let settings = RenderSettings::default().kernel(KernelName::from(Biweight.name()));
    let scene = Automatic::new(volume).scene(ImageDesc::default(), settings);

    let mut renderer = Renderer::open("auto", |note| eprintln!("{note}"))?;
    renderer.add_kernel(Arc::new(Biweight))?;
    io::write_picture(picture, &renderer.render(&scene)?.image)?;
    Ok(())
}

/// `h(r) = c·(1 − r²/R²)²`: smooth at its end, and a polynomial along every line.
#[derive(Debug)]
pub(crate) struct Biweight;

impl Biweight {
    const RADIUS: f64 = 1.7;

    /// It makes the integral over the ball 1.
    const C: f64 = 105.0 / (32.0 * PI * Self::RADIUS * Self::RADIUS * Self::RADIUS);
}

impl Kernel for Biweight {
    fn name(&self) -> &str {
        "biweight"
    }

    fn radius(&self) -> f64 {
        Self::RADIUS
    }

    fn value(&self, r: f64) -> f64 {
        Self::C * (1.0 - (r / Self::RADIUS).powi(2)).max(0.0).powi(2)
    }

    /// At the distance `t` along a line that leaves the ball at `±e`, `1 − r²/R²` is `(e² − t²)/R²`.
    fn line_integral(&self, rho: f64, a: f64, b: f64) -> f64 {
        let e_squared = (Self::RADIUS.powi(2) - rho * rho).max(0.0);
        let e = e_squared.sqrt();
        let up_to = |t: f64| {
            let t = t.clamp(-e, e);
            e_squared.powi(2) * t - 2.0 / 3.0 * e_squared * t.powi(3) + t.powi(5) / 5.0
        };
        Self::C * (up_to(b) - up_to(a)) / Self::RADIUS.powi(4)
    }
}
