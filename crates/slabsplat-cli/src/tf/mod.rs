//! `slabsplat tf`: a transfer function printed, drawn, or written in another format.

mod drawing;

use crate::flags::{RawFlags, TransferFlags};
use crate::plain::plain;
use crate::progress::Progress;
use crate::{columns, input, output, terminal};
use anyhow::{Context, Result, bail};
use clap::Args;
use serde_json::json;
use slabsplat::io::{
    self, LayerFile, LoadedVolume, PictureFormat, TransferFormat, TransferSource, VolumeSource,
};
use slabsplat::{Grid, Layer, Scaling, Volume, open_layer, plot_transfer};
use std::path::{Path, PathBuf};

/// Print, draw or convert a transfer function: of a file, of a preset, or what a volume is shown with
#[derive(Args)]
pub(crate) struct TfArgs {
    /// A volume, a scene, a colour map of ParaView (.json) or a volume property of 3D Slicer (.vp); none, if
    /// --preset or other flags say it
    #[arg(value_name = "INPUT")]
    input: Option<PathBuf>,

    /// What to write: a drawing over the volume's values (.png), a colour map of ParaView (.json), a volume
    /// property of 3D Slicer (.vp), or the section [classify] of a scene (.toml)
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,

    /// Print it in JSON
    #[arg(long)]
    json: bool,

    /// Pixels in a row of a drawing
    #[arg(
        long, value_name = "PIXELS", default_value_t = 640,
        value_parser = clap::value_parser!(u32).range(160..=8192)
    )]
    width: u32,

    /// Rows of pixels of a drawing
    #[arg(
        long, value_name = "PIXELS", default_value_t = 360,
        value_parser = clap::value_parser!(u32).range(120..=8192)
    )]
    height: u32,

    #[command(flatten)]
    transfer: TransferFlags,

    #[command(flatten)]
    raw: RawFlags,
}

pub(crate) fn run(args: &TfArgs) -> Result<()> {
    let kind = args.output.as_deref().map(Output::of).transpose()?;
    let progress = Progress::start("reading", 0);
    let Subject { layer, has_volume } = subject(args)?;
    drop(progress);
    let volume = has_volume.then_some(&*layer.volume);
    let Some((path, kind)) = args.output.as_deref().zip(kind) else {
        let text = if args.json { json_of(&layer) } else { text_of(&layer, volume) };
        return terminal::answer(&text);
    };
    match kind {
        Output::Drawing => {
            let image = plot_transfer(&layer.transfer, volume, [args.width, args.height]);
            output::write_picture(path, PictureFormat::Png, &image, None)?;
        }
        Output::Transfer => io::write_transfer(path, &layer)?,
    }
    let n_points = layer.transfer.positions().count();
    terminal::say(format_args!("{}: {n_points} points", path.display()));
    Ok(())
}

/// What is written.
#[derive(Clone, Copy)]
enum Output {
    Drawing,
    Transfer,
}

impl Output {
    /// What would fail after the work must fail before it.
    fn of(path: &Path) -> Result<Self> {
        if TransferFormat::of(path).is_some() {
            return Ok(Self::Transfer);
        }
        let is_png = path.extension().is_some_and(|it| it.eq_ignore_ascii_case("png"));
        if is_png {
            return Ok(Self::Drawing);
        }
        bail!(
            "cannot tell the format of {}: name it .png (a drawing), .json (ParaView), .vp (3D Slicer) or \
             .toml (a scene's [classify])",
            path.display()
        )
    }
}

/// A volume and its transfer function, or a transfer function alone.
struct Subject {
    layer: Layer,
    has_volume: bool,
}

fn subject(args: &TfArgs) -> Result<Subject> {
    let source = args.input.as_deref().map(transfer_file).transpose()?.flatten();
    match &args.input {
        Some(path) if source.is_none() => of_volume(args, path),
        None if args.transfer.are_silent() => {
            bail!(
                "there is nothing to show: name a volume, a scene or a transfer file, or add --preset"
            )
        }
        _ => of_nothing(args, source),
    }
}

