//! The finite values of a volume.

use rayon::prelude::*;
use slabsplat_backend::densities::{finite_samples, finite_values};
use slabsplat_core::{Cancelled, FrameHandle, Sample, Volume, with_samples};

/// The least and the largest finite value; `None` if there is none.
pub(super) fn finite_range(
    volume: &Volume,
    frame: &FrameHandle,
) -> Result<Option<[f64; 2]>, Cancelled> {
    let range = with_samples!(volume.samples(), |s| finite_range_of(s, frame));
    frame.check()?;
    Ok(finite_values(range, volume.scaling()))
}

fn finite_range_of<T: Sample>(samples: &[T], frame: &FrameHandle) -> [f64; 2] {
    let joined = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [a.min(c), b.max(d)];
    let empty = || [f64::INFINITY, f64::NEG_INFINITY];
    let wanted = samples.par_chunks(1 << 16).filter(|_| !frame.is_cancelled());
    wanted.map(finite_samples).reduce(empty, joined)
}
