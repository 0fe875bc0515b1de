//! A transfer function as the shaders evaluate it: by segments of samples instead of points among values.
//!
//! Between two points a function of the value is linear, and so it is in the samples. Which samples lie there
//! is asked here, of the very function that the CPU classifies by, and answered in keys; so a step, be it as
//! narrow as two numbers that follow each other, parts the same samples on every device. What the function is
//! at a segment's first and last sample comes from here too: a shader only interpolates between them.

use crate::classification::Element;
use crate::number::Numbers;
use slabsplat_core::PiecewiseLinear;

/// A run of samples over which a function is linear.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Segment<const N: usize> {
    /// The key of its first sample.
    first_key: u64,
    /// The function there.
    at_first: [f64; N],
    /// Differences of samples are divided by two to this power.
    exponent: i32,
    /// By how much the function changes over such a difference of 1.
    slope: [f64; N],
}

/// The segments of a function, by rising keys; the first begins at the least key.
pub(crate) fn segments<const N: usize>(
    function: &PiecewiseLinear<N>,
    numbers: &Numbers,
) -> Vec<Segment<N>> {
    let positions = function.points().iter().map(|&(position, _)| position);
    segments_between(positions, |value| function.at(value), numbers)
}

/// The segments of a function that is linear between some positions, and beyond them.
pub(crate) fn segments_between<const N: usize>(
    positions: impl Iterator<Item = f64>,
    function: impl Fn(f64) -> [f64; N],
    numbers: &Numbers,
) -> Vec<Segment<N>> {
    let [least, largest] = numbers.keys();
    let mut starts = vec![least];
    starts.extend(positions.map(|position| first_key_behind(position, numbers)));
    starts.sort_unstable();
    starts.dedup();
    starts.retain(|&start| start <= largest);
    let ends = starts[1..].iter().copied().chain([largest + 1]);
    starts
        .iter()
        .zip(ends)
        .map(|(&first, end)| segment(&function, numbers, first, end - 1))
        .collect()
}

/// The first key of a sample on the far side of a point, which itself belongs to the larger values.
fn first_key_behind(position: f64, numbers: &Numbers) -> u64 {
    if numbers.is_falling() {
        numbers.first_key(|value| value < position)
    } else {
        numbers.first_key(|value| position <= value)
    }
}

fn segment<const N: usize>(
    function: &impl Fn(f64) -> [f64; N],
    numbers: &Numbers,
    first: u64,
    last: u64,
) -> Segment<N> {
    let [at_first, at_last] = [first, last].map(|key| function(numbers.value(key)));
    let (distance, exponent) = distance([first, last].map(|key| numbers.number(key)));
    let slope = std::array::from_fn(|channel| {
        let change = at_last[channel] - at_first[channel];
        // Also at the ends, where samples may be infinite.
        if change == 0.0 { 0.0 } else { change / distance }
    });
    Segment { first_key: first, at_first, exponent, slope }
}

/// How far apart two numbers are, as `distance · 2^exponent`, such that 32 bits can hold both.
fn distance([a, b]: [f64; 2]) -> (f64, i32) {
    let whole = b - a;
    // Of numbers at opposite ends half the distance is still finite.
    let (distance, halvings) = if whole.is_finite() { (whole, 0) } else { (0.5 * b - 0.5 * a, 1) };
    if distance == 0.0 || !distance.is_finite() {
        return (1.0, 0);
    }
    // Two to the power of it and of its opposite are normal numbers.
    let exponent = (distance.log2().floor() as i32).clamp(-1000, 1000);
    (distance * 2_f64.powi(-exponent), exponent + halvings)
}

/// As `shaders/shared/transfer.wgsl` reads it.
pub(crate) fn opacity_elements(segment: &Segment<1>, numbers: &Numbers) -> [Element; 2] {
    let ([opacity], [slope]) = (segment.at_first, segment.slope);
    [start_element(segment, numbers), element([opacity, 1.0 - opacity, slope])]
}

/// As `shaders/shared/transfer.wgsl` reads it.
pub(crate) fn color_elements(segment: &Segment<3>, numbers: &Numbers) -> [Element; 3] {
    [start_element(segment, numbers), element(segment.at_first), element(segment.slope)]
}

fn start_element<const N: usize>(segment: &Segment<N>, numbers: &Numbers) -> Element {
    let [high, low] = numbers.words(segment.first_key);
    [high, low, segment.exponent.cast_unsigned(), 0]
}