/// What a file says that is no volume.
fn transfer_file(path: &Path) -> Result<Option<TransferSource>> {
    let is_transfer = match TransferFormat::of(path) {
        // A raw volume's description is JSON, too.
        Some(TransferFormat::ParaView) => {
            let text =
                std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
            let text = String::from_utf8_lossy(&text);
            ["\"RGBPoints\"", "\"IndexedColors\""].iter().any(|key| text.contains(key))
        }
        Some(TransferFormat::Scene) | None => false,
        // Slicer's, and others whose extension says enough.
        Some(_) => true,
    };
    Ok(if is_transfer { Some(io::read_transfer(path)?) } else { None })
}

fn of_volume(args: &TfArgs, path: &Path) -> Result<Subject> {
    let mut file = input::scene_file(path)?;
    args.transfer.lay_over(&mut file.layers)?;
    let mut volumes = input::load(&mut file, &args.raw)?.into_iter();
    let (Some(layer), Some(loaded)) = (file.layers.first(), volumes.next()) else {
        bail!("{} shows meshes alone, which have no transfer function", path.display());
    };
    if 1 < file.layers.len() {
        terminal::warn(&format!("of {} layers this is the first", file.layers.len()));
    }
    args.transfer.check_against(&loaded)?;
    terminal::warn_all(&loaded.warnings);
    let (layer, warnings) = open_layer(loaded, layer)?;
    terminal::warn_all(&warnings);
    if layer.transfer_2d.is_some() {
        terminal::warn(
            "boxes or a picture of values and gradients decide here; this is what they replace",
        );
    }
    Ok(Subject { layer, has_volume: true })
}

/// Over values from 0 to 1, each of which a volume has that nobody sees.
fn of_nothing(args: &TfArgs, source: Option<TransferSource>) -> Result<Subject> {
    let grid = Grid::with_spacing([2, 1, 1], [1.0; 3])?;
    let volume = Volume::new(grid, vec![0_u8, 1].into(), Scaling::IDENTITY)?;
    let nowhere = VolumeSource::Builtin { name: "none".to_owned(), size: None };
    let mut layers = [LayerFile::of_volume(nowhere)];
    if let Some(source) = source {
        layers[0].begin_with(source, false);
    }
    args.transfer.lay_over(&mut layers)?;
    let [layer] = &layers;
    if matches!(layer.fit.stretch, Some(io::Stretch::Percentiles(_))) {
        bail!("percentiles are of a volume's values: name a volume");
    }
    // Warnings would be about values that are none.
    let (layer, _) = open_layer(LoadedVolume::computed(volume), layer)?;
    Ok(Subject { layer, has_volume: false })
}

fn json_of(layer: &Layer) -> String {
    let opacity = layer.transfer.opacity_points().points().iter().map(|&(value, [a])| [value, a]);
    let color = layer.transfer.color_points().points().iter();
    let color = color.map(|&(value, [r, g, b])| [value, r, g, b]);
    let mut json = json!({
        "opacity": opacity.collect::<Vec<_>>(),
        "color": color.collect::<Vec<_>>(),
    });
    if let Some(by_gradient) = &layer.gradient_opacity {
        let points = by_gradient.points().iter().map(|&(gradient, [factor])| [gradient, factor]);
        json["gradient_opacity"] = points.collect::<Vec<_>>().into();
    }
    format!("{json:#}\n")
}

fn text_of(layer: &Layer, volume: Option<&Volume>) -> String {
    let drawing = drawing::text(&layer.transfer, volume);
    let header = ["value", "opacity per step", "red", "green", "blue"].map(str::to_owned);
    let mut values: Vec<f64> = layer.transfer.positions().collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    let row = |&value: &f64| {
        let [r, g, b] = layer.transfer.color(value).map(|c| format!("{c:.3}"));
        [plain(value), format!("{:.4}", layer.transfer.opacity(value)), r, g, b]
    };
    let rows: Vec<[String; 5]> = std::iter::once(header).chain(values.iter().map(row)).collect();
    format!("{drawing}\n{}", columns::aligned(&rows))
}
