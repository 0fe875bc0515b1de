//! `cargo xtask bench data --large`: a brain of 10⁹ voxels, which takes a gigabyte.
//!
//! It is the brain of [`super::data`], interpolated five-fold along every axis, with noise where there
//! is anything: what a scan of that resolution would be like, of which no pixel of a window sees single
//! voxels. The same bytes are made everywhere.

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::Path;

use anyhow::{Context, Result, ensure};
use fastrand::Rng;

use super::data;
use super::program::Program;

/// By its name without an ending: a header, and bytes beside it.
const VOLUME: &str = "large/brain_985x1165x945_uint8";

const DIMS: [usize; 3] = [197, 233, 189];
const FACTOR: usize = 5;

/// What the noise is off by, in the mean of squares, in values of 0 to 255.
const NOISE: f32 = 4.0;

pub(super) fn make() -> Result<()> {
    let folder = slabsplat_testdata::fetched_folder();
    let [header, bytes] = ["nhdr", "raw"].map(|ending| folder.join(VOLUME).with_extension(ending));
    if header.is_file() {
        println!("{} is there", header.display());
        return Ok(());
    }
    let small = match slabsplat_testdata::volume(data::VOLUME) {
        Some(small) => small,
        None => data::fetch()?,
    };
    fs::create_dir_all(header.parent().context("a volume lies in a folder")?)?;
    let voxels = voxels_of(&small, &bytes.with_extension("small.raw"))?;
    let file = File::create(&bytes).with_context(|| format!("cannot write {}", bytes.display()))?;
    write_interpolated(&voxels, DIMS, BufWriter::with_capacity(1 << 20, file))?;
    // The header last, so that nobody takes half a volume for a whole one.
    fs::write(&header, header_text(&bytes)?)?;
    println!("{} is made", header.display());
    Ok(())
}

/// The bytes of a volume, by way of a file that is gone afterwards.
fn voxels_of(volume: &Path, scratch: &Path) -> Result<Vec<u8>> {
    Program::built()?.convert(volume, scratch)?;
    let voxels = fs::read(scratch)?;
    fs::remove_file(scratch)?;
    fs::remove_file(scratch.with_extension("json"))?;
    let n_voxels: usize = DIMS.iter().product();
    ensure!(voxels.len() == n_voxels, "{} is another volume", volume.display());
    Ok(voxels)
}

fn header_text(bytes: &Path) -> Result<String> {
    let file_name = bytes.file_name().context("it is a file")?.to_string_lossy();
    let [x, y, z] = DIMS.map(|n| n * FACTOR);
    let step = 1.0 / FACTOR as f64;
    Ok(format!(
        "NRRD0004\ntype: uint8\ndimension: 3\nspace: right-anterior-superior\nsizes: {x} {y} {z}\n\
         space directions: ({step},0,0) (0,{step},0) (0,0,{step})\n\
         space origin: (-98.4,-134.4,-72.4)\nencoding: raw\ndata file: {file_name}\n"
    ))
}

/// Writes `FACTOR` times as many voxels along each axis, from the first to the last, a row at a time.
fn write_interpolated(voxels: &[u8], dims: [usize; 3], mut out: impl Write) -> Result<()> {
    let axes = dims.map(steps);
    let [n_x, n_y, _] = dims;
    let mut row = vec![0; axes[0].len()];
    for (z, at_z) in axes[2].iter().enumerate() {
        for (y, at_y) in axes[1].iter().enumerate() {
            let mut rng = Rng::with_seed((z * axes[1].len() + y) as u64);
            let at = |x: usize, y: usize, z: usize| f32::from(voxels[(z * n_y + y) * n_x + x]);
            let of_column = |x| {
                let of_plane = |z| at_y.between(at(x, at_y.first, z), at(x, at_y.second, z));
                at_z.between(of_plane(at_z.first), of_plane(at_z.second))
            };
            let columns: Vec<f32> = (0..n_x).map(of_column).collect();
            for (voxel, at_x) in row.iter_mut().zip(&axes[0]) {
                let value = at_x.between(columns[at_x.first], columns[at_x.second]);
                *voxel = if value == 0.0 { 0 } else { (value + noise(&mut rng)).round() as u8 };
            }
            out.write_all(&row)?;
        }
    }
    Ok(out.flush()?)
}

/// The sum of two numbers that are all alike likely has a variance of 1/6.
fn noise(rng: &mut Rng) -> f32 {
    NOISE * 6_f32.sqrt() * (rng.f32() + rng.f32() - 1.0)
}

/// Between which voxels of an axis a finer one lies, and how far behind the first.
struct Between {
    first: usize,
    second: usize,
    share: f32,
}

impl Between {
    fn between(&self, first: f32, second: f32) -> f32 {
        first + self.share * (second - first)
    }
}

fn steps(n: usize) -> Vec<Between> {
    let n_fine = n * FACTOR;
    let step = |fine: usize| {
        let at = fine as f32 * (n - 1) as f32 / (n_fine - 1) as f32;
        let first = at as usize;
        Between { first, second: (first + 1).min(n - 1), share: at - first as f32 }
    };
    (0..n_fine).map(step).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interpolated_values_have_noise_where_there_is_anything() {
        let (mut out, n) = (Vec::new(), [2, 3, 4]);
        write_interpolated(&[0; 24], n, &mut out).unwrap();
        assert_eq!(out, [0; 24 * FACTOR.pow(3)]);
        out.clear();
        write_interpolated(&[100; 24], n, &mut out).unwrap();
        assert_eq!(out.len(), 24 * FACTOR.pow(3));
        let off = out.iter().map(|voxel| (f32::from(*voxel) - 100.0).powi(2)).sum::<f32>();
        let off = (off / out.len() as f32).sqrt();
        assert!((off - NOISE).abs() < 0.2, "{off}");
    }

    #[test]
    fn steps_go_from_end_to_end() {
        let steps = steps(3);
        let ends =
            [&steps[0], &steps[14]].map(|step| step.between(step.first as f32, step.second as f32));
        assert_eq!((steps.len(), ends), (15, [0.0, 2.0]));
    }
}
