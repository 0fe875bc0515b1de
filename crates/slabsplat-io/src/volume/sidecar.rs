//! The JSON description beside a raw file.
//!
//! ```json
//! { "file": "ct.raw", "dims": [256, 256, 133], "type": "uint8", "endian": "little",
//!   "header_bytes": 0, "spacing": [1.4, 1.4, 2.5], "origin": [0, 0, 0] }
//! ```
//!
//! `dims` and `type` are needed. `file` is the description's own name with `.raw` if not given,
//! `endian` matters from 16 bits on. `affine`, three rows of four numbers, takes the place of `spacing` and
//! `origin`; a value is `slope` times a sample, plus `intercept`. Other keys are left to their owners, and
//! named, since they may be misspelt.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::IgnoredAny;
use slabsplat_core::glam::{DAffine3, DMat3, DVec3};
use slabsplat_core::{Grid, GridError, SampleType, Scaling};

use super::formats::{Input, Reader, VolumeListing};
use super::raw::read_samples;
use super::stream::plain_extension;
use super::{Endian, LoadedVolume, RawDesc, VolumeChoices, VolumeFormat, assemble, names};
use crate::printable::shown_path;
use crate::store::Store;
use crate::{IoError, text};

/// Raw files with a description beside them.
pub(super) struct Sidecar;

impl Reader for Sidecar {
    fn listed(&self) -> &'static str {
        "raw with a .json description beside it"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["json"]
    }

    fn is_begun_by(&self, _start: &[u8]) -> bool {
        false
    }

    fn is_named(&self, store: Store<'_>, path: &Path) -> bool {
        plain_extension(path) == "json" || store.has(&path.with_extension("json"))
    }

    fn header_of(&self, _store: Store<'_>, path: &Path) -> Result<PathBuf, IoError> {
        let is_it = plain_extension(path) == "json";
        Ok(if is_it { path.to_owned() } else { path.with_extension("json") })
    }

    fn reads_boxes(&self) -> bool {
        true
    }

    fn read(&self, input: &Input<'_>) -> Result<LoadedVolume, IoError> {
        read(input)
    }

    fn list(&self, input: &Input<'_>) -> Result<VolumeListing, IoError> {
        let desc = parse(input.store, input.path)?;
        Ok(VolumeListing {
            format: VolumeFormat::Raw,
            dims: desc.dims,
            sample_type: desc.sample_type(input.path)?,
            choices: VolumeChoices::default(),
        })
    }
}

#[derive(Deserialize)]
struct SidecarDesc {
    file: Option<String>,
    dims: [usize; 3],
    r#type: String,
    endian: Option<String>,
    #[serde(default)]
    header_bytes: u64,
    #[serde(default = "unit_spacing")]
    spacing: [f64; 3],
    #[serde(default)]
    origin: [f64; 3],
    order: Option<String>,
    /// Index to world, by rows.
    affine: Option<[[f64; 4]; 3]>,
    #[serde(default = "one")]
    slope: f64,
    #[serde(default)]
    intercept: f64,
    #[serde(flatten)]
    others: BTreeMap<String, IgnoredAny>,
}

/// Keys that say nothing of how to read, and often are there.
const NOTES: &[&str] = &[
    "value_range",
    "note",
    "notes",
    "name",
    "title",
    "comment",
    "description",
    "source",
    "license",
];

fn one() -> f64 {
    1.0
}

fn unit_spacing() -> [f64; 3] {
    [1.0; 3]
}

fn read(input: &Input<'_>) -> Result<LoadedVolume, IoError> {
    let &Input { store, path, .. } = input;
    let malformed = |what: String| IoError::malformed(path, what);
    let sidecar = parse(store, path)?;
    let sample_type = sidecar.sample_type(path)?;
    if let Some(order) = sidecar.order.filter(|order| !order.starts_with("x fastest")) {
        let what =
            format!("voxels stored {order:?} cannot be read: store x fastest, then y, then z");
        return Err(IoError::unsupported(path, what));
    }
    let desc = RawDesc {
        dims: sidecar.dims,
        sample_type,
        endian: endian(sidecar.endian.as_deref(), sample_type).map_err(malformed)?,
        spacing: sidecar.spacing,
        header_bytes: sidecar.header_bytes,
    };
    let data_path = match sidecar.file {
        Some(file) => input.beside(&file)?,
        None => path.with_extension("raw"),
    };
    let grid = placed(&desc, sidecar.origin, sidecar.affine)
        .map_err(|source| IoError::Grid { path: path.to_owned(), source })?;
    let (window, grid) = input.window(&grid)?;
    let samples = read_samples(input, &data_path, &desc, window.as_ref())?;
    let scaling = Scaling { slope: sidecar.slope, intercept: sidecar.intercept };
    let volume = assemble(path, grid, samples, scaling)?;
    let unknown = sidecar.others.keys().filter(|key| !NOTES.contains(&key.as_str()));
    let unknown: Vec<String> = unknown.take(12).map(|key| format!("{key:?}")).collect();
    let mut warnings = Vec::new();
    if !unknown.is_empty() {
        warnings.push(format!(
            "{} says {}, which is no key here",
            shown_path(path),
            unknown.join(", ")
        ));
    }
    Ok(LoadedVolume::new(volume, VolumeFormat::Raw, warnings))
}

fn parse(store: Store<'_>, path: &Path) -> Result<SidecarDesc, IoError> {
    let text = text::read_from(store, path)?;
    serde_json::from_str(&text).map_err(|error| {
        let message = text::in_plain_words(&error.to_string());
        let key = key_before(&text, error.line(), error.column());
        let key = key.filter(|_| error.is_data() && message.starts_with("invalid "));
        let key = key.map(|key| format!("{key}: ")).unwrap_or_default();
        IoError::malformed(path, format!("not a description of a raw volume: {key}{message}"))
    })
}

