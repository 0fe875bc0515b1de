//! Voxels whose values are a colour: which those are, and the colours and the scalar that are made of them.
//!
//! Readers of formats say how many values a voxel has and whether they are meant to be a colour
//! ([`Meaning`]), ask [`Input::choose_values`] whether one of them is read or all, and hand all samples that
//! they read to [`Voxels::load`].

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use slabsplat_core::{ColorSamples, Grid, Sample, SampleType, Samples, Scaling, VoxelColors};

use super::choices::{Choice, Part, VolumeChoices, VolumeOptions};
use super::formats::Input;
use super::placed::Axis;
use super::stored::StoredType;
use super::{LoadedVolume, VolumeFormat, assemble};
use crate::IoError;

macro_rules! named {
    ($(#[$doc:meta])+ $Type:ident { $($(#[$of:meta])+ $Variant:ident = $name:literal,)+ }) => {
        $(#[$doc])+
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, Serialize)]
        #[non_exhaustive]
        pub enum $Type {
            $($(#[$of])+ #[serde(rename = $name)] $Variant,)+
        }

        impl $Type {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$Variant),+];

            /// Its name, as flags and keys spell it.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$Variant => $name,)+
                }
            }
        }

        impl fmt::Display for $Type {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(self.name())
            }
        }

        impl FromStr for $Type {
            type Err = String;

            fn from_str(word: &str) -> Result<Self, String> {
                let found = Self::ALL.iter().copied().find(|one| one.name() == word);
                let names: Vec<&str> = Self::ALL.iter().map(|one| one.name()).collect();
                found.ok_or_else(|| format!("{word:?} is none of: {}", names.join(", ")))
            }
        }
    };
}

named! {
    /// In which colours voxels are drawn that have three or four values.
    ColorUse {
        /// In their own, whether or not the file says that they have any.
        Own = "own",
        /// In those of the transfer function.
        None = "none",
    }
}

named! {
    /// Which scalar is made of a voxel's colour: what transfer functions, gradients and labels see of it.
    OpacitySource {
        /// How light it is: `0.2126 R + 0.7152 G + 0.0722 B`, of display-referred values (ITU-R BT.709).
        Luminance = "luminance",
        /// Its fourth value.
        Alpha = "alpha",
    }
}

/// What there is of a volume whose voxels are colours, beside the scalar that was made of them.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct LoadedColors {
    /// The colours; `None` if [`ColorUse::None`] was asked for.
    pub voxels: Option<VoxelColors>,
    /// Whether there is an opacity in the file.
    pub has_alpha: bool,
    /// What the scalar is.
    pub opacity_from: OpacitySource,
}

impl LoadedColors {
    /// Colours that were read elsewhere.
    pub fn new(voxels: Option<VoxelColors>, has_alpha: bool, opacity_from: OpacitySource) -> Self {
        Self { voxels, has_alpha, opacity_from }
    }
}

/// What a format says that the values of a voxel are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Meaning {
    /// A colour.
    Color,
    /// Nothing: three or four bytes are taken for a colour.
    Unsaid,
    /// Something else.
    Other,
}

/// The values of a voxel in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Values {
    pub(super) n: usize,
    pub(super) stored: StoredType,
    pub(super) meaning: Meaning,
}

const RGBA: [&str; 4] = ["red", "green", "blue", "alpha"];
const GRAY_ALPHA: [&str; 2] = ["gray", "alpha"];

/// What the values of a colour are called.
pub(super) fn names_of_colors(n: usize) -> Vec<String> {
    let names: &[&str] = if n == 2 { &GRAY_ALPHA } else { &RGBA };
    names.iter().take(n).map(|&name| name.to_owned()).collect()
}

/// What a pixel holds: `uint8`, `3 x uint16`.
impl fmt::Display for Values {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.n {
            1 => f.write_str(self.stored.name()),
            n => write!(f, "{n} x {}", self.stored.name()),
        }
    }
}

impl Values {
    /// Whether they can be drawn as a colour.
    fn can_be_color(&self) -> bool {
        let is_integer = |bits| self.stored == StoredType::Sample(bits);
        (3..=4).contains(&self.n) && (is_integer(SampleType::U8) || is_integer(SampleType::U16))
    }

    /// Whether they are drawn as one if nobody says so.
    fn are_color(&self) -> bool {
        match self.meaning {
            Meaning::Color => true,
            Meaning::Unsaid => self.stored == StoredType::U8_SAMPLE,
            Meaning::Other => false,
        }
    }
}

