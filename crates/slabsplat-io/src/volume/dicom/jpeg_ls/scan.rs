//! The samples of a scan, a line after the other (T.87 §A).
//!
//! ```text
//! for every pixel:
//!     if the neighbours to the left and above are alike: a run of the left one, and the sample that ends it
//!     else of every component: a prediction from the neighbours, corrected by its context, and the error
//! ```

use super::super::segments::Broken;
use super::Interleave;
use super::bits::Bits;
use super::contexts::{Context, RunContext};
use super::presets::Coding;

/// Bits of the lengths of runs, by how many runs went on before, J (§A.2.1).
const RUN_BITS: [u32; 32] = [
    0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3, 4, 4, 5, 5, 6, 6, 7, 7, 8, 9, 10, 11, 12, 13,
    14, 15,
];

/// Kinds of differences between neighbours: nine of each of three, less those that differ in sign.
const N_CONTEXTS: usize = 365;

/// A scan, as far as it was read.
pub(super) struct Scan<'p> {
    bits: Bits<'p>,
    coder: Coder,
    lanes: Vec<Lane>,
    /// Of each component, how far runs went.
    run_indices: Vec<usize>,
}

/// What samples are predicted by.
struct Coder {
    coding: Coding,
    contexts: Vec<Context>,
    /// Of samples that end runs, whose left and upper neighbours differ, and are the same.
    run_contexts: [RunContext; 2],
}

/// Two lines of a component, each with a sample before its first and after its last.
struct Lane {
    above: Vec<i32>,
    line: Vec<i32>,
}

/// The decoded neighbours of a sample: to the left, above, above to the left and above to the right.
#[derive(Clone, Copy)]
struct Neighbours {
    a: i32,
    b: i32,
    c: i32,
    d: i32,
}

impl<'p> Scan<'p> {
    pub(super) fn new(
        bytes: &'p [u8],
        coding: Coding,
        n_columns: usize,
        n_components: usize,
    ) -> Self {
        let zeros = || vec![0; n_columns + 2];
        Self {
            bits: Bits::of(bytes),
            lanes: (0..n_components).map(|_| Lane { above: zeros(), line: zeros() }).collect(),
            run_indices: vec![0; n_components],
            coder: Coder {
                contexts: vec![Context::new(&coding); N_CONTEXTS],
                run_contexts: [false, true].map(|are_same| RunContext::new(&coding, are_same)),
                coding,
            },
        }
    }

    pub(super) fn n_read(&self) -> usize {
        self.bits.n_read()
    }

    /// Decodes a line of all components into its pixels.
    pub(super) fn line(
        &mut self,
        pixels: &mut [&mut [i32]],
        interleave: Interleave,
    ) -> Result<(), Broken> {
        let Self { bits, coder, lanes, run_indices } = self;
        lanes.iter_mut().for_each(Lane::advance);
        match interleave {
            Interleave::Samples => coder.line(bits, lanes, &mut run_indices[0])?,
            Interleave::None | Interleave::Lines => {
                for (lane, run_idx) in lanes.iter_mut().zip(run_indices) {
                    coder.line(bits, std::slice::from_mut(lane), run_idx)?;
                }
            }
        }
        for (component, lane) in lanes.iter().enumerate() {
            for (pixel, sample) in pixels.iter_mut().zip(&lane.line[1..]) {
                pixel[component] = *sample;
            }
        }
        Ok(())
    }
}

impl Lane {
    /// Goes to the next line, with what its edges have for neighbours (§A.2.1, figure A.1).
    fn advance(&mut self) {
        std::mem::swap(&mut self.above, &mut self.line);
        let n = self.above.len();
        self.above[n - 1] = self.above[n - 2];
        self.line[0] = self.above[1];
    }

    fn neighbours(&self, x: usize) -> Neighbours {
        let [c, b, d] = [self.above[x - 1], self.above[x], self.above[x + 1]];
        Neighbours { a: self.line[x - 1], b, c, d }
    }
}

impl Neighbours {
    fn differences(&self) -> [i32; 3] {
        [self.d - self.b, self.b - self.c, self.c - self.a]
    }

    /// The median edge detector (§A.4.1).
    fn predicted(&self) -> i32 {
        let Self { a, b, c, .. } = *self;
        if a.max(b) <= c {
            a.min(b)
        } else if c <= a.min(b) {
            a.max(b)
        } else {
            a + b - c
        }
    }
}

