//! Files of transfer functions, by their extensions.

use std::io::Write;
use std::path::Path;

use slabsplat_core::{Layer, PiecewiseLinear, Shading, TransferFunction};

use super::TransferSource;
use super::paraview::{paraview_source, paraview_text};
use super::slicer::{slicer_source, slicer_text};
use super::toml_section::section_text;
use crate::picture::atomic;
use crate::{IoError, text};

/// Formats of files that hold a transfer function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum TransferFormat {
    /// ParaView's colour maps: `.json`.
    ParaView,
    /// 3D Slicer's volume properties: `.vp`, `.txt`.
    Slicer,
    /// The section `[classify]` of a scene: `.toml`; it is written alone.
    Scene,
}

impl TransferFormat {
    /// The format that the extension names.
    pub fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "json" => Some(Self::ParaView),
            "vp" | "txt" => Some(Self::Slicer),
            "toml" => Some(Self::Scene),
            _ => None,
        }
    }
}

/// Reads the transfer function of a file: of 3D Slicer's if it is named `.vp` or `.txt`, else the first
/// colour map of ParaView's.
///
/// # Errors
/// If the file cannot be read, is not of its format, or its points do not make a transfer function.
pub fn read_transfer(path: impl AsRef<Path>) -> Result<TransferSource, IoError> {
    let path = path.as_ref();
    parse_transfer(&text::read(path)?, path)
}

/// The transfer function that a text says, as [`read_transfer`] of a file of that name would; there need not
/// be one.
///
/// # Errors
/// As [`read_transfer`].
pub fn parse_transfer(text: &str, path: impl AsRef<Path>) -> Result<TransferSource, IoError> {
    let path = path.as_ref();
    let source = match TransferFormat::of(path) {
        Some(TransferFormat::Slicer) => slicer_source(text),
        Some(TransferFormat::ParaView | TransferFormat::Scene) | None => paraview_source(text),
    };
    source.map_err(|what| IoError::malformed(path, what))
}

/// How a layer's values look, as text of a format.
pub fn transfer_text(layer: &Layer, format: TransferFormat) -> String {
    let look = Look {
        transfer: &layer.transfer,
        gradient_opacity: layer.gradient_opacity.as_ref(),
        shading: layer.shading,
        unit: layer.volume.grid().unit(),
    };
    match format {
        TransferFormat::ParaView => paraview_text(&look),
        TransferFormat::Slicer => slicer_text(&look),
        TransferFormat::Scene => section_text(&look),
    }
}

/// Writes how a layer's values look into a file of the format that its extension says; a file of that name is
/// replaced once all of it is written.
///
/// # Errors
/// If the extension says no format, or the file cannot be written.
pub fn write_transfer(path: impl AsRef<Path>, layer: &Layer) -> Result<(), IoError> {
    let path = path.as_ref();
    let format = TransferFormat::of(path).ok_or_else(|| {
        let what = "a transfer function is written as .json (ParaView), .vp (3D Slicer) or .toml";
        IoError::unsupported(path, what)
    })?;
    atomic::write(path, |file| file.write_all(transfer_text(layer, format).as_bytes()))
}

/// What is written of a layer.
pub(super) struct Look<'a> {
    pub(super) transfer: &'a TransferFunction,
    pub(super) gradient_opacity: Option<&'a PiecewiseLinear<1>>,
    pub(super) shading: Shading,
    /// The world length that opacities are per.
    pub(super) unit: f64,
}
