//! Sensible defaults for a volume that nobody has described: what is visible, and from where.

use rayon::prelude::*;
use slabsplat_core::glam::{BVec3, DVec3};
use slabsplat_core::{
    Camera, CameraError, Grid, ImageDesc, Layer, Projection, RenderSettings, Sample, Scaling,
    Scene, TransferFunction, Volume, with_samples,
};
use std::sync::Arc;

/// Defaults that fit one volume.
#[derive(Clone, Debug)]
pub struct Automatic {
    volume: Arc<Volume>,
    transfer: TransferFunction,
}

/// Levels into which values are counted.
const N_BINS: usize = 512;

/// Voxels that a thread counts at a time.
const CHUNK_LEN: usize = 1 << 16;

/// Share of the largest values that count as one: a few stray voxels must not stretch the ramp.
const OUTLIERS: f64 = 1e-4;

/// Opacities per unit at the top of the ramp and at the largest value.
const RAMP_OPACITY: [f64; 2] = [0.6, 0.9];

/// Dark to light, as the eye expects of a lit solid: the same hue order as bone or tissue.
const COLORS: [[f64; 3]; 3] = [[0.55, 0.25, 0.2], [0.85, 0.55, 0.45], [1.0, 0.93, 0.85]];

/// Vertical field of view of the automatic perspective camera.
const FOV_Y_RADIANS: f64 = 30.0 * std::f64::consts::PI / 180.0;

/// Room that a picture has around the box of a mesh, as a part of that.
const MARGIN_OF_BOX: f64 = 0.05;

/// Voxel steps around the grid that kernels cover.
const MARGIN_VOXELS: f64 = 2.0;

impl Automatic {
    /// Looks at all of the volume's values.
    pub fn new(volume: impl Into<Arc<Volume>>) -> Self {
        let volume = volume.into();
        Self { transfer: transfer_of(&volume), volume }
    }

    /// A ramp of opacity that begins where Otsu's threshold parts the background from the object
    /// (N. Otsu, "A threshold selection method from gray-level histograms", IEEE Trans. SMC 9(1),
    /// 1979) and reaches its height at the object's mean.
    pub fn transfer(&self) -> &TransferFunction {
        &self.transfer
    }

    /// A camera on the world's +x, +y, +z side with z upwards, whose picture the volume fills.
    pub fn camera(&self, image: &ImageDesc, is_perspective: bool) -> Camera {
        let seen = Extent { grids: &[*self.volume.grid()], boxes: &[] };
        fitting_camera(seen, image, is_perspective)
            .expect("the eye is off the z axis, and a grid is not too far from the origin to tell")
    }

    /// The defaults as a whole scene: orthographic, lit by a headlight.
    pub fn scene(&self, image: ImageDesc, settings: RenderSettings) -> Scene {
        let layer = Layer::new(self.volume.clone(), self.transfer.clone());
        Scene::new(layer, self.camera(&image, false)).image(image).settings(settings)
    }
}

/// What a picture is to hold.
#[derive(Clone, Copy)]
pub(crate) struct Extent<'a> {
    /// Those of volumes.
    pub(crate) grids: &'a [Grid],
    /// The least and the greatest corner of boxes around all else.
    pub(crate) boxes: &'a [[DVec3; 2]],
}

/// A camera on the world's +x, +y, +z side with z upwards, whose picture all of that fills.
///
/// # Errors
/// If meshes are so large or so far away that no number holds where it is.
pub(crate) fn fitting_camera(
    seen: Extent<'_>,
    image: &ImageDesc,
    is_perspective: bool,
) -> Result<Camera, CameraError> {
    let target = seen.center();
    let to_eye = DVec3::new(0.78, 0.50, 0.38).normalize();
    let radius = seen.reach(DVec3::length);
    let aspect = f64::from(image.width) / f64::from(image.height);
    let (projection, distance) = if is_perspective {
        let half_angle = (0.5 * FOV_Y_RADIANS).tan() * aspect.min(1.0);
        let distance = radius / half_angle.atan().sin();
        (Projection::Perspective { fov_y_radians: FOV_Y_RADIANS }, distance)
    } else {
        let view_height = fitting_height(seen, to_eye, aspect);
        (Projection::Orthographic { view_height }, 3.0 * radius)
    };
    Camera::new(target + to_eye * distance, target, DVec3::Z, projection)
}

/// World height of an orthographic picture that holds all.
fn fitting_height(seen: Extent<'_>, to_eye: DVec3, aspect: f64) -> f64 {
    let right = (-to_eye).cross(DVec3::Z).normalize();
    let up = right.cross(-to_eye);
    let extent = |axis: DVec3| seen.reach(|from_target| from_target.dot(axis).abs());
    2.0 * extent(up).max(extent(right) / aspect)
}