impl Coder {
    /// Decodes a line of some components whose runs go together.
    fn line(
        &mut self,
        bits: &mut Bits<'_>,
        lanes: &mut [Lane],
        run_idx: &mut usize,
    ) -> Result<(), Broken> {
        let n_columns = lanes[0].line.len() - 2;
        let mut x = 1;
        while x <= n_columns {
            let near = self.coding.near;
            let is_flat = |lane: &Lane| {
                lane.neighbours(x).differences().iter().all(|difference| difference.abs() <= near)
            };
            if lanes.iter().all(is_flat) {
                x = self.run(bits, lanes, x, run_idx)?;
                continue;
            }
            for lane in &mut *lanes {
                lane.line[x] = self.predicted(bits, lane.neighbours(x))?;
            }
            x += 1;
        }
        Ok(())
    }

    /// A sample by its prediction (§A.3 to §A.5).
    fn predicted(&mut self, bits: &mut Bits<'_>, near: Neighbours) -> Result<i32, Broken> {
        let [q1, q2, q3] = near.differences().map(|difference| self.quantised(difference));
        let kind = 81 * q1 + 9 * q2 + q3;
        let sign = if kind < 0 { -1 } else { 1 };
        let context = &mut self.contexts[kind.unsigned_abs() as usize];
        let correction = sign * context.correction;
        let prediction = (near.predicted() + correction).clamp(0, self.coding.max_value);
        let error = sign * context.read(bits, &self.coding)?;
        Ok(self.reconstructed(prediction, error))
    }

    /// A difference as one of nine, −4 … 4 (§A.3.3).
    fn quantised(&self, difference: i32) -> i32 {
        let [t1, t2, t3] = self.coding.thresholds;
        let size = difference.abs();
        let n = [self.coding.near + 1, t1, t2, t3].iter().filter(|least| **least <= size).count();
        n as i32 * difference.signum()
    }

    /// What a prediction and its error make; errors are counted round RANGE (§A.4.4, §A.5.4).
    fn reconstructed(&self, prediction: i32, error: i32) -> i32 {
        let Coding { near, max_value, range, .. } = self.coding;
        let step = 2 * near + 1;
        let value = prediction + error * step;
        let value = if value < -near {
            value + range * step
        } else if max_value + near < value {
            value - range * step
        } else {
            value
        };
        value.clamp(0, max_value)
    }

    /// A run from `x` on, and the pixel that ends it unless the line does; returns where it continues
    /// (§A.7.1).
    fn run(
        &mut self,
        bits: &mut Bits<'_>,
        lanes: &mut [Lane],
        mut x: usize,
        run_idx: &mut usize,
    ) -> Result<usize, Broken> {
        let end = lanes[0].line.len() - 1;
        let first = x;
        while bits.read(1)? == 1 {
            let n_run = 1 << RUN_BITS[*run_idx];
            if end - x < n_run {
                x = end;
                break;
            }
            x += n_run;
            *run_idx = (*run_idx + 1).min(31);
            if x == end {
                break;
            }
        }
        let is_whole = x == end;
        if !is_whole {
            x += bits.read(RUN_BITS[*run_idx])? as usize;
            if end <= x {
                return Err("a run is longer than its line");
            }
        }
        for lane in &mut *lanes {
            let value = lane.line[first - 1];
            lane.line[first..x].fill(value);
        }
        if is_whole {
            return Ok(x);
        }
        self.end_of_run(bits, lanes, x, *run_idx)?;
        *run_idx = run_idx.saturating_sub(1);
        Ok(x + 1)
    }

    /// The pixel that ends a run (§A.7.2).
    fn end_of_run(
        &mut self,
        bits: &mut Bits<'_>,
        lanes: &mut [Lane],
        x: usize,
        run_idx: usize,
    ) -> Result<(), Broken> {
        let limit = self.coding.limit - RUN_BITS[run_idx] - 1;
        // Samples that come together are all coded as those whose neighbours differ.
        let is_alone = lanes.len() == 1;
        for lane in lanes {
            let Neighbours { a, b, .. } = lane.neighbours(x);
            let are_same = is_alone && (a - b).abs() <= self.coding.near;
            let context = &mut self.run_contexts[usize::from(are_same)];
            let error = context.read(bits, &self.coding, limit)?;
            let (prediction, sign) =
                if are_same { (a, 1) } else { (b, if b < a { -1 } else { 1 }) };
            lane.line[x] = self.reconstructed(prediction, sign * error);
        }
        Ok(())
    }
}
