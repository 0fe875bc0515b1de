//! Two-dimensional transfer functions: opacity and colour by value and gradient (model §6).

use crate::transfer_image::TransferImage;
use crate::{Compositing, IsoRange};
use thiserror::Error;

/// Opacity per `unit` and colour as functions of a voxel's value and of how much values change there in a
/// `unit`: the length of the gradient times that (Kniss, Kindlmann & Hansen, IEEE Visualization 2001).
///
/// Materials that meet have values in common, but where they do the gradient is another.
///
/// ```
/// use slabsplat_core::{TransferBox, TransferFunction2d};
///
/// let skin = TransferBox::new([20.0, 60.0], [5.0, f64::INFINITY])?.opacity(0.2)?;
/// let bone = TransferBox::new([150.0, 255.0], [10.0, 80.0])?.fade([10.0, 2.0])?;
/// let transfer = TransferFunction2d::Boxes(vec![skin, bone]);
/// assert_eq!(transfer.opacity(40.0, 1.0), 0.0);
/// assert!((transfer.opacity(40.0, 9.0) - 0.2).abs() < 1e-12);
/// assert!((transfer.opacity(155.0, 40.0) - 0.5).abs() < 1e-12);
/// # Ok::<(), slabsplat_core::Transfer2dError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
#[expect(clippy::exhaustive_enums, reason = "shaders and files have to know each")]
pub enum TransferFunction2d {
    /// What is in none of them is invisible. In several of them, extinctions add up, and colours are mixed by
    /// extinction.
    Boxes(Vec<TransferBox>),
    /// A picture.
    Image(TransferImage),
}

/// A box of values and gradients of one colour.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize))]
#[cfg_attr(
    feature = "serde",
    serde(
        try_from = "crate::serialized::TransferBoxKeys",
        into = "crate::serialized::TransferBoxKeys"
    )
)]
pub struct TransferBox {
    values: [f64; 2],
    gradients: [f64; 2],
    opacity: f64,
    color: [f64; 3],
    fade: [f64; 2],
}

/// Why a two-dimensional transfer function cannot be made.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum Transfer2dError {
    /// An end is NaN, or they are the wrong way round.
    #[error("{what} go from the least to the largest, not from {} to {}", .ends[0], .ends[1])]
    BadEnds {
        /// `values` or `gradients`.
        what: &'static str,
        /// The first and the last.
        ends: [f64; 2],
    },
    /// A picture's pixels cannot be spread over nothing, or over all numbers.
    #[error("the {what} of a picture need a least and a larger, finite end, not {} and {}", .ends[0], .ends[1])]
    NoExtent {
        /// `values` or `gradients`.
        what: &'static str,
        /// The first and the last.
        ends: [f64; 2],
    },
    /// Opacities and channels of colours are shares.
    #[error("{what} of a transfer function lies between 0 and 1, not at {number}")]
    OutOfRange {
        /// The opacity or the colour.
        what: &'static str,
        /// What it was.
        number: f64,
    },
    /// The middle would not be reached.
    #[error("a box fades over no more than half of it, from 0 on: not over {fade} of {} to {}", .ends[0], .ends[1])]
    BadFade {
        /// What it was.
        fade: f64,
        /// The box's ends along that axis.
        ends: [f64; 2],
    },
    /// A picture without pixels, or with more or fewer than it says.
    #[error("a picture of {width} x {height} pixels cannot have {n_pixels}")]
    BadSize {
        /// Pixels in a row.
        width: usize,
        /// Rows.
        height: usize,
        /// How many there are.
        n_pixels: usize,
    },
}

impl TransferFunction2d {
    /// Opacity, 0 … 1, and red, green and blue at a value and a gradient, neither of which is NaN.
    pub fn at(&self, value: f64, gradient: f64) -> (f64, [f64; 3]) {
        match self {
            Self::Boxes(boxes) => mixed(boxes, value, gradient),
            Self::Image(image) => image.at(value, gradient),
        }
    }

    /// The opacity alone.
    pub fn opacity(&self, value: f64, gradient: f64) -> f64 {
        self.at(value, gradient).0
    }

    /// Values beyond which nothing is visible, whatever the gradient: disjoint ranges, from low values to
    /// high.
    pub fn iso_ranges(&self) -> Vec<IsoRange> {
        match self {
            Self::Boxes(boxes) => {
                let visible = boxes.iter().filter(|part| 0.0 < part.opacity);
                IsoRange::union(
                    visible.map(|&TransferBox { values: [lo, hi], .. }| IsoRange { lo, hi }),
                )
            }
            Self::Image(image) => image.iso_ranges(),
        }
    }

