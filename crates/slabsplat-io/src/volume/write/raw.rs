//! Samples alone, and a description beside them that says all that a header would.

use std::io::Write;
use std::path::Path;

use serde_json::json;
use slabsplat_core::Volume;

use super::{Packing, ToWrite, WrittenSamples, write_file};
use crate::IoError;
use crate::picture::atomic;

pub(super) fn write(path: &Path, volume: &Volume) -> Result<Vec<String>, IoError> {
    let samples = WrittenSamples::as_stored(&ToWrite { volume, colors: None });
    write_file(path, b"", &samples, Packing::None)?;
    let file = path.file_name().map(|name| name.to_string_lossy().into_owned());
    let to_world = volume.grid().world_from_index();
    let (m, o) = (to_world.matrix3, to_world.translation);
    let row = |r: usize| [m.x_axis[r], m.y_axis[r], m.z_axis[r], o[r]];
    let scaling = volume.scaling();
    let description = json!({
        "file": file,
        "dims": volume.grid().dims(),
        "type": volume.sample_type().name(),
        "endian": "little",
        "spacing": volume.grid().spacing(),
        "affine": [row(0), row(1), row(2)],
        "slope": scaling.slope,
        "intercept": scaling.intercept,
    });
    atomic::write(&path.with_extension("json"), |file| writeln!(file, "{description:#}"))?;
    Ok(Vec::new())
}
