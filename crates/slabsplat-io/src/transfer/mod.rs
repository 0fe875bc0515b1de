//! Transfer functions from elsewhere: by name, of ParaView and of 3D Slicer; and what fits them to a volume.
//!
//! Reading order: `source` (what a file or a preset says), `fit` (what else is asked for, before there is a
//! volume); `preset` and `presets/`, `colormap` and `colormaps.toml`; `file`, `paraview`, `slicer` (files),
//! `color_space` (how ParaView mixes colours), `toml_section` (what is written for scenes).

mod fit;
mod source;

mod colormap;
mod preset;

mod file;
mod paraview;
mod slicer;
mod toml_section;

mod color_space;

pub use colormap::{COLORMAP_NAMES, colormap};
pub use file::{TransferFormat, parse_transfer, read_transfer, transfer_text, write_transfer};
pub use fit::{FitError, Stretch, TransferFit};
pub use preset::{PRESET_NAMES, Preset, Suited, preset};
pub use source::{TransferSource, ValueScale};
