//! What is written for a voxel: its sample, or where a format has neither slope nor intercept and the volume
//! has them, its value.

use std::io::{self, Write};

use slabsplat_core::{
    ColorSamples, Sample, SampleType, Samples, Scaling, Volume, VoxelColors, with_samples,
};

/// A volume, and the colours of its voxels if they are written instead of it.
#[derive(Clone, Copy)]
pub(super) struct ToWrite<'v> {
    pub(super) volume: &'v Volume,
    pub(super) colors: Option<Colored<'v>>,
}

/// Colours of voxels, whose type is the volume's.
#[derive(Clone, Copy)]
pub(super) struct Colored<'v> {
    pub(super) voxels: &'v VoxelColors,
    /// Whether the volume's values are their alpha, and are written, too.
    pub(super) is_alpha: bool,
}

impl ToWrite<'_> {
    /// Values of each voxel.
    pub(super) fn n_values(&self) -> usize {
        match self.colors {
            None => 1,
            Some(Colored { is_alpha, .. }) => 3 + usize::from(is_alpha),
        }
    }
}

/// The samples of a volume, in the type that they are written in.
pub(super) struct WrittenSamples<'v> {
    volume: &'v Volume,
    colors: Option<Colored<'v>>,
    /// The type of values that are written instead of samples.
    values: Option<SampleType>,
}

/// Samples that are turned round or scaled at once.
const CHUNK: usize = 1 << 14;

impl<'v> WrittenSamples<'v> {
    /// As they are, for a format that has slope and intercept.
    pub(super) fn as_stored(to_write: &ToWrite<'v>) -> Self {
        let ToWrite { volume, colors } = *to_write;
        Self { volume, colors, values: None }
    }

    /// For a format that has neither slope nor intercept.
    pub(super) fn as_values(to_write: &ToWrite<'v>, warnings: &mut Vec<String>) -> Self {
        let ToWrite { volume, colors } = *to_write;
        if volume.scaling() == Scaling::IDENTITY || colors.is_some() {
            return Self::as_stored(to_write);
        }
        let values = type_of_values(volume);
        let Scaling { slope, intercept } = volume.scaling();
        let (from, to) = (volume.sample_type().name(), values.name());
        warnings.push(format!(
            "the format has no slope and intercept: values of {to} are written, not samples of {from} with \
             slope {slope} and intercept {intercept}"
        ));
        Self { volume, colors: None, values: Some(values) }
    }

    pub(super) fn sample_type(&self) -> SampleType {
        self.values.unwrap_or(self.volume.sample_type())
    }

    /// All of them, x fastest and the values of a voxel next to each other, the least significant byte first.
    pub(super) fn write(&self, out: &mut (impl Write + ?Sized)) -> io::Result<()> {
        match self.colors {
            Some(colored) => write_colors(colored, self.volume, out),
            None => self.write_range(0, self.volume.grid().n_voxels(), out),
        }
    }

    /// A run of them.
    pub(super) fn write_range(
        &self,
        first: usize,
        n: usize,
        out: &mut (impl Write + ?Sized),
    ) -> io::Result<()> {
        let Some(values) = self.values else {
            return with_samples!(self.volume.samples(), |s| write_little(
                &s[first..first + n],
                out
            ));
        };
        for start in (first..first + n).step_by(CHUNK) {
            let indices = start..(first + n).min(start + CHUNK);
            let chunk = indices.map(|voxel_idx| self.volume.value(voxel_idx));
            write_values(chunk, values, out)?;
        }
        Ok(())
    }
}

fn write_colors(
    Colored { voxels, is_alpha }: Colored<'_>,
    volume: &Volume,
    out: &mut (impl Write + ?Sized),
) -> io::Result<()> {
    match (voxels.samples(), volume.samples()) {
        (ColorSamples::U8(colors), Samples::U8(alpha)) => {
            write_pixels(colors, is_alpha.then_some(alpha), out)
        }
        (ColorSamples::U16(colors), Samples::U16(alpha)) => {
            write_pixels(colors, is_alpha.then_some(alpha), out)
        }
        _ => Err(io::Error::other("colours are of another type than the values beside them")),
    }
}

fn write_pixels<T: Sample>(
    colors: &[[T; 3]],
    alpha: Option<&Vec<T>>,
    out: &mut (impl Write + ?Sized),
) -> io::Result<()> {
    for (idx, chunk) in colors.chunks(CHUNK).enumerate() {
        let values: Vec<T> = match alpha {
            None => chunk.iter().flatten().copied().collect(),
            Some(alpha) => {
                let pixels = chunk.iter().zip(&alpha[idx * CHUNK..]);
                pixels.flat_map(|(&[r, g, b], &alpha)| [r, g, b, alpha]).collect()
            }
        };
        write_little(&values, out)?;
    }
    Ok(())
}

/// The least type that holds the values exactly, or else floats: of 32 bits for samples of up to 16.
fn type_of_values(volume: &Volume) -> SampleType {
    use SampleType::{F32, F64, I16, I32, U16, U32};
    let Scaling { slope, intercept } = volume.scaling();
    let is_whole = |number: f64| number.fract() == 0.0;
    let are_integers = !matches!(volume.sample_type(), F32 | F64);
    if are_integers
        && is_whole(slope)
        && is_whole(intercept)
        && let Some([min, max]) = volume.summary().range
    {
        let holds = |[least, most]: [f64; 2]| least <= min && max <= most;
        for (sample_type, range) in [
            (I16, [f64::from(i16::MIN), f64::from(i16::MAX)]),
            (U16, [0.0, f64::from(u16::MAX)]),
            (I32, [f64::from(i32::MIN), f64::from(i32::MAX)]),
            (U32, [0.0, f64::from(u32::MAX)]),
        ] {
            if holds(range) {
                return sample_type;
            }
        }
    }
    if volume.sample_type().size_bytes() <= 2 { F32 } else { F64 }
}

fn write_values(
    values: impl Iterator<Item = f64>,
    sample_type: SampleType,
    out: &mut (impl Write + ?Sized),
) -> io::Result<()> {
    match sample_type {
        SampleType::U8 => write_little(&values.map(|v| v as u8).collect::<Vec<_>>(), out),
        SampleType::I8 => write_little(&values.map(|v| v as i8).collect::<Vec<_>>(), out),
        SampleType::U16 => write_little(&values.map(|v| v as u16).collect::<Vec<_>>(), out),
        SampleType::I16 => write_little(&values.map(|v| v as i16).collect::<Vec<_>>(), out),
        SampleType::U32 => write_little(&values.map(|v| v as u32).collect::<Vec<_>>(), out),
        SampleType::I32 => write_little(&values.map(|v| v as i32).collect::<Vec<_>>(), out),
        SampleType::F32 => write_little(&values.map(|v| v as f32).collect::<Vec<_>>(), out),
        SampleType::F64 => write_little(&values.collect::<Vec<_>>(), out),
    }
}

fn write_little<T: Sample>(samples: &[T], out: &mut (impl Write + ?Sized)) -> io::Result<()> {
    if cfg!(target_endian = "little") {
        return out.write_all(bytemuck::cast_slice(samples));
    }
    for chunk in samples.chunks(CHUNK) {
        let mut bytes = bytemuck::cast_slice::<T, u8>(chunk).to_vec();
        bytes.chunks_exact_mut(size_of::<T>()).for_each(<[u8]>::reverse);
        out.write_all(&bytes)?;
    }
    Ok(())
}