    /// All numbers that it is made of, in an order that depends on nothing else.
    pub fn numbers(&self) -> Box<dyn Iterator<Item = f64> + '_> {
        match self {
            Self::Boxes(boxes) => Box::new(boxes.iter().flat_map(TransferBox::numbers)),
            Self::Image(image) => Box::new(image.numbers()),
        }
    }
}

/// Extinctions add up, as those of layers do at one point.
fn mixed(boxes: &[TransferBox], value: f64, gradient: f64) -> (f64, [f64; 3]) {
    let mut extinction = 0.0;
    let mut weighted = [0.0; 3];
    for part in boxes {
        let of_part = Compositing::Extinction.weight(part.opacity_at(value, gradient));
        extinction += of_part;
        for (sum, channel) in weighted.iter_mut().zip(part.color) {
            *sum += of_part * channel;
        }
    }
    if extinction <= 0.0 {
        return (0.0, [0.0; 3]);
    }
    (-(-extinction).exp_m1(), weighted.map(|sum| sum / extinction))
}

impl TransferBox {
    /// An opaque white box, ends included; these may be infinite, as in "any gradient from 5 on".
    ///
    /// # Errors
    /// If an end is NaN, or the first of a pair is larger than the second.
    pub fn new(values: [f64; 2], gradients: [f64; 2]) -> Result<Self, Transfer2dError> {
        for (what, ends) in [("values", values), ("gradients", gradients)] {
            if ends[0].is_nan() || ends[1].is_nan() || ends[1] < ends[0] {
                return Err(Transfer2dError::BadEnds { what, ends });
            }
        }
        Ok(Self { values, gradients, opacity: 1.0, color: [1.0; 3], fade: [0.0; 2] })
    }

    /// The same with another opacity per `unit`.
    ///
    /// # Errors
    /// If it is not within 0 to 1.
    pub fn opacity(self, opacity: f64) -> Result<Self, Transfer2dError> {
        check_share("the opacity", opacity)?;
        Ok(Self { opacity, ..self })
    }

    /// The same in another colour.
    ///
    /// # Errors
    /// If a channel is not within 0 to 1.
    pub fn color(self, color: [f64; 3]) -> Result<Self, Transfer2dError> {
        color.iter().try_for_each(|&channel| check_share("the colour", channel))?;
        Ok(Self { color, ..self })
    }

    /// The same with an opacity that falls to 0 towards the ends, evenly over that much of values and of
    /// gradients, inside of the box.
    ///
    /// # Errors
    /// If either is below 0 or more than half of the box's side.
    pub fn fade(self, fade: [f64; 2]) -> Result<Self, Transfer2dError> {
        for (fade, ends) in fade.into_iter().zip([self.values, self.gradients]) {
            let is_within_half = fade <= 0.5 * ends[1] - 0.5 * ends[0];
            if !(0.0 <= fade && fade.is_finite() && (fade == 0.0 || is_within_half)) {
                return Err(Transfer2dError::BadFade { fade, ends });
            }
        }
        Ok(Self { fade, ..self })
    }

    /// The values at its ends.
    pub fn values(&self) -> [f64; 2] {
        self.values
    }

    /// The gradients at its ends.
    pub fn gradients(&self) -> [f64; 2] {
        self.gradients
    }

    /// Its opacity per `unit`, its colour, and over how much of values and of gradients it fades.
    pub fn look(&self) -> (f64, [f64; 3], [f64; 2]) {
        (self.opacity, self.color, self.fade)
    }

    fn opacity_at(&self, value: f64, gradient: f64) -> f64 {
        let [of_values, of_gradients] = self.fade;
        let share =
            share(value, self.values, of_values) * share(gradient, self.gradients, of_gradients);
        self.opacity * share
    }

    fn numbers(&self) -> impl Iterator<Item = f64> + use<> {
        let Self { values, gradients, opacity, color, fade } = *self;
        [values, gradients, fade].into_iter().flatten().chain([opacity]).chain(color)
    }
}

/// How much of a box's opacity is left at a number: 0 outside of its ends, 1 as far inside as it fades.
fn share(number: f64, [first, last]: [f64; 2], fade: f64) -> f64 {
    if number < first || last < number {
        return 0.0;
    }
    if fade == 0.0 { 1.0 } else { ((number - first).min(last - number) / fade).min(1.0) }
}

