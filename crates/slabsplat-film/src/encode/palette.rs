//! 255 colours for a whole film, and how a colour between them is shown.
//!
//! One palette for all frames, or what does not move would change its colour from frame to frame. It is found
//! from counts of all frames' colours by variance-based splitting (Wan, Prusinkiewicz & Wong 1988): whichever
//! box of colours is widest is cut where its two halves are narrowest. A colour between two of the palette is
//! a pattern of both by a fixed matrix (Bayer 1973), which stands still on the screen as error diffusion does
//! not.

/// Bits of a channel by which colours are counted.
const COUNTED_BITS: u32 = 6;

/// Colours of a palette: one of the 256 is kept for what does not change.
pub(super) const N_COLORS: usize = 255;

/// Counts of colours.
pub(super) struct Histogram {
    /// Pixels, and the sums of their channels.
    bins: Vec<[u64; 4]>,
}

impl Histogram {
    pub(super) fn new() -> Self {
        Self { bins: vec![[0; 4]; 1 << (3 * COUNTED_BITS)] }
    }

    pub(super) fn add(&mut self, rgb: &[u8]) {
        let shift = 8 - COUNTED_BITS;
        for &color in rgb.as_chunks::<3>().0 {
            let bin = color
                .iter()
                .fold(0, |bin, channel| bin << COUNTED_BITS | usize::from(channel >> shift));
            let bin = &mut self.bins[bin];
            bin[0] += 1;
            for (sum, channel) in bin[1..].iter_mut().zip(color) {
                *sum += u64::from(channel);
            }
        }
    }

    /// The palette of what was counted, at least one colour.
    pub(super) fn palette(&self) -> Palette {
        let colors: Vec<Counted> = self.bins.iter().filter_map(Counted::of).collect();
        let mut boxes = vec![ColorBox::of(colors)];
        while boxes.len() < N_COLORS {
            let errors = boxes.iter().map(|it| it.error).enumerate();
            let widest = errors.max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
            let Some((widest, error)) = widest.filter(|(_, error)| 0.0 < *error) else { break };
            debug_assert!(error.is_finite(), "counts are finite");
            let halves = boxes.swap_remove(widest).split();
            boxes.extend(halves);
        }
        Palette::new(boxes.iter().map(ColorBox::mean).collect())
    }
}

/// A colour, and how often it is there.
#[derive(Clone, Copy)]
struct Counted {
    color: [f64; 3],
    count: f64,
}

impl Counted {
    fn of(bin: &[u64; 4]) -> Option<Self> {
        let [n, sums @ ..] = *bin;
        let mean = |sum: u64| sum as f64 / n as f64;
        // What fills half of the picture is no reason to have nothing for the rest: square roots of counts.
        (0 < n).then(|| Self { color: sums.map(mean), count: (n as f64).sqrt() })
    }
}

struct ColorBox {
    colors: Vec<Counted>,
    /// The sum of squared distances from the mean along the widest axis, 0 if it cannot be split.
    error: f64,
    axis: usize,
}

impl ColorBox {
    fn of(colors: Vec<Counted>) -> Self {
        let n: f64 = colors.iter().map(|it| it.count).sum();
        let spread = |axis: usize| {
            let of = |power: i32| {
                colors.iter().map(|it| it.count * it.color[axis].powi(power)).sum::<f64>()
            };
            (of(2) - of(1) * of(1) / n).max(0.0)
        };
        let spreads = [0, 1, 2].map(spread);
        let axis =
            (0..3).fold(0, |best, axis| if spreads[best] < spreads[axis] { axis } else { best });
        let error = if colors.len() < 2 { 0.0 } else { spreads.iter().sum() };
        Self { colors, error, axis }
    }

    fn mean(&self) -> [u8; 3] {
        let n: f64 = self.colors.iter().map(|it| it.count).sum();
        let mean =
            |axis: usize| self.colors.iter().map(|it| it.count * it.color[axis]).sum::<f64>() / n;
        [0, 1, 2].map(|axis| mean(axis).round() as u8)
    }

