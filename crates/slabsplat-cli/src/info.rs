//! `slabsplat info`: what a volume is, or a mesh.

use crate::flags::RawFlags;
use crate::mesh_info::MeshInfo;
use crate::plain::plain;
use crate::progress::Progress;
use crate::{input, terminal};
use anyhow::Result;
use clap::Args;
use serde_json::{Value, json};
use slabsplat::io::{
    IoError, LoadedColors, LoadedMesh, LoadedVolume, Part, VolumeChoices, read_mesh,
};
use std::fmt::Write;
use std::path::PathBuf;

/// Tell what a volume or a mesh is: size, place, type, range of values
#[derive(Args)]
pub(crate) struct InfoArgs {
    /// A volume file, a mesh (.ply, .stl, .obj), a scene file, a built-in volume as builtin:NAME or
    /// builtin:NAME:SIZE, or - for a volume on standard input
    #[arg(value_name = "VOLUME")]
    volume: PathBuf,

    /// Answer in JSON
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    raw: RawFlags,
}

pub(crate) fn run(args: &InfoArgs) -> Result<()> {
    let progress = Progress::start("reading", 0);
    let mut file = input::scene_file(&args.volume)?;
    let volumes = input::load(&mut file, &args.raw)?;
    let meshes = file.meshes.iter().map(|mesh| read_mesh(&mesh.path));
    let meshes = meshes.collect::<Result<Vec<LoadedMesh>, IoError>>()?;
    drop(progress);
    volumes.iter().for_each(|loaded| terminal::warn_all(&loaded.warnings));
    meshes.iter().for_each(|loaded| terminal::warn_all(&loaded.warnings));
    let volumes: Vec<Info> = volumes.iter().map(Info::of).collect();
    let meshes: Vec<MeshInfo> = meshes.iter().map(MeshInfo::of).collect();
    let json = volumes.iter().map(Info::json).chain(meshes.iter().map(MeshInfo::json));
    let text = match json.collect::<Vec<Value>>().as_slice() {
        [info] if args.json => format!("{info:#}\n"),
        infos if args.json => format!("{:#}\n", Value::from(infos)),
        _ => {
            let texts = volumes.iter().map(Info::text).chain(meshes.iter().map(MeshInfo::text));
            texts.collect::<Vec<_>>().join("\n")
        }
    };
    terminal::answer(&text)
}

struct Info {
    dims: [usize; 3],
    spacing: [f64; 3],
    /// Index to world, by rows.
    affine: [[f64; 4]; 4],
    dtype: &'static str,
    /// Of finite values; `None` if there are none.
    range: Option<[f64; 2]>,
    n_voxels: usize,
    n_nan: usize,
    /// −∞ and +∞.
    n_infinite: [usize; 2],
    format: &'static str,
    choices: VolumeChoices,
    colors: Option<LoadedColors>,
}

impl Info {
    fn of(LoadedVolume { volume, format, choices, colors, .. }: &LoadedVolume) -> Self {
        let grid = volume.grid();
        let summary = volume.summary();
        let to_world = grid.world_from_index();
        let (m, o) = (to_world.matrix3, to_world.translation);
        let row = |r: usize| [m.x_axis[r], m.y_axis[r], m.z_axis[r], o[r]];
        Self {
            dims: grid.dims(),
            spacing: grid.spacing(),
            affine: [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]],
            dtype: volume.sample_type().name(),
            range: summary.range,
            n_voxels: grid.n_voxels(),
            n_nan: summary.n_nan,
            n_infinite: summary.n_infinite,
            format: format.name(),
            choices: choices.clone(),
            colors: colors.clone(),
        }
    }

    fn json(&self) -> Value {
        let end = |idx: usize| self.range.map(|range| range[idx]);
        let [n_minus_infinity, n_infinity] = self.n_infinite;
        let mut info = json!({
            "dims": self.dims,
            "spacing": self.spacing,
            "affine": self.affine,
            "dtype": self.dtype,
            "min": end(0),
            "max": end(1),
            "voxels": self.n_voxels,
            "nan": self.n_nan,
            "minus_infinity": n_minus_infinity,
            "infinity": n_infinity,
            "format": self.format,
        });
        for &part in Part::ALL {
            let choice = self.choices.get(part);
            if 1 < choice.n {
                let chosen = (!self.is_read_whole(part)).then_some(choice.chosen);
                info[part.name()] =
                    json!({ "n": choice.n, "names": choice.names, "chosen": chosen });
            }
        }
        if let Some(colors) = &self.colors {
            info["colors"] = json!({
                "alpha": colors.has_alpha,
                "opacity_from": colors.opacity_from.name(),
            });
        }
        info
    }

    fn text(&self) -> String {
        let [nx, ny, nz] = self.dims;
        let [dx, dy, dz] = self.spacing.map(plain);
        let range = match self.range {
            Some([min, max]) => format!("{} to {}", plain(min), plain(max)),
            None => "none is finite".to_owned(),
        };
        let [n_minus_infinity, n_infinity] = self.n_infinite;
        let mut text = String::new();
        for (key, value) in [
            ("format", self.format.to_owned()),
            ("dims", format!("{nx} x {ny} x {nz}")),
            ("voxels", self.n_voxels.to_string()),
            ("dtype", self.dtype.to_owned()),
            ("values", range),
            ("nan", self.n_nan.to_string()),
            ("infinite", format!("{n_minus_infinity} -inf, {n_infinity} +inf")),
            ("spacing", format!("{dx} x {dy} x {dz}")),
        ] {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{key:<8} {value}");
        }
        if let Some(LoadedColors { has_alpha, opacity_from, .. }) = &self.colors {
            let kind = if *has_alpha { "RGBA" } else { "RGB" };
            let _ = writeln!(text, "{:<8} {kind}; values are of {opacity_from}", "colors");
        }
        text + &self.affine_text() + &self.choices_text()
    }

    /// What else there is; nothing of a file that holds one volume.
    fn choices_text(&self) -> String {
        let mut text = String::new();
        for &part in Part::ALL {
            let choice = self.choices.get(part);
            if choice.n == 1 {
                continue;
            }
            let chosen =
                if self.is_read_whole(part) { "all".to_owned() } else { choice.chosen.to_string() };
            let _ = writeln!(text, "{:<8} {chosen} of 0 to {}", part.name(), choice.n - 1);
            for (idx, name) in choice.names.iter().enumerate() {
                let _ = writeln!(text, "{:<8} {idx}: {name}", "");
            }
        }
        text
    }

    /// Whether no single one of a part was read.
    fn is_read_whole(&self, part: Part) -> bool {
        part == Part::Channel && self.choices.is_color
    }

    fn affine_text(&self) -> String {
        let cells = self.affine.map(|row| row.map(plain));
        let width = cells.iter().flatten().map(String::len).max().unwrap_or(0);
        let mut text = String::new();
        for (row_idx, row) in cells.iter().enumerate() {
            let key = if row_idx == 0 { "affine" } else { "" };
            let row = row.iter().map(|cell| format!("{cell:>width$}")).collect::<Vec<_>>();
            let _ = writeln!(text, "{key:<8} {}", row.join("  "));
        }
        text
    }
}
