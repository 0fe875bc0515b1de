//! What figures 2, 6 and 7 share: the cube's pictures as they are shown, and its brightness as a plot.

use super::plot::{Axis, Line, Scale, plot};
use super::red;
use slabsplat::paper::{CUBE_PIXELS_PER_VOXEL, column_means};
use slabsplat::{Image, Scene};

/// How much larger the pictures that are shown are than those that are measured.
const MAGNIFICATION: u32 = 3;

/// The scene with more pixels of the same view, on black.
pub(super) fn magnified(mut scene: Scene) -> Scene {
    scene.image.width *= MAGNIFICATION;
    scene.image.height *= MAGNIFICATION;
    scene.image.background = [0.0, 0.0, 0.0, 1.0];
    scene
}

/// Brightness across a picture of the cube.
pub(super) fn profile(label: String, image: &Image) -> Line {
    let columns = column_means(red(image));
    let middle = columns.len() as f64 / 2.0;
    let steps = |column: usize| (column as f64 + 0.5 - middle) / CUBE_PIXELS_PER_VOXEL;
    let points = columns.iter().enumerate().map(|(column, mean)| [steps(column), *mean]);
    Line { label, points: points.collect() }
}

pub(super) fn profile_plot(lines: &[Line]) -> String {
    plot(
        "Brightness across the cube, over the height of its faces",
        &Axis {
            label: "voxel steps to the right of the edge between both faces",
            range: [-14.0, 14.0],
            ticks: &[-12.0, -8.0, -4.0, 0.0, 4.0, 8.0, 12.0],
            scale: Scale::Linear,
        },
        &Axis {
            label: "brightness",
            range: [0.0, 1.0],
            ticks: &[0.0, 0.25, 0.5, 0.75, 1.0],
            scale: Scale::Linear,
        },
        lines,
    )
}
