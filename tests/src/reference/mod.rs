//! The reference: `docs/model.md` computed by brute force in 64-bit floats, written to be read.
//!
//! There are no tables, tiles or early exits. Every section weight is a numerical integral of the
//! kernel along the pixel's ray, and the only things left out are those that contribute exactly
//! nothing: voxels of opacity 0, and kernels that the ray does not meet. So the settings that only
//! trade accuracy for speed (`sections`, `radial_samples`, `lookup`, `opacity_cutoff`) are ignored,
//! and so is `tolerance`, but for [`render_within_tolerance`].
//!
//! Reading order, by the model's sections: `quadrature`, `kernel`, `section`, `hierarchy` (§2); `sheet`
//! (§3); `view` (§5); `gradient`, `shade` (§6); `slabs` (§10) and `region` (§11); `frame` (§4) and `row` put
//! them together; `merge` (§7) and `cells` (§16) are what a tolerance changes; `between_sheets`,
//! `classified_part`, `density_layer` and `density` (§8) are the method `post-classified`, `statistic` and
//! `isosurfaces` the modes of §12; `mesh` (§14) ends rays at opaque surfaces.

mod gradient;
mod hierarchy;
mod kernel;
mod quadrature;
mod section;
mod shade;
mod sheet;
mod view;

mod between_sheets;
mod cell_bricks;
mod cells;
mod classified_part;
mod density;
mod density_layer;
mod frame;
mod image;
mod isosurfaces;
mod merge;
mod mesh;
mod region;
mod row;
mod slabs;
mod statistic;
mod tube;

pub use gradient::{gradient_in_world, gradient_length};
pub use hierarchy::Hierarchy;
pub use image::{Difference, ReferenceImage};
pub use kernel::Kernel;
pub use merge::fraction_beyond;
pub use quadrature::GaussLegendre;
pub use region::undecided_pixels;
pub use section::{Cut, KernelInView};
pub use shade::{shaded_by_normals, shaded_color};
pub use sheet::{Premultiplied, SheetSums};

use rayon::prelude::*;
use slabsplat_core::{Method, Mode, Scene};

/// The picture of `scene`.
///
/// # Panics
/// If the scene names a kernel that model §2 does not list, or has several layers or a region where its
/// method has none.
pub fn render(scene: &Scene) -> ReferenceImage {
    if is_of_densities(scene) {
        return density::render(scene);
    }
    picture(&frame::Frame::new(scene, 0.0), scene)
}

/// The same by cells, and with sections merged, as far as `settings.tolerance` allows (model §§7, 16).
///
/// # Panics
/// As [`render`].
pub fn render_within_tolerance(scene: &Scene) -> ReferenceImage {
    if is_of_densities(scene) {
        return density::render(scene);
    }
    picture(&frame::Frame::new(scene, scene.settings.tolerance), scene)
}

/// Both the picture and its [`undecided_pixels`], in the time that one of them takes in isosurfaces.
///
/// # Panics
/// As [`render`].
pub fn render_with_undecided(scene: &Scene) -> (ReferenceImage, Vec<bool>) {
    if scene.settings.mode == Mode::Isosurfaces && is_of_densities(scene) {
        return density::with_undecided_isosurfaces(scene);
    }
    (render(scene), undecided_pixels(scene))
}

/// Whether sheets sum densities: for `post-classified`, and in the modes of §12.
fn is_of_densities(scene: &Scene) -> bool {
    let has_densities = scene.settings.method == Method::PostClassified
        || scene.settings.mode.compositing().is_none();
    has_densities && !scene.layers.is_empty()
}

fn picture(frame: &frame::Frame, scene: &Scene) -> ReferenceImage {
    let (width, height) = (scene.image.width, scene.image.height);
    let surfaces = mesh::Surfaces::new(scene, &frame.view);
    let rows: Vec<Vec<[f64; 4]>> =
        (0..height).into_par_iter().map(|y| row::row(frame, &surfaces, y)).collect();
    ReferenceImage { width, height, pixels: rows.concat() }
}