impl VolumeOptions {
    /// Whether it is said that voxels are colours.
    pub(super) fn ask_for_colors(&self) -> bool {
        self.colors == Some(ColorUse::Own) || self.opacity_from.is_some()
    }

    /// Whether all of a voxel's values are read, to be its colour.
    fn take_colors(&self, values: &Values) -> bool {
        let is_asked = self.ask_for_colors();
        self.channel.is_none() && values.can_be_color() && (is_asked || values.are_color())
    }
}

impl Input<'_> {
    /// Which of a voxel's values is read, or whether all are.
    ///
    /// # Errors
    /// If there is none of that number.
    pub(super) fn choose_values(&self, values: &Values) -> Result<VolumeChoices, IoError> {
        let is_color = self.options.take_colors(values);
        let is_named = is_color || values.meaning == Meaning::Color;
        let names = if is_named { names_of_colors(values.n) } else { Vec::new() };
        let channel = Choice { n: values.n, names, ..Choice::default() };
        let channel = self.choose_of(Part::Channel, channel)?;
        let is_guess = is_color && values.meaning == Meaning::Unsaid;
        Ok(VolumeChoices { channel, is_color, is_guess, ..VolumeChoices::default() })
    }
}

/// What a reader has read: a sample a voxel, or if they are colours all values of each, one after the other.
pub(super) struct Voxels {
    pub(super) grid: Grid,
    pub(super) samples: Samples,
    pub(super) scaling: Scaling,
    pub(super) choices: VolumeChoices,
}

impl Voxels {
    /// The volume that they are, with colours if they have any.
    pub(super) fn load(
        self,
        input: &Input<'_>,
        format: VolumeFormat,
        mut warnings: Vec<String>,
    ) -> Result<LoadedVolume, IoError> {
        let Self { mut grid, mut samples, scaling, choices } = self;
        if input.spill.is_some() {
            // One voxel stands for all.
            grid = grid.cropped(&[0..1, 0..1, 0..1]);
            let zero = samples.clone();
            (1..choices.n_read()).for_each(|_| samples.append(&zero));
        }
        if !choices.is_color {
            let volume = assemble(input.path, grid, samples, scaling)?;
            return Ok(LoadedVolume { choices, ..LoadedVolume::new(volume, format, warnings) });
        }
        let parts = ColorParts::of(samples, choices.channel.n);
        let ColorParts { colors, alpha } = parts
            .ok_or_else(|| IoError::malformed(input.path, "its colours are not whole numbers"))?;
        let opacity_from = opacity_from(input, alpha.as_ref(), &mut warnings)?;
        let has_alpha = alpha.is_some();
        let samples = match (opacity_from, alpha) {
            (OpacitySource::Alpha, Some(alpha)) => alpha,
            _ => colors.luminances(),
        };
        let volume = assemble(input.path, grid, samples, Scaling::IDENTITY)?;
        let voxels = match input.options.colors {
            Some(ColorUse::None) => None,
            _ => VoxelColors::new(grid.dims(), colors).ok(),
        };
        let colors = Some(LoadedColors { voxels, has_alpha, opacity_from });
        Ok(LoadedVolume { choices, colors, ..LoadedVolume::new(volume, format, warnings) })
    }
}

/// What is asked for, or else alpha, if it tells voxels apart.
fn opacity_from(
    input: &Input<'_>,
    alpha: Option<&Samples>,
    warnings: &mut Vec<String>,
) -> Result<OpacitySource, IoError> {
    match (input.options.opacity_from, alpha) {
        (Some(OpacitySource::Alpha), None) => {
            let what = "its colours have no alpha, which opacity is asked to be made of";
            Err(IoError::unsupported(input.path, what))
        }
        (Some(asked), _) => Ok(asked),
        (None, None) => Ok(OpacitySource::Luminance),
        // What is read of a volume in parts is asked for when all of it has been looked at.
        (None, Some(_)) if input.spill.is_some() || input.options.voxels.is_some() => {
            Ok(OpacitySource::Alpha)
        }
        (None, Some(alpha)) if is_constant(alpha) => {
            warnings.push(ALPHA_IS_CONSTANT.to_owned());
            Ok(OpacitySource::Luminance)
        }
        (None, Some(_)) => Ok(OpacitySource::Alpha),
    }
}

