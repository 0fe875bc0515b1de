//! Which pages are the slices of a volume, and how far apart.

use super::imagej::ImageJ;
use super::ome::Ome;
use super::pages::Pages;
use crate::IoError;

/// The slices of the first channel at the first time.
#[derive(Debug)]
pub(super) struct Stack {
    /// Their pages, in the order of z.
    pub(super) slices: Vec<usize>,
    /// Millimetres, or whatever the file counts in.
    pub(super) spacing: [f64; 3],
}

/// Slices, channels and times.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Counts {
    pub(super) n_slices: usize,
    pub(super) n_channels: usize,
    pub(super) n_times: usize,
}

impl Stack {
    /// What the first page's description says of the others.
    pub(super) fn find(pages: &Pages<'_>, warnings: &mut Vec<String>) -> Result<Self, IoError> {
        if let Some(ome) = Ome::of(&pages.description) {
            let ome = ome.map_err(|what| pages.malformed(what))?;
            warnings.extend(ome.counts.warning());
            let slices = ome.slices(pages.len()).map_err(|what| pages.unsupported(what))?;
            return Ok(Self { slices, spacing: ome.spacing(warnings) });
        }
        if let Some(imagej) = ImageJ::of(&pages.description) {
            let counts = imagej.counts(pages.len()).map_err(|what| pages.unsupported(what))?;
            warnings.extend(counts.warning());
            let slices = (0..counts.n_slices).map(|z| z * counts.n_channels).collect();
            return Ok(Self { slices, spacing: imagej.spacing(pages.resolution, warnings) });
        }
        warnings.push(
            "the file does not say how large its voxels are: 1 x 1 x 1 was assumed".to_owned(),
        );
        Ok(Self { slices: (0..pages.len()).collect(), spacing: [1.0; 3] })
    }

    pub(super) fn dims(&self, pages: &Pages<'_>) -> [usize; 3] {
        [pages.size[0], pages.size[1], self.slices.len()]
    }
}

impl Counts {
    /// What is left out.
    fn warning(self) -> Option<String> {
        let Self { n_slices: _, n_channels, n_times } = self;
        let is_one = n_channels == 1 && n_times == 1;
        (!is_one).then(|| {
            format!(
                "the file has {n_channels} channels at {n_times} times: the first of each was taken"
            )
        })
    }
}

/// How many millimetres a unit of length has, as OME and ImageJ name it.
pub(super) fn millimetres(unit: &str) -> Option<f64> {
    match unit {
        "m" => Some(1e3),
        "cm" => Some(10.0),
        "mm" => Some(1.0),
        // The micro sign, the Greek letter, and ImageJ's ways round both.
        "µm" | "μm" | "um" | "micron" | "microns" | "\\u00B5m" => Some(1e-3),
        "nm" => Some(1e-6),
        "pm" => Some(1e-9),
        "Å" => Some(1e-7),
        "in" | "inch" => Some(25.4),
        _ => None,
    }
}