    /// Two boxes that have a colour each, cut where they are narrowest along the axis.
    fn split(mut self) -> [Self; 2] {
        let axis = self.axis;
        self.colors.sort_by(|a, b| a.color[axis].total_cmp(&b.color[axis]));
        let total: [f64; 2] = self
            .colors
            .iter()
            .fold([0.0; 2], |[n, sum], it| [n + it.count, sum + it.count * it.color[axis]]);
        let (mut left, mut best) = ([0.0; 2], (f64::NEG_INFINITY, 1));
        for (idx, it) in self.colors.iter().enumerate().take(self.colors.len() - 1) {
            left = [left[0] + it.count, left[1] + it.count * it.color[axis]];
            let right = [total[0] - left[0], total[1] - left[1]];
            // The more the halves' means differ, the less is left within them.
            let between = left[1] * left[1] / left[0] + right[1] * right[1] / right[0];
            if best.0 < between {
                best = (between, idx + 1);
            }
        }
        let right = self.colors.split_off(best.1);
        [Self::of(self.colors), Self::of(right)]
    }
}

/// Bits of a channel by which the mixture of a colour is looked up.
const MIXED_BITS: u32 = 7;

/// Colours, and mixtures of two of them for all others.
pub(super) struct Palette {
    colors: Vec<[u8; 3]>,
    mixtures: Vec<Option<Mixture>>,
}

/// Two colours, and how many of 64 pixels have the second.
#[derive(Clone, Copy)]
struct Mixture {
    indices: [u8; 2],
    n_second: u8,
}

/// Thresholds 0 … 63, each once: from any 2ⁿ × 2ⁿ pixels as evenly as can be.
const fn bayer() -> [[u8; 8]; 8] {
    let mut matrix = [[0; 8]; 8];
    let mut y = 0;
    while y < 8 {
        let mut x = 0;
        while x < 8 {
            let (mut value, mut bit) = (0, 0);
            while bit < 3 {
                let (x_bit, y_bit) = (x >> bit & 1, y >> bit & 1);
                value |= ((x_bit ^ y_bit) << 1 | y_bit) << (2 * (2 - bit));
                bit += 1;
            }
            matrix[y][x] = value as u8;
            x += 1;
        }
        y += 1;
    }
    matrix
}

const BAYER: [[u8; 8]; 8] = bayer();

impl Palette {
    fn new(mut colors: Vec<[u8; 3]>) -> Self {
        colors.sort_unstable();
        colors.dedup();
        Self { colors, mixtures: vec![None; 1 << (3 * MIXED_BITS)] }
    }

    /// Red, green and blue of each colour.
    pub(super) fn bytes(&self) -> Vec<u8> {
        self.colors.concat()
    }

    /// The indices of a picture's pixels, row by row.
    pub(super) fn indices(&mut self, rgb: &[u8], width: usize) -> Vec<u8> {
        let pixels = rgb.as_chunks::<3>().0.iter().enumerate();
        let index = |(idx, &color): (usize, &[u8; 3])| {
            let Mixture { indices, n_second } = self.mixture(color);
            let threshold = BAYER[idx / width % 8][idx % width % 8];
            indices[usize::from(threshold < n_second)]
        };
        pixels.map(index).collect()
    }

    fn mixture(&mut self, color: [u8; 3]) -> Mixture {
        let shift = 8 - MIXED_BITS;
        let slot = color
            .iter()
            .fold(0, |slot, channel| slot << MIXED_BITS | usize::from(channel >> shift));
        if let Some(mixture) = self.mixtures[slot] {
            return mixture;
        }
        // All colours of a slot are mixed alike, whichever came first.
        let middle = color.map(|channel| f64::from(channel >> shift << shift) + 0.5);
        let mixture = self.best_mixture(middle);
        self.mixtures[slot] = Some(mixture);
        mixture
    }

