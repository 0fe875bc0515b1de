//! The JSON description beside a raw file.
//!
//! ```json
//! { "file": "ct.raw", "dims": [256, 256, 133], "type": "uint8", "endian": "little",
//!   "header_bytes": 0, "spacing": [1.4, 1.4, 2.5], "origin": [0, 0, 0] }
//! ```
//!
//! `dims` and `type` are needed. `file` is the description's own name with `.raw` if not given,
//! `endian` matters from 16 bits on, and other keys are left to their owners.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use slabsplat_core::glam::{DAffine3, DVec3};
use slabsplat_core::{Grid, SampleType};

use super::formats::{Input, Reader, VolumeListing};
use super::stream::plain_extension;
use super::{Endian, LoadedVolume, RawDesc, VolumeChoices, VolumeFormat, names, read_raw_from};
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
    placed_at(read_raw_from(store, &data_path, &desc)?, sidecar.origin, path)
}

fn parse(store: Store<'_>, path: &Path) -> Result<SidecarDesc, IoError> {
    serde_json::from_str(&text::read_from(store, path)?).map_err(|error| {
        IoError::malformed(path, format!("not a description of a raw volume: {error}"))
    })
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

fn placed_at(loaded: LoadedVolume, origin: [f64; 3], path: &Path) -> Result<LoadedVolume, IoError> {
    let grid = loaded.volume.grid();
    let matrix = grid.world_from_index().matrix3;
    let placed = DAffine3::from_mat3_translation(matrix, DVec3::from_array(origin));
    let grid = Grid::new(grid.dims(), placed)
        .map_err(|source| IoError::Grid { path: path.to_owned(), source })?;
    Ok(loaded.on_grid(grid))
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
    fn sidecar_errors_are_plain() {
        for (json, expected) in [
            ("", "not a description"),
            ("{}", "missing field `dims`"),
            (r#"{"dims": [2, 1, -1], "type": "uint8"}"#, "not a description"),
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
