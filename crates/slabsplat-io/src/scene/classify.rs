//! The `[classify]` table: a transfer function by its points, by a preset or by a file.

use std::path::Path;

use slabsplat_core::TransferFunction;

use super::keys::ClassifyKeys;
use super::{color_map, presets};

/// What is wrong with the table, for the file's error.
pub(super) type Complaint = String;

impl ClassifyKeys {
    /// The transfer function; `None` if the table says nothing. `scene_path` is what a path is relative to.
    pub(super) fn transfer(
        &self,
        scene_path: &Path,
    ) -> Result<Option<TransferFunction>, Complaint> {
        let has_points = self.opacity.is_some() || self.color.is_some();
        match (has_points, &self.preset, &self.file) {
            (false, None, None) => Ok(None),
            (true, None, None) => self.from_points().map(Some),
            (false, Some(name), None) => presets::preset(name).map(Some),
            (false, None, Some(file)) => {
                let path = scene_path.parent().unwrap_or(Path::new("")).join(file);
                color_map::read_color_map(&path).map(Some).map_err(|err| err.to_string())
            }
            _ => Err("[classify] takes opacity and color, or preset, or file, but not two of them"
                .to_owned()),
        }
    }

    fn from_points(&self) -> Result<TransferFunction, Complaint> {
        let (Some(opacity), Some(color)) = (&self.opacity, &self.color) else {
            return Err("[classify] needs both opacity and color".to_owned());
        };
        let opacity = opacity.iter().map(|&[value, opacity]| (value, [opacity])).collect();
        let color = color.iter().map(|&[value, r, g, b]| (value, [r, g, b])).collect();
        TransferFunction::new(opacity, color).map_err(|err| format!("[classify] {err}"))
    }
}