fn element([x, y, z]: [f64; 3]) -> Element {
    [x as f32, y as f32, z as f32, 0.0].map(f32::to_bits)
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::{Grid, Samples, Scaling, Volume};
    use slabsplat_seeds::for_each_seed;

    fn numbers(samples: Samples, scaling: Scaling) -> Numbers {
        let grid = Grid::with_spacing([samples.len(), 1, 1], [1.0; 3]).unwrap();
        Numbers::new(&Volume::new(grid, samples, scaling).unwrap())
    }

    fn one_of_each_type(scaling: Scaling) -> [Numbers; 8] {
        [
            numbers(vec![0_u8].into(), scaling),
            numbers(vec![0_i8].into(), scaling),
            numbers(vec![0_u16].into(), scaling),
            numbers(vec![0_i16].into(), scaling),
            numbers(vec![0_u32].into(), scaling),
            numbers(vec![0_i32].into(), scaling),
            numbers(vec![0.0_f32].into(), scaling),
            numbers(vec![0.0_f64].into(), scaling),
        ]
    }

    /// What a shader makes of a sample, in 64 bits.
    fn evaluated<const N: usize>(segments: &[Segment<N>], numbers: &Numbers, key: u64) -> [f64; N] {
        let n_begun = segments.partition_point(|segment| segment.first_key <= key);
        let segment = &segments[n_begun - 1];
        let [first, here] = [segment.first_key, key].map(|key| numbers.number(key));
        let (distance, exponent) = if first < here { distance([first, here]) } else { (0.0, 0) };
        let distance = distance * 2_f64.powi((exponent - segment.exponent).clamp(-1000, 1000));
        std::array::from_fn(|channel| segment.at_first[channel] + segment.slope[channel] * distance)
    }

    /// How much a function may change within a rounding of a value: scaling rounds, and a function that is as
    /// steep as that is not linear in the samples.
    fn change_within_rounding(function: &PiecewiseLinear<1>) -> f64 {
        let change = |pair: &[(f64, [f64; 1])]| {
            let ((x0, [y0]), (x1, [y1])) = (pair[0], pair[1]);
            let rounding = f64::EPSILON * x0.abs().max(x1.abs());
            if x0 < x1 {
                (y1 - y0).abs() * (rounding / (0.5 * x1 - 0.5 * x0)).min(1.0)
            } else {
                0.0
            }
        };
        function.points().windows(2).map(change).fold(0.0, f64::max)
    }

    fn check(function: &PiecewiseLinear<1>, numbers: &Numbers, keys: impl Iterator<Item = u64>) {
        let segments = segments(function, numbers);
        let rounding = if numbers.scales() { change_within_rounding(function) } else { 0.0 };
        for key in keys {
            let [expected] = function.at(numbers.value(key));
            let [actual] = evaluated(&segments, numbers, key);
            assert!(
                (actual - expected).abs() < 1e-6 + rounding,
                "{key} {actual} {expected} {numbers:?} {function:?}"
            );
        }
    }

    /// Points at and between values that samples have, near each other and far.
    #[test]
    fn segments_are_the_function() {
        for_each_seed(1, |mut rng| {
            for (slope, intercept) in [(1.0, 0.0), (1.0, 7.0), (0.1, 7.0), (-0.3, 7.0)] {
                for numbers in one_of_each_type(Scaling { slope, intercept }) {
                    let [least, largest] = numbers.keys();
                    for _ in 0..50 {
                        let key = |rng: &mut fastrand::Rng| rng.u64(least + 1..largest);
                        let mut positions = [0; 4].map(|_| numbers.value(key(&mut rng)));
                        positions[1] =
                            if rng.bool() { positions[0] } else { positions[1].next_up() };
                        positions.sort_by(f64::total_cmp);
                        let points = positions.map(|position| (position, [rng.f64()])).to_vec();
                        let Ok(function) = PiecewiseLinear::new("opacity", points) else {
                            continue;
                        };
                        check(&function, &numbers, (0..50).map(|_| rng.u64(least..=largest)));
                    }
                }
            }
        });
    }

    /// Steps that follow each other as closely as numbers do, and at both ends of the numbers.
    #[test]
    fn segments_of_narrow_steps() {
        for numbers in one_of_each_type(Scaling::IDENTITY) {
            let function = |positions: [f64; 3]| {
                let [a, b, c] = positions;
                let points = vec![(a, [0.0]), (a, [0.9]), (b, [0.5]), (b, [0.0]), (c, [0.3])];
                PiecewiseLinear::new("opacity", points).unwrap()
            };
            let [least, largest] = numbers.keys();
            for key in [least + 1, least + 2, least.midpoint(largest), largest - 3] {
                let positions = [key, key + 1, key + 2].map(|key| numbers.value(key));
                if positions[0] < positions[1] && positions[1] < positions[2] {
                    check(&function(positions), &numbers, key - 1..=key + 3);
                }
            }
        }
        let [.., numbers] = one_of_each_type(Scaling::IDENTITY);
        let [zero, tiny, large] = [0.0, 1e-300, 1e5];
        let points =
            vec![(zero, [0.0]), (zero, [0.9]), (tiny, [0.5]), (tiny, [0.0]), (large, [0.3])];
        let function = PiecewiseLinear::new("opacity", points).unwrap();
        let values = [zero, 3e-301, tiny.next_down(), tiny, 5e4, large, f64::INFINITY, -1.0];
        check(&function, &numbers, values.into_iter().map(crate::number::f64_key));
    }
}
