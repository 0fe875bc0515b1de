//! Boxes of the samples in a scratch file, and what else is known of the volume that they are of.

use std::ops::Range;
use std::path::Path;

use slabsplat_core::{Acquisition, Grid, SampleType, Scaling};

use super::super::colors::Voxels;
use super::super::formats::Input;
use super::super::spill::Spill;
use super::super::stored::narrowed;
use super::super::window::Window;
use super::super::{
    Endian, LoadedVolume, OpacitySource, VolumeChoices, VolumeFormat, VolumeOptions,
};
use crate::IoError;
use crate::store::Store;

/// A volume without its samples, which are in a file.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Unpacked {
    /// Of the whole volume.
    pub(super) grid: Grid,
    pub(super) scaling: Scaling,
    /// The type of samples in the file.
    pub(super) spilled: SampleType,
    /// What they become: another type where integers of 64 bits were unpacked.
    pub(super) narrowed: SampleType,
    pub(super) format: VolumeFormat,
    pub(super) acquisition: Acquisition,
    pub(super) choices: VolumeChoices,
    pub(super) warnings: Vec<String>,
}

impl Unpacked {
    /// What was read, while its samples went there.
    pub(super) fn of(read: LoadedVolume, spill: &Spill) -> Self {
        let LoadedVolume { volume, format, acquisition, mut warnings, choices, .. } = read;
        let spilled = volume.sample_type();
        let mut narrowed = spilled;
        if let Some((stored, integers)) = spill.integers() {
            narrowed = integers.sample_type();
            warnings.push(integers.said_of(stored));
        }
        let (grid, scaling) = (volume.grid().uncropped(), volume.scaling());
        Self { grid, scaling, spilled, narrowed, format, acquisition, choices, warnings }
    }

    /// Samples in the file.
    pub(super) fn n_samples(&self) -> u64 {
        (self.grid.n_voxels() as u64).saturating_mul(self.choices.n_read() as u64)
    }

    /// Bytes that they take there.
    pub(super) fn n_bytes(&self) -> u64 {
        self.n_samples().saturating_mul(self.spilled.size_bytes() as u64)
    }

    /// A box of the volume, from its file and with the path of what it was unpacked from; of one of colours
    /// opacity is made of that.
    ///
    /// # Errors
    /// If there are no such voxels, or they cannot be read any more.
    pub(super) fn read(
        &self,
        (spill, path): (&Spill, &Path),
        voxels: &[Range<usize>; 3],
        options: &VolumeOptions,
        opacity_from: Option<OpacitySource>,
    ) -> Result<LoadedVolume, IoError> {
        let window = Window::of(path, &self.grid, voxels)?;
        let values = (self.spilled.into(), self.choices.n_read());
        let samples =
            spill.with_reader(|reader| window.place(path, reader, values, Endian::NATIVE))?;
        let samples = narrowed(samples, self.narrowed);
        let (grid, scaling) = (self.grid.cropped(voxels), self.scaling);
        let (choices, acquisition) = (self.choices.clone(), self.acquisition);
        let options =
            VolumeOptions { voxels: Some(voxels.clone()), opacity_from, ..options.clone() };
        let input = Input { store: Store::Disk, path, options: &options, spill: None };
        let read = Voxels { grid, samples, scaling, choices };
        let read = read.load(&input, self.format, Vec::new())?;
        Ok(LoadedVolume { acquisition, warnings: Vec::new(), ..read })
    }
}