/// Why alpha is not what opacity is made of.
pub(crate) const ALPHA_IS_CONSTANT: &str =
    "alpha is the same everywhere: opacity is made of luminance";

pub(crate) fn is_constant(samples: &Samples) -> bool {
    slabsplat_core::with_samples!(samples, |s| s.iter().all(|sample| *sample == s[0]))
}

/// Samples of colours, taken apart.
struct ColorParts {
    colors: ColorSamples,
    alpha: Option<Samples>,
}

impl ColorParts {
    /// Of so many values a voxel, one after the other; `None` if they are not of 8 or 16 bits.
    fn of(samples: Samples, n_values: usize) -> Option<Self> {
        match samples {
            Samples::U8(samples) => {
                let (colors, alpha) = apart(samples, n_values);
                Some(Self { colors: ColorSamples::U8(colors), alpha: alpha.map(Samples::U8) })
            }
            Samples::U16(samples) => {
                let (colors, alpha) = apart(samples, n_values);
                Some(Self { colors: ColorSamples::U16(colors), alpha: alpha.map(Samples::U16) })
            }
            _ => None,
        }
    }
}

/// Colours of three values, and the fourth ones; in the memory that they came in.
fn apart<T: Sample>(mut samples: Vec<T>, n_values: usize) -> (Vec<[T; 3]>, Option<Vec<T>>)
where
    [T; 3]: bytemuck::Pod,
{
    let n_voxels = samples.len() / n_values;
    let alpha = (n_values == 4).then(|| samples.iter().skip(3).step_by(4).copied().collect());
    if n_values == 4 {
        for voxel_idx in 0..n_voxels {
            samples.copy_within(4 * voxel_idx..4 * voxel_idx + 3, 3 * voxel_idx);
        }
        samples.truncate(3 * n_voxels);
        samples.shrink_to_fit();
    }
    let colors = bytemuck::allocation::try_cast_vec(samples).unwrap_or_else(|(_, samples)| {
        // Its room is none of whole colours.
        samples.chunks_exact(3).map(|rgb| [rgb[0], rgb[1], rgb[2]]).collect()
    });
    (colors, alpha)
}

impl VolumeChoices {
    /// How many values of each voxel are read.
    pub(super) fn n_read(&self) -> usize {
        if self.is_color { self.channel.n } else { 1 }
    }

    /// The axis of a voxel's values, of which one is kept, or all next to each other.
    pub(super) fn axis_of_values(&self) -> Axis {
        let Choice { n, chosen, .. } = self.channel;
        if self.is_color { Axis::whole(n, 1) } else { Axis::one(n, chosen) }
    }

    /// Leaves of pixels what is read of them: all values, or one.
    pub(super) fn keep_read(&self, pixels: &mut Vec<u8>, sample_bytes: usize) {
        if 1 < self.channel.n && !self.is_color {
            pick(pixels, sample_bytes, [self.channel.n, self.channel.chosen]);
        }
    }
}

/// One value of each pixel, in place of all.
fn pick(pixels: &mut Vec<u8>, sample_bytes: usize, [n_values, chosen]: [usize; 2]) {
    let pixel_bytes = n_values * sample_bytes;
    let n_pixels = pixels.len() / pixel_bytes;
    for pixel_idx in 0..n_pixels {
        let first = pixel_idx * pixel_bytes + chosen * sample_bytes;
        pixels.copy_within(first..first + sample_bytes, pixel_idx * sample_bytes);
    }
    pixels.truncate(n_pixels * sample_bytes);
}

/// Colours that were multiplied with their alpha, as they were before that; where that is 0 they are black.
pub(super) fn unmultiply(pixels: &mut [u8], sample_type: SampleType) {
    macro_rules! divide {
        ($type:ty) => {
            for pixel in pixels.chunks_exact_mut(4 * size_of::<$type>()) {
                let mut values: [$type; 4] = bytemuck::pod_read_unaligned(pixel);
                let alpha = u32::from(values[3]);
                for value in &mut values[..3] {
                    let share = (u32::from(*value) * u32::from(<$type>::MAX) + alpha / 2)
                        .checked_div(alpha)
                        .unwrap_or(0);
                    *value = share.min(u32::from(<$type>::MAX)) as $type;
                }
                pixel.copy_from_slice(bytemuck::bytes_of(&values));
            }
        };
    }
    match sample_type {
        SampleType::U16 => divide!(u16),
        _ => divide!(u8),
    }
}

#[cfg(test)]
mod tests;
