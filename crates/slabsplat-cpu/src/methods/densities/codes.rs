//! Values by eight bits, and the least and the largest of those around a voxel.
//!
//! ```text
//! for a block of voxels, with as many around it as matter:
//!     code its values
//!     along each axis: join every code with those of a window, which grows threefold each time
//! ```
//!
//! A block and its copy stay in a core's caches. Codes of a whole volume would take two bytes a voxel, and be
//! moved through memory a dozen times.

use slabsplat_core::{Cancelled, FrameHandle, IsoRange, Volume};
use std::ops::Range;

/// Takes values to codes: finite ones to `FIRST..=LAST`, infinities to what lies beside. The least and the
/// largest value have codes of their own, since what is around an object often has one value, and the object
/// is visible from the next one on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coder {
    ends: [f64; 2],
    /// Half of the least value, and of the extent of all, so that no difference is infinite.
    half_least: f64,
    half_extent: f64,
}

const FIRST: u8 = 1;
const LAST: u8 = 253;

/// Codes between the least and the largest value's.
const N_BETWEEN: f64 = (LAST - FIRST - 1) as f64;

impl Coder {
    pub(super) fn new(finite: Option<[f64; 2]>) -> Self {
        let [lo, hi] = finite.unwrap_or([0.0; 2]);
        Self { ends: [lo, hi], half_least: 0.5 * lo, half_extent: 0.5 * hi - 0.5 * lo }
    }

    /// The code of a voxel's value; `None` of a NaN.
    pub(super) fn code_of(&self, volume: &Volume, voxel_idx: usize) -> Option<u8> {
        let value = volume.value(voxel_idx);
        (!value.is_nan()).then(|| self.code(value))
    }

    fn code(&self, value: f64) -> u8 {
        if value.is_infinite() {
            return if value < 0.0 { FIRST - 1 } else { LAST + 1 };
        }
        if value <= self.ends[0] {
            return FIRST;
        }
        if self.ends[1] <= value {
            return LAST;
        }
        let between = (0.5 * value - self.half_least) / self.half_extent;
        FIRST + 1 + (between * N_BETWEEN).clamp(0.0, N_BETWEEN - 1.0) as u8
    }

    /// Half of what a code's values are at least, and of what they are at most. Between the ends a code's
    /// width is added on either side for rounding.
    fn half_ends(&self, code: u8) -> [f64; 2] {
        let step = self.half_extent / N_BETWEEN;
        let end = |steps: f64| self.half_least + steps * step;
        match code {
            ..FIRST => [f64::NEG_INFINITY, end(1.0)],
            FIRST => [0.5 * self.ends[0]; 2],
            LAST => [0.5 * self.ends[1]; 2],
            code if code < LAST => {
                let steps = f64::from(code - FIRST - 1);
                [end(steps - 1.0), end(steps + 2.0)]
            }
            _ => [end(N_BETWEEN - 1.0), f64::INFINITY],
        }
    }

    /// Whether anything shows between values of a least and a largest code, and as far outside as densities
    /// may lie.
    pub(super) fn visible_pairs(
        &self,
        (ranges, beyond): (&[IsoRange], f64),
        frame: &FrameHandle,
    ) -> Result<Vec<[bool; 256]>, Cancelled> {
        let is_visible = |least: usize, largest: usize| {
            // Half of the least number above 0 is 0: where all is of one value, it is that which counts.
            for (code, value) in [FIRST, LAST].into_iter().zip(self.ends) {
                if [least, largest] == [usize::from(code); 2] {
                    return ranges.iter().any(|range| (range.lo..=range.hi).contains(&value));
                }
            }
            let lo = self.half_ends(least as u8)[0];
            let hi = self.half_ends(largest as u8)[1];
            let over = beyond * (hi - lo);
            let (lo, hi) = (lo - over, hi + over);
            ranges.iter().any(|range| 0.5 * range.lo <= hi && lo <= 0.5 * range.hi)
        };
        let row = |least: usize| {
            frame.check()?;
            Ok(std::array::from_fn(|largest| least <= largest && is_visible(least, largest)))
        };
        (0..256).map(row).collect()
    }
}

/// The codes of a block of voxels, or of neighbourhoods of them: the least and the largest. Made to be used
/// again.
#[derive(Debug, Default)]
pub(super) struct CodeBlock {
    /// Which voxels, along each axis.
    voxels: [Range<usize>; 3],
    least: Vec<u8>,
    largest: Vec<u8>,
    /// What one of them was before.
    copy: Vec<u8>,
}

