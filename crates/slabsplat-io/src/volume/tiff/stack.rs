//! Which pages are the slices of a volume, and how far apart.

use super::super::choices::{Choice, Part, VolumeChoices};
use super::super::formats::Input;
use super::super::stream::first_bytes;
use super::imagej::ImageJ;
use super::is_tiff;
use super::ome::{self, Ome, Page};
use super::pages::Pages;
use crate::{IoError, text};

/// The slices of one channel at one time.
#[derive(Debug)]
pub(super) struct Stack {
    /// Their pages, in the order of z.
    pub(super) slices: Vec<Page>,
    /// Millimetres, or whatever the file counts in.
    pub(super) spacing: [f64; 3],
    /// Which channel and time, and of how many.
    pub(super) choices: VolumeChoices,
}

/// Slices, channels and times.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Counts {
    pub(super) n_slices: usize,
    pub(super) n_channels: usize,
    pub(super) n_times: usize,
}

impl Stack {
    /// What the first page's description says of the others.
    pub(super) fn find(
        input: &Input<'_>,
        pages: &Pages<'_>,
        warnings: &mut Vec<String>,
    ) -> Result<Self, IoError> {
        let own_name = input.path.file_name().map(|name| name.to_string_lossy().into_owned());
        let elsewhere = description_elsewhere(input, pages)?;
        let description = elsewhere.as_ref().unwrap_or(&pages.description);
        if let Some(ome) = Ome::of(description, &own_name.unwrap_or_default(), pages.n_values) {
            let ome = ome.map_err(|what| pages.malformed(what))?;
            let choices = ome.counts.choices(input, pages, ome.channel_names.clone())?;
            let slices = ome.slices(pages_of(&choices, pages), pages.len());
            let slices = slices.map_err(|what| pages.unsupported(what))?;
            return Ok(Self { slices, spacing: ome.spacing(warnings), choices });
        }
        if let Some(imagej) = ImageJ::of(&pages.description) {
            let counts = imagej.counts(pages.len()).map_err(|what| pages.unsupported(what))?;
            let choices = counts.choices(input, pages, Vec::new())?;
            let [channel, time] = pages_of(&choices, pages);
            let page_of = |z| (time * counts.n_slices + z) * counts.n_channels + channel;
            let slices = (0..counts.n_slices).map(|z| Page::own(page_of(z))).collect();
            return Ok(Self {
                slices,
                spacing: imagej.spacing(pages.resolution, warnings),
                choices,
            });
        }
        warnings.push(super::super::units::NO_SIZE.to_owned());
        let slices = (0..pages.len()).map(Page::own).collect();
        let counts = Counts { n_slices: pages.len(), n_channels: 1, n_times: 1 };
        let choices = counts.choices(input, pages, Vec::new())?;
        Ok(Self { slices, spacing: [1.0; 3], choices })
    }

    pub(super) fn dims(&self, pages: &Pages<'_>) -> [usize; 3] {
        [pages.size[0], pages.size[1], self.slices.len()]
    }
}

/// The channel and the time that pages are of; pixels of several values have their channels within a page.
fn pages_of(choices: &VolumeChoices, pages: &Pages<'_>) -> [usize; 2] {
    let channel = if pages.n_values == 1 { choices.channel.chosen } else { 0 };
    [channel, choices.time.chosen]
}

impl Page {
    fn own(page_idx: usize) -> Self {
        Self { file: None, page_idx }
    }
}

/// The OME-XML of another file, to which this one refers.
fn description_elsewhere(input: &Input<'_>, pages: &Pages<'_>) -> Result<Option<String>, IoError> {
    let Some(name) = ome::metadata_file(&pages.description) else { return Ok(None) };
    let path = input.beside(&name)?;
    let start = first_bytes(input.store, &path)?;
    if is_tiff(&start) {
        return Ok(Some(Pages::open(input.store, &path)?.description));
    }
    text::read_from(input.store, &path).map(Some)
}

impl Counts {
    /// Which channel is read, and which time.
    fn choices(
        self,
        input: &Input<'_>,
        pages: &Pages<'_>,
        names: Vec<String>,
    ) -> Result<VolumeChoices, IoError> {
        let Self { n_slices: _, n_channels, n_times } = self;
        let time = input.choose(Part::Time, n_times)?;
        if 1 < pages.n_values {
            if 1 < n_channels {
                let what = "colours of several channels cannot be read: save one channel alone";
                return Err(pages.unsupported(what));
            }
            return Ok(VolumeChoices { time, ..input.choose_values(&pages.values())? });
        }
        let channels = Choice { n: n_channels, names, ..Choice::default() };
        Ok(VolumeChoices {
            channel: input.choose_of(Part::Channel, channels)?,
            time,
            ..VolumeChoices::default()
        })
    }
}
