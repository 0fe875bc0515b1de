//! Whole DICOM files, written here element by element.

mod written;

mod choices;
mod frames_and_colors;
mod places;
mod refused;
mod syntaxes;

use slabsplat_core::Samples;

use crate::{FilesInMemory, IoError, LoadedVolume, VolumeOptions};
use written::{EXPLICIT, file, slice};

fn read_with(files: &[Vec<u8>], options: &VolumeOptions) -> Result<LoadedVolume, IoError> {
    // Names in an order that is none.
    let names: Vec<String> = (0..files.len()).map(|idx| format!("in/{}", (idx * 7) % 10)).collect();
    let files = names.iter().map(String::as_str).zip(files.iter().map(Vec::as_slice));
    FilesInMemory::from_iter(files).read_volume_with("in", options)
}

fn read(files: &[Vec<u8>]) -> Result<LoadedVolume, String> {
    read_with(files, &VolumeOptions::default()).map_err(|error| error.to_string())
}

fn ct(heights: &[f64]) -> Vec<Vec<u8>> {
    let slices = heights.iter().map(|&z| slice(z, [1, 2, 3, 1000_u16.saturating_add(z as u16)]));
    slices.map(|elements| file(EXPLICIT, &elements)).collect()
}

fn samples(loaded: &LoadedVolume) -> Vec<u16> {
    let Samples::U16(samples) = loaded.volume.samples() else { panic!("{loaded:?}") };
    samples.clone()
}