/// The last key that stands before a place in a text.
fn key_before(text: &str, line: usize, column: usize) -> Option<&str> {
    let line_at: usize =
        text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
    let before = text.get(..(line_at + column).min(text.len()))?;
    let (before, _) = before.rsplit_once("\":")?;
    before.rsplit_once('"').map(|(_, key)| key)
}

impl SidecarDesc {
    fn sample_type(&self, path: &Path) -> Result<SampleType, IoError> {
        names::sample_type(&self.r#type)
            .ok_or_else(|| IoError::unsupported(path, names::unknown_type(&self.r#type)))
    }
}

fn endian(name: Option<&str>, sample_type: SampleType) -> Result<Endian, String> {
    match name {
        Some("little") => Ok(Endian::Little),
        Some("big") => Ok(Endian::Big),
        _ if sample_type.size_bytes() == 1 => Ok(Endian::NATIVE),
        other => {
            let other = other.unwrap_or("missing");
            Err(format!("endian is {other}: samples of {} need little or big", sample_type.name()))
        }
    }
}

fn placed(
    desc: &RawDesc,
    origin: [f64; 3],
    affine: Option<[[f64; 4]; 3]>,
) -> Result<Grid, GridError> {
    let (matrix, origin) = match affine {
        Some(rows) => {
            let [x, y, z] = rows.map(|[x, y, z, _]| DVec3::new(x, y, z));
            (DMat3::from_cols(x, y, z).transpose(), rows.map(|[_, _, _, offset]| offset))
        }
        None => (DMat3::from_diagonal(DVec3::from_array(desc.spacing)), origin),
    };
    Grid::new_large(desc.dims, DAffine3::from_mat3_translation(matrix, DVec3::from_array(origin)))
}

#[cfg(test)]
mod tests {
    use crate::read_volume;
    use slabsplat_core::glam::DVec3;

    fn read(json: &str) -> Result<crate::LoadedVolume, String> {
        let dir = tempfile::tempdir().unwrap();
        std::fs::write(dir.path().join("a.json"), json).unwrap();
        std::fs::write(dir.path().join("a.raw"), [1, 0, 2, 0]).unwrap();
        let by_raw = read_volume(dir.path().join("a.raw")).map_err(|e| e.to_string());
        let by_json = read_volume(dir.path().join("a.json")).map_err(|e| e.to_string());
        assert_eq!(by_raw.is_ok(), by_json.is_ok());
        by_json
    }

    #[test]
    fn sidecar_describes_raw() {
        let json = r#"{"dims": [2, 1, 1], "type": "uint16", "endian": "little", "note": 1,
            "spacing": [1, 2, 3], "origin": [-1, 0, 4.5]}"#;
        let volume = read(json).unwrap().volume;
        assert_eq!(volume.summary().range, Some([1.0, 2.0]));
        assert_eq!(volume.grid().spacing(), [1.0, 2.0, 3.0]);
        let origin = volume.grid().world_from_index().translation;
        assert_eq!(origin, DVec3::new(-1.0, 0.0, 4.5));
    }

    #[test]
    fn sidecar_places_scales_and_names_what_is_unknown() {
        let json = r#"{"dims": [2, 1, 1], "type": "uint16", "endian": "little", "note": "", "spaceing": 1,
            "affine": [[0, -2, 0, 5], [3, 0, 0, 6], [0, 0, 4, 7]], "slope": 0.5, "intercept": -1}"#;
        let loaded = read(json).unwrap();
        assert_eq!(loaded.volume.summary().range, Some([-0.5, 0.0]));
        let place = loaded.volume.grid().world_from_index().transform_point3(DVec3::X);
        assert_eq!(place, DVec3::new(5.0, 9.0, 7.0));
        assert!(loaded.warnings[0].ends_with("says \"spaceing\", which is no key here"));
        assert_eq!(loaded.warnings.len(), 1);
    }

    #[test]
    fn sidecar_errors_are_plain() {
        for (json, expected) in [
            ("", "not a description"),
            ("{}", "missing field `dims`"),
            (
                r#"{"dims": [2, 1, -1], "type": "uint8"}"#,
                "dims: invalid value: integer `-1`, expected a whole number of at least 0 at line 1",
            ),
            (
                "{\n\"dims\": [2, 1, 1],\n\"type\": 8}",
                "type: invalid type: integer `8`, expected a string",
            ),
            (r#"{"dims": [2, 1, 1], "type": "int64"}"#, "\"int64\" cannot be read"),
            (r#"{"dims": [2, 1, 1], "type": "uint16"}"#, "endian is missing"),
            (r#"{"dims": [2, 1, 1], "type": "uint16", "endian": "pdp"}"#, "endian is pdp"),
            (r#"{"dims": [2, 1, 1], "type": "uint8"}"#, "needs 2 bytes of data, has 4"),
            (r#"{"dims": [4, 1, 1], "type": "uint8", "order": "z first"}"#, "store x fastest"),
            (r#"{"dims": [4, 1, 1], "type": "uint8", "origin": [1e99, 0, 0]}"#, "matrix"),
            (r#"{"dims": [4, 1, 1], "type": "uint8", "file": "gone.raw"}"#, "cannot read"),
        ] {
            let err = read(json).unwrap_err();
            assert!(err.contains(expected), "{err} should contain {expected}");
        }
    }
}
