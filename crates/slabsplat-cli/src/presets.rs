//! `slabsplat presets`: which ready-made transfer functions there are.

use crate::{columns, terminal};
use anyhow::Result;
use clap::Args;
use serde_json::{Value, json};
use slabsplat::io::{self, Preset};

/// Tell which ready-made transfer functions there are, and for which values
#[derive(Args)]
pub(crate) struct PresetsArgs {
    /// Answer in JSON
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &PresetsArgs) -> Result<()> {
    let presets = io::PRESET_NAMES.iter().map(|name| io::preset(name));
    let presets = presets.collect::<Result<Vec<Preset>, _>>()?;
    let text = if args.json { json_of(&presets) } else { text_of(&presets) };
    terminal::answer(&text)
}

fn text_of(presets: &[Preset]) -> String {
    let header = ["preset", "values", "what it shows"].map(str::to_owned);
    let row = |preset: &Preset| {
        [preset.name.to_owned(), preset.suited.name().to_owned(), preset.about.clone()]
    };
    let rows: Vec<[String; 3]> = std::iter::once(header).chain(presets.iter().map(row)).collect();
    columns::aligned(&rows)
}

fn json_of(presets: &[Preset]) -> String {
    let one = |preset: &Preset| {
        let transfer = &preset.source.transfer;
        let opacity = transfer.opacity_points().points().iter().map(|&(value, [a])| [value, a]);
        let color =
            transfer.color_points().points().iter().map(|&(value, [r, g, b])| [value, r, g, b]);
        json!({
            "name": preset.name,
            "values": preset.suited.name(),
            "about": preset.about,
            "opacity": opacity.collect::<Vec<_>>(),
            "color": color.collect::<Vec<_>>(),
            "sources": preset.sources,
        })
    };
    format!("{:#}\n", presets.iter().map(one).collect::<Value>())
}