impl Extent<'_> {
    /// The middle: of a single grid, or of the box around all.
    fn center(&self) -> DVec3 {
        if self.boxes.is_empty() {
            return Grid::center_of_all(self.grids);
        }
        let of_grids = self.grids.iter().flat_map(Grid::corners_in_world).map(|it| [it; 2]);
        let all = of_grids.chain(self.boxes.iter().copied());
        let nothing = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let [min, max] = all.fold(nothing, |[min, max], [a, b]| [min.min(a), max.max(b)]);
        min.midpoint(max)
    }

    /// The most that any corner is away from the middle, by that measure, and what kernels cover around it.
    fn reach(&self, measure: impl Fn(DVec3) -> f64) -> f64 {
        let center = self.center();
        let of_grid = |grid: &Grid| {
            let corners = grid.corners_in_world().map(|corner| measure(corner - center));
            corners.fold(0.0, f64::max) + MARGIN_VOXELS * grid.unit()
        };
        let of_box = |[min, max]: &[DVec3; 2]| {
            let corners = (0..8).map(|corner: u8| {
                let is_far = [0, 1, 2].map(|axis| corner >> axis & 1 == 1);
                measure(DVec3::select(BVec3::from_array(is_far), *max, *min) - center)
            });
            (1.0 + MARGIN_OF_BOX) * corners.fold(0.0, f64::max)
        };
        let of_all = self.grids.iter().map(of_grid).chain(self.boxes.iter().map(of_box));
        of_all.fold(0.0, f64::max)
    }
}

fn transfer_of(volume: &Volume) -> TransferFunction {
    // Without two values that can be distinguished, all is visible.
    let flat = || (vec![(0.0, [RAMP_OPACITY[0]])], vec![(0.0, COLORS[2])]);
    let ramp = Histogram::of(volume).and_then(|histogram| histogram.ramp());
    let (opacity, color) = ramp.unwrap_or_else(flat);
    TransferFunction::new(opacity, color).expect("the ramp rises from finite value to finite value")
}

/// The values of samples that have one.
fn finite<T: Sample>(samples: &[T], scaling: Scaling) -> impl Iterator<Item = f64> {
    samples.iter().map(move |sample| scaling.apply(sample.to_f64())).filter(|v| v.is_finite())
}

/// How many voxels have which value, without NaN and infinities.
struct Histogram {
    min: f64,
    bin_width: f64,
    counts: Vec<u64>,
}

type Points<const N: usize> = Vec<(f64, [f64; N])>;

impl Histogram {
    /// `None` if fewer than two values differ.
    fn of(volume: &Volume) -> Option<Self> {
        with_samples!(volume.samples(), |samples| Self::of_samples(samples, volume.scaling()))
    }