    /// The nearest colour, and the one that is best mixed with it.
    fn best_mixture(&self, color: [f64; 3]) -> Mixture {
        let distance =
            |a: [f64; 3], b: [f64; 3]| -> f64 { (0..3).map(|c| (a[c] - b[c]).powi(2)).sum() };
        let of = |idx: usize| self.colors[idx].map(f64::from);
        let by = |value: &dyn Fn(usize) -> f64| {
            let all = (0..self.colors.len()).map(|idx| (value(idx), idx));
            all.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0, |(_, idx)| idx)
        };
        let first = by(&|idx| distance(of(idx), color));
        let near = of(first);
        let share = |idx: usize| {
            let along: [f64; 3] = std::array::from_fn(|c| of(idx)[c] - near[c]);
            let length: f64 = along.iter().map(|a| a * a).sum();
            let dot: f64 = (0..3).map(|c| along[c] * (color[c] - near[c])).sum();
            if length == 0.0 { 0.0 } else { (dot / length).clamp(0.0, 0.5) }
        };
        // What is mixed of two that are far apart looks rough, so that a distance costs, too.
        let second = by(&|idx| {
            let t = share(idx);
            let mixed = std::array::from_fn(|c| near[c] + t * (of(idx)[c] - near[c]));
            distance(mixed, color) + ROUGHNESS * t * (1.0 - t) * distance(near, of(idx))
        });
        let n_second = (64.0 * share(second)).round() as u8;
        Mixture { indices: [first as u8, second as u8], n_second }
    }
}

/// How much of the variance of a mixture counts as an error.
const ROUGHNESS: f64 = 0.2;

#[cfg(test)]
mod tests {
    use super::*;

    fn palette_of(rgb: &[u8]) -> Palette {
        let mut histogram = Histogram::new();
        histogram.add(rgb);
        histogram.palette()
    }

    #[test]
    fn palette_has_few_colors_as_they_are() {
        let rgb = [[0, 0, 0], [255, 0, 0], [10, 200, 30], [9, 9, 250]].concat();
        let mut palette = palette_of(&rgb);
        assert_eq!(palette.colors.len(), 4);
        let indices = palette.indices(&rgb, 4);
        let back: Vec<[u8; 3]> =
            indices.iter().map(|&idx| palette.colors[usize::from(idx)]).collect();
        assert_eq!(back.concat(), rgb);
    }

    #[test]
    fn palette_mixes_to_the_mean() {
        // A ramp in two channels has more colours than the palette; a mixture's mean is still the colour.
        let ramp: Vec<u8> = (0..=255_u8)
            .flat_map(|a| (0..=255_u8).step_by(5).flat_map(move |b| [a, b, 40]))
            .collect();
        let mut palette = palette_of(&ramp);
        assert_eq!(palette.colors.len(), N_COLORS);
        for color in [[30, 200, 40], [100, 100, 40], [220, 40, 40]] {
            let flat = color.repeat(64);
            let indices = palette.indices(&flat, 8);
            for channel in 0..3 {
                let sum: u32 = indices
                    .iter()
                    .map(|&i| u32::from(palette.colors[usize::from(i)][channel]))
                    .sum();
                let mean = f64::from(sum) / 64.0;
                assert!((mean - f64::from(color[channel])).abs() < 4.0, "{color:?} {mean}");
            }
        }
    }

    #[test]
    fn palette_pattern_depends_on_the_place_alone() {
        let ramp: Vec<u8> =
            (0..=255_u8).flat_map(|a| (0..=255_u8).flat_map(move |b| [a, b, 40])).collect();
        let mut palette = palette_of(&ramp);
        let still = [77, 91, 40].repeat(64);
        let alone = palette.indices(&still, 8);
        let beside: Vec<u8> = (0..64)
            .flat_map(|idx| if idx % 3 == 0 { [255, 0, 40] } else { [77, 91, 40] })
            .collect();
        let beside = palette.indices(&beside, 8);
        let unchanged = (0..64).filter(|idx| idx % 3 != 0);
        assert!(unchanged.into_iter().all(|idx| alone[idx] == beside[idx]));
    }

    #[test]
    fn bayer_has_each_threshold_once() {
        let mut all: Vec<u8> = BAYER.concat();
        all.sort_unstable();
        assert_eq!(all, (0..64).collect::<Vec<u8>>());
        assert_eq!(
            [BAYER[0][0], BAYER[1][1], BAYER[0][1], BAYER[1][0]].map(|t| t / 16),
            [0, 1, 2, 3]
        );
    }
}