/// Codes that are joined between two looks at whether anyone still wants them.
const CHUNK: usize = 1 << 16;

impl CodeBlock {
    /// Makes every code that of the values within `margin` steps along each axis, in those voxels; those of
    /// others are of no meaning.
    pub(super) fn make(
        &mut self,
        (volume, coder): (&Volume, &Coder),
        voxels: &[Range<usize>; 3],
        margin: [usize; 3],
        frame: &FrameHandle,
    ) -> Result<(), Cancelled> {
        let dims = volume.grid().dims();
        self.voxels = [0, 1, 2].map(|axis: usize| {
            let Range { start, end } = voxels[axis];
            start.saturating_sub(margin[axis])..(end + margin[axis]).min(dims[axis])
        });
        self.code(volume, coder, frame)?;
        let mut stride = 1;
        for (margin, voxels) in margin.into_iter().zip(&self.voxels) {
            let block = stride * voxels.len();
            for codes in self.least.chunks_mut(block) {
                widen(codes, stride, margin, u8::min, &mut self.copy, frame)?;
            }
            for codes in self.largest.chunks_mut(block) {
                widen(codes, stride, margin, u8::max, &mut self.copy, frame)?;
            }
            stride = block;
        }
        Ok(())
    }

    /// Codes the values of all voxels; a NaN counts as nothing.
    fn code(
        &mut self,
        volume: &Volume,
        coder: &Coder,
        frame: &FrameHandle,
    ) -> Result<(), Cancelled> {
        let [n_x, n_y, _] = volume.grid().dims();
        let [xs, ys, zs] = self.voxels.clone();
        self.least.clear();
        self.largest.clear();
        for z in zs {
            for y in ys.clone() {
                frame.check()?;
                let row = (z * n_y + y) * n_x;
                for x in xs.clone() {
                    let code = coder.code_of(volume, row + x);
                    self.least.push(code.unwrap_or(u8::MAX));
                    self.largest.push(code.unwrap_or(0));
                }
            }
        }
        Ok(())
    }

    /// The least and the largest code of a row of voxels.
    pub(super) fn row(&self, xs: Range<usize>, y: usize, z: usize) -> [&[u8]; 2] {
        let [of_x, of_y, of_z] = &self.voxels;
        let row = (z - of_z.start) * of_y.len() + (y - of_y.start);
        let at = row * of_x.len();
        let idxs = at + xs.start - of_x.start..at + xs.end - of_x.start;
        [&self.least[idxs.clone()], &self.largest[idxs]]
    }
}

/// Makes every code that of all voxels within `margin` steps, `stride` codes apart.
fn widen(
    codes: &mut [u8],
    stride: usize,
    margin: usize,
    join: impl Fn(u8, u8) -> u8,
    copy: &mut Vec<u8>,
    frame: &FrameHandle,
) -> Result<(), Cancelled> {
    let mut reached = 0;
    while reached < margin {
        frame.check()?;
        // Three windows side by side, or overlapping, make one.
        let step = (2 * reached + 1).min(margin - reached);
        copy.clear();
        copy.extend_from_slice(codes);
        join_moved(codes, copy, stride, step, |out, codes| {
            let chunks = out.chunks_mut(CHUNK).zip(codes.chunks(CHUNK));
            for (out, codes) in chunks.take_while(|_| !frame.is_cancelled()) {
                out.iter_mut().zip(codes).for_each(|(out, &code)| *out = join(*out, code));
            }
        });
        reached += step;
    }
    Ok(())
}

/// Joins every code with those `step` steps before and after it.
fn join_moved(
    out: &mut [u8],
    codes: &[u8],
    stride: usize,
    step: usize,
    join: impl Fn(&mut [u8], &[u8]),
) {
    let offset = step * stride;
    let n_moved = codes.len().saturating_sub(offset);
    if 0 < n_moved {
        join(&mut out[..n_moved], &codes[offset..]);
        join(&mut out[offset..], &codes[..n_moved]);
    }
    // The window of a voxel outside of the block reaches into it no further than that of the last one inside.
    let last = codes.len() - stride;
    for out in out[n_moved..].chunks_mut(stride) {
        join(out, &codes[last..]);
    }
    for out in out[..codes.len() - n_moved].chunks_mut(stride) {
        join(out, &codes[..stride]);
    }
}