    fn of_samples<T: Sample>(samples: &[T], scaling: Scaling) -> Option<Self> {
        let chunks = || samples.par_chunks(CHUNK_LEN).map(|chunk| finite(chunk, scaling));
        let extremes = chunks().map(|values| {
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), value| {
                (value.min(min), value.max(max))
            })
        });
        let (min, max) = extremes.reduce(
            || (f64::INFINITY, f64::NEG_INFINITY),
            |(min, max), (a, b)| (min.min(a), max.max(b)),
        );
        let bin_width = (max - min) / N_BINS as f64;
        if !bin_width.is_normal() || bin_width < 0.0 {
            return None;
        }
        let counts = chunks().map(|values| {
            let mut counts = vec![0; N_BINS];
            for value in values {
                counts[(((value - min) / bin_width) as usize).min(N_BINS - 1)] += 1;
            }
            counts
        });
        let sum = |mut a: Vec<u64>, b: Vec<u64>| {
            a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
            a
        };
        let counts = counts.reduce(|| vec![0; N_BINS], sum);
        Some(Self { min, bin_width, counts })
    }

    /// Opacity and colour over the values from background to object; `None` if these are so close that
    /// no number lies between them.
    fn ramp(&self) -> Option<(Points<1>, Points<3>)> {
        let threshold = self.otsu();
        let object_mean = self.mean_from(threshold + 1);
        let foot = self.value(threshold as f64 + 1.0);
        // The object may be smaller than what counts as outliers.
        let top = self.value(self.last_bin().max(threshold + 1) as f64 + 1.0);
        // A flat object has its mean at the threshold: keep the three points apart.
        let shoulder = object_mean.clamp(foot + 0.02 * (top - foot), foot + 0.9 * (top - foot));
        let start = foot - 0.35 * (shoulder - foot);
        if shoulder <= start || top <= shoulder {
            return None;
        }
        let opacity = vec![(start, [0.0]), (shoulder, [RAMP_OPACITY[0]]), (top, [RAMP_OPACITY[1]])];
        let color = vec![(start, COLORS[0]), (shoulder, COLORS[1]), (top, COLORS[2])];
        Some((opacity, color))
    }

    /// The value at a place among the bins.
    fn value(&self, bin: f64) -> f64 {
        self.min + bin * self.bin_width
    }

    /// The last bin of the background: the split with the largest variance between its two sides, or
    /// the middle of such splits if a gap in the values makes many of them equal.
    fn otsu(&self) -> usize {
        let total: f64 = self.counts.iter().map(|&c| c as f64).sum();
        let total_moment: f64 = self.moments().sum();
        let (mut below, mut moment_below) = (0.0, 0.0);
        let (mut best, mut first, mut last) = (0.0, 0, 0);
        for (bin, moment) in self.moments().enumerate().take(N_BINS - 1) {
            below += self.counts[bin] as f64;
            moment_below += moment;
            let above = total - below;
            let apart = moment_below / below - (total_moment - moment_below) / above;
            let between = below * above * apart * apart;
            if best < between {
                (best, first, last) = (between, bin, bin);
            } else if best == between {
                last = bin;
            }
        }
        usize::midpoint(first, last)
    }

    fn moments(&self) -> impl Iterator<Item = f64> + '_ {
        self.counts.iter().enumerate().map(|(bin, &count)| bin as f64 * count as f64)
    }

    fn mean_from(&self, first: usize) -> f64 {
        let (count, moment) = self
            .moments()
            .zip(&self.counts)
            .skip(first)
            .fold((0.0, 0.0), |(n, m), (moment, &count)| (n + count as f64, m + moment));
        self.value(if 0.0 < count { moment / count + 0.5 } else { first as f64 })
    }

    /// The last bin that matters.
    fn last_bin(&self) -> usize {
        let total: u64 = self.counts.iter().sum();
        let mut allowed = (total as f64 * OUTLIERS) as u64;
        for (bin, &count) in self.counts.iter().enumerate().rev() {
            if allowed < count {
                return bin;
            }
            allowed -= count;
        }
        N_BINS - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::{Samples, Scaling};

    fn row(samples: Vec<f32>) -> Volume {
        let grid = Grid::with_spacing([samples.len(), 1, 1], [1.0, 2.0, 3.0]).unwrap();
        Volume::new(grid, Samples::F32(samples), Scaling::IDENTITY).unwrap()
    }

    #[test]
    fn automatic_transfer_parts_object_from_background() {
        let mut samples: Vec<f32> = (0..800).map(|i| (i % 10) as f32).collect();
        samples.extend((0..200).map(|i| 100.0 + (i % 20) as f32));
        samples.extend([f32::NAN, f32::INFINITY]);
        let transfer = Automatic::new(row(samples)).transfer().clone();
        assert_eq!(transfer.opacity(9.0), 0.0, "background");
        assert!(0.3 < transfer.opacity(110.0), "object");
        assert!(0.8 < transfer.opacity(119.0), "{transfer:?}");
    }

    #[test]
    fn automatic_transfer_shows_what_has_no_contrast() {
        for samples in [vec![3.0; 4], vec![f32::NAN; 2], vec![f32::INFINITY; 2], vec![0.0, 1e-45]] {
            let volume = Arc::new(row(samples.clone()));
            let transfer = Automatic::new(volume.clone()).transfer().clone();
            let last = volume.value(samples.len() - 1);
            assert!(0.0 < transfer.opacity(last), "{samples:?}");
        }
    }

    #[test]
    fn automatic_transfer_finds_a_single_voxel() {
        let mut samples = vec![0.0; 40_000];
        samples[77] = 255.0;
        let transfer = Automatic::new(row(samples)).transfer().clone();
        assert!(transfer.opacity(0.0) == 0.0 && 0.5 < transfer.opacity(255.0), "{transfer:?}");
    }

    #[test]
    fn automatic_transfer_of_neighbouring_numbers() {
        let grid = Grid::with_spacing([2, 1, 1], [1.0; 3]).unwrap();
        let samples = vec![1.0_f64.next_up(), 1.0_f64.next_up().next_up()];
        let volume = Volume::new(grid, samples.into(), Scaling::IDENTITY).unwrap();
        assert!(0.0 < Automatic::new(volume).transfer().opacity(1.0));
    }

    /// All corners of the grid lie inside the picture, and close to an edge of it.
    #[test]
    fn automatic_camera_fits_the_volume() {
        let grid = Grid::with_spacing([20, 15, 6], [1.0, 1.2, 3.0]).unwrap();
        let samples = vec![1_u8; grid.n_voxels()];
        let volume = Volume::new(grid, samples.into(), Scaling::IDENTITY).unwrap();
        let automatic = Automatic::new(volume);
        for (width, height) in [(100, 100), (200, 50), (50, 200)] {
            let image = ImageDesc { width, height, background: [0.0; 4] };
            for is_perspective in [false, true] {
                let camera = automatic.camera(&image, is_perspective);
                let view =
                    slabsplat_core::View::new(automatic.volume.grid(), &camera, &image).unwrap();
                let from_index = view.from_index(automatic.volume.grid());
                let mut farthest: f64 = 0.0;
                for corner in automatic.volume.grid().corners_in_world() {
                    let in_index =
                        automatic.volume.grid().index_from_world().transform_point3(corner);
                    let at = from_index.transform(in_index);
                    let scale = view.pixels_per_world(at.z);
                    let x = (at.x * scale).abs() / (0.5 * f64::from(width));
                    let y = (at.y * scale).abs() / (0.5 * f64::from(height));
                    farthest = farthest.max(x).max(y);
                }
                assert!(farthest < 1.0, "{width}x{height} {is_perspective}: {farthest}");
                assert!(0.6 < farthest, "{width}x{height} {is_perspective}: {farthest}");
            }
        }
    }
}