pub(crate) fn check_share(what: &'static str, number: f64) -> Result<(), Transfer2dError> {
    if (0.0..=1.0).contains(&number) {
        Ok(())
    } else {
        Err(Transfer2dError::OutOfRange { what, number })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_near(a: (f64, [f64; 3]), b: (f64, [f64; 3])) -> bool {
        let channels = a.1.iter().zip(b.1);
        (a.0 - b.0).abs() < 1e-12 && channels.into_iter().all(|(a, b)| (a - b).abs() < 1e-12)
    }

    #[test]
    fn transfer_boxes_hold_their_ends() {
        let part = TransferBox::new([2.0, 4.0], [1.0, f64::INFINITY]).unwrap();
        let transfer = TransferFunction2d::Boxes(vec![part.opacity(0.5).unwrap()]);
        let check = |value, gradient, expected: f64| {
            let opacity = transfer.opacity(value, gradient);
            assert!((opacity - expected).abs() < 1e-12, "{opacity} at {value}, {gradient}");
        };
        check(2.0, 1.0, 0.5);
        check(4.0, f64::INFINITY, 0.5);
        check(2.0_f64.next_down(), 1.0, 0.0);
        check(4.0_f64.next_up(), 1.0, 0.0);
        check(3.0, 1.0_f64.next_down(), 0.0);
        assert_eq!(transfer.iso_ranges(), [IsoRange { lo: 2.0, hi: 4.0 }]);
    }

    #[test]
    fn transfer_boxes_fade_towards_their_ends() {
        let part = TransferBox::new([0.0, 10.0], [0.0, 8.0]).unwrap();
        let part = part.opacity(0.8).unwrap().fade([5.0, 2.0]).unwrap();
        let transfer = TransferFunction2d::Boxes(vec![part]);
        for (value, gradient, expected) in
            [(5.0, 4.0, 0.8), (2.5, 4.0, 0.4), (5.0, 1.0, 0.4), (9.0, 7.0, 0.8 * 0.2 * 0.5)]
        {
            let opacity = transfer.opacity(value, gradient);
            assert!((opacity - expected).abs() < 1e-12, "{opacity} at {value}, {gradient}");
        }
        assert_eq!(transfer.opacity(0.0, 4.0), 0.0);
        assert_eq!(transfer.opacity(5.0, 8.0), 0.0);
    }

    /// Two layers at one point would add their extinctions.
    #[test]
    fn transfer_boxes_are_mixed_where_they_overlap() {
        let red = TransferBox::new([0.0, 2.0], [0.0, 9.0]).unwrap();
        let red = red.opacity(0.5).unwrap().color([1.0, 0.0, 0.0]).unwrap();
        let blue = TransferBox::new([1.0, 3.0], [0.0, 9.0]).unwrap();
        let blue = blue.opacity(0.75).unwrap().color([0.0, 0.0, 1.0]).unwrap();
        let parts = [red, blue];
        for parts in [vec![parts[0], parts[1]], vec![parts[1], parts[0]]] {
            let transfer = TransferFunction2d::Boxes(parts);
            assert!(is_near(transfer.at(0.5, 1.0), (0.5, [1.0, 0.0, 0.0])));
            // ln 2 and 2 ln 2.
            assert!(is_near(transfer.at(1.5, 1.0), (0.875, [1.0 / 3.0, 0.0, 2.0 / 3.0])));
            assert_eq!(transfer.at(3.5, 1.0), (0.0, [0.0; 3]));
            assert_eq!(transfer.iso_ranges(), [IsoRange { lo: 0.0, hi: 3.0 }]);
        }
    }

    #[test]
    fn transfer_box_errors_name_the_number() {
        let part = TransferBox::new([0.0, 10.0], [1.0, f64::INFINITY]).unwrap();
        let check = |result: Result<TransferBox, Transfer2dError>, expected: &str| {
            let error = result.unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        };
        check(
            TransferBox::new([3.0, 2.0], [0.0, 1.0]),
            "values go from the least to the largest, not from 3 to 2",
        );
        check(TransferBox::new([2.0, 3.0], [f64::NAN, 1.0]), "gradients go");
        check(
            part.opacity(1.5),
            "the opacity of a transfer function lies between 0 and 1, not at 1.5",
        );
        check(part.color([0.0, f64::NAN, 1.0]), "the colour of a transfer function");
        check(part.fade([6.0, 0.0]), "not over 6 of 0 to 10");
        check(part.fade([-1.0, 0.0]), "not over -1");
        check(part.fade([0.0, f64::INFINITY]), "not over inf");
        assert!(part.fade([5.0, 1e9]).is_ok());
    }
}
