//! What ImageJ writes into the description of a first page.
//!
//! Lines of `key=value`: <https://imagej.net/formats/tiff>. Pages go by channel, then slice, then time.

use super::super::units;
use super::stack::Counts;

/// The lines of a description.
#[derive(Debug)]
pub(super) struct ImageJ<'a> {
    lines: Vec<(&'a str, &'a str)>,
}

impl<'a> ImageJ<'a> {
    /// `None` if the description is none of ImageJ's.
    pub(super) fn of(description: &'a str) -> Option<Self> {
        let text = description.trim_end_matches('\0');
        let lines = text.lines().filter_map(|line| line.split_once('='));
        text.starts_with("ImageJ=").then(|| Self { lines: lines.collect() })
    }

    fn get(&self, key: &str) -> Option<&'a str> {
        self.lines.iter().find(|(name, _)| name.trim() == key).map(|(_, text)| text.trim())
    }

    fn count(&self, key: &str) -> usize {
        self.get(key).and_then(|text| text.parse().ok()).unwrap_or(1).max(1)
    }

    /// Slices, channels and times of so many pages.
    pub(super) fn counts(&self, n_pages: usize) -> Result<Counts, String> {
        let [n_channels, n_times] = [self.count("channels"), self.count("frames")];
        let n_slices = match self.get("slices") {
            Some(_) => self.count("slices"),
            None => n_pages / n_channels.saturating_mul(n_times).max(1),
        };
        let n_needed = n_slices.saturating_mul(n_channels).saturating_mul(n_times);
        if n_slices == 0 || n_pages < n_needed {
            return Err(format!(
                "ImageJ tells of {n_needed} pages, and the file has {n_pages}: save it as an OME-TIFF, which \
                 may be larger than 4 GiB"
            ));
        }
        Ok(Counts { n_slices, n_channels, n_times })
    }

    /// In millimetres where the unit is one of length, with the first page's pixels per unit.
    pub(super) fn spacing(
        &self,
        resolution: [Option<f64>; 2],
        warnings: &mut Vec<String>,
    ) -> [f64; 3] {
        let depth = self.get("spacing").and_then(|text| text.parse::<f64>().ok()).map(f64::abs);
        let [x, y] = resolution.map(|per_unit| per_unit.map(f64::recip));
        let (Some(unit), Some(x), Some(y)) = (self.get("unit"), x, y) else {
            warnings.push(units::NO_SIZE.to_owned());
            return [1.0; 3];
        };
        let depth = depth.filter(|depth| depth.is_normal());
        if depth.is_none() {
            warnings.push(units::NO_DEPTH.to_owned());
        }
        units::in_millimetres([x, y, depth.unwrap_or(x)], [unit; 3], warnings)
    }
}
