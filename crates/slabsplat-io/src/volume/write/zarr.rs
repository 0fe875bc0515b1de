//! OME-Zarr 0.4: a folder of one level, in chunks of 64³ voxels, each packed by gzip. It is filled under
//! another name and then given its own.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use flate2::Compression;
use flate2::write::GzEncoder;
use serde_json::{Value, json};
use slabsplat_core::{SampleType, Volume};

use super::{ToWrite, WrittenSamples, is_upright};
use crate::IoError;
use crate::picture::atomic::without_name;

/// Voxels along each side of a chunk.
const CHUNK_LEN: usize = 64;

/// What a folder has that a Zarr may replace.
const MARKS: &[&str] = &[".zgroup", ".zattrs", ".zarray", "zarr.json"];

pub(super) fn write(path: &Path, volume: &Volume) -> Result<Vec<String>, IoError> {
    let mut warnings = Vec::new();
    let samples = WrittenSamples::as_values(&ToWrite { volume, colors: None }, &mut warnings);
    if !is_upright(volume.grid()) {
        let what = "OME-Zarr 0.4 has no room for the directions of the axes: spacing and origin are kept alone";
        warnings.push(what.to_owned());
    }
    try_write(path, volume, &samples).map_err(IoError::write(path))?;
    Ok(warnings)
}

fn try_write(path: &Path, volume: &Volume, samples: &WrittenSamples<'_>) -> io::Result<()> {
    let is_replaceable = !path.exists() || MARKS.iter().any(|mark| path.join(mark).is_file());
    if !is_replaceable {
        return Err(io::Error::other("there is something else of this name, which is no Zarr"));
    }
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
    let parent = parent.unwrap_or(Path::new("."));
    let folder = tempfile::Builder::new().prefix(".slabsplat-").suffix(".part").tempdir_in(parent);
    let folder = folder.map_err(without_name)?;
    let filled = folder.path().join("new");
    fs::create_dir_all(filled.join("0"))?;
    write_json(&filled.join(".zgroup"), &json!({ "zarr_format": 2 }))?;
    write_json(&filled.join(".zattrs"), &attributes(path, volume))?;
    write_json(&filled.join("0/.zarray"), &array(volume, samples))?;
    write_chunks(&filled.join("0"), volume, samples)?;
    // Two renames, so that nothing is lost if the second fails.
    let old = folder.path().join("old");
    if path.exists() {
        fs::rename(path, &old)?;
    }
    if let Err(error) = fs::rename(&filled, path) {
        if old.exists() {
            fs::rename(&old, path)?;
        }
        return Err(error);
    }
    folder.close()
}

fn write_json(path: &Path, value: &Value) -> io::Result<()> {
    fs::write(path, format!("{value:#}\n"))
}

fn attributes(path: &Path, volume: &Volume) -> Value {
    let grid = volume.grid();
    let m = grid.world_from_index().matrix3;
    let scale = if is_upright(grid) {
        [m.z_axis.z, m.y_axis.y, m.x_axis.x]
    } else {
        let [x, y, z] = grid.spacing();
        [z, y, x]
    };
    let origin = grid.world_from_index().translation;
    let axis = |name: &str| json!({ "name": name, "type": "space", "unit": "millimeter" });
    let name = path.file_stem().map(|name| name.to_string_lossy().into_owned());
    json!({ "multiscales": [{
        "version": "0.4",
        "name": name,
        "axes": [axis("z"), axis("y"), axis("x")],
        "datasets": [{ "path": "0", "coordinateTransformations": [
            { "type": "scale", "scale": scale },
            { "type": "translation", "translation": [origin.z, origin.y, origin.x] },
        ] }],
    }] })
}

fn array(volume: &Volume, samples: &WrittenSamples<'_>) -> Value {
    let code = match samples.sample_type() {
        SampleType::U8 => "|u1",
        SampleType::I8 => "|i1",
        SampleType::U16 => "<u2",
        SampleType::I16 => "<i2",
        SampleType::U32 => "<u4",
        SampleType::I32 => "<i4",
        SampleType::F32 => "<f4",
        SampleType::F64 => "<f8",
    };
    let [nx, ny, nz] = volume.grid().dims();
    let [cx, cy, cz] = chunk_dims(volume);
    json!({
        "zarr_format": 2,
        "shape": [nz, ny, nx],
        "chunks": [cz, cy, cx],
        "dtype": code,
        "compressor": { "id": "gzip", "level": 6 },
        "fill_value": 0,
        "order": "C",
        "filters": null,
        "dimension_separator": "/",
    })
}

/// Chunks no longer than the volume.
fn chunk_dims(volume: &Volume) -> [usize; 3] {
    volume.grid().dims().map(|len| len.min(CHUNK_LEN))
}

fn write_chunks(folder: &Path, volume: &Volume, samples: &WrittenSamples<'_>) -> io::Result<()> {
    let dims = volume.grid().dims();
    let chunk = chunk_dims(volume);
    let [n_x, n_y, n_z] = [0, 1, 2].map(|axis| dims[axis].div_ceil(chunk[axis]));
    for k in 0..n_z {
        for j in 0..n_y {
            let row: PathBuf = folder.join(k.to_string()).join(j.to_string());
            fs::create_dir_all(&row)?;
            for i in 0..n_x {
                let file = BufWriter::new(File::create(row.join(i.to_string()))?);
                let mut packed = GzEncoder::new(file, Compression::default());
                write_chunk(&mut packed, volume, samples, [i, j, k])?;
                packed.finish()?.flush()?;
            }
        }
    }
    Ok(())
}

/// A chunk at the border is filled up with zeros.
fn write_chunk(
    out: &mut impl Write,
    volume: &Volume,
    samples: &WrittenSamples<'_>,
    chunk_idx: [usize; 3],
) -> io::Result<()> {
    let dims = volume.grid().dims();
    let chunk = chunk_dims(volume);
    let sample_bytes = samples.sample_type().size_bytes();
    let zeros = vec![0; chunk[0] * sample_bytes];
    let first = [0, 1, 2].map(|axis| chunk_idx[axis] * chunk[axis]);
    let n_in_row = chunk[0].min(dims[0] - first[0]);
    for z in first[2]..first[2] + chunk[2] {
        for y in first[1]..first[1] + chunk[1] {
            if dims[2] <= z || dims[1] <= y {
                out.write_all(&zeros)?;
                continue;
            }
            samples.write_range(volume.grid().voxel_idx([first[0], y, z]), n_in_row, out)?;
            out.write_all(&zeros[n_in_row * sample_bytes..])?;
        }
    }
    Ok(())
}
