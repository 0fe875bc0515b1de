//! Arrays in an archive, each a `.npy` of its own.

use super::super::choices::{Choice, Part};
use super::super::formats::{Input, VolumeListing};
use super::super::placed::Metered;
use super::super::zip::{Entry, ZipFile};
use super::header::Header;
use super::{Array, LoadedVolume};
use crate::IoError;

pub(super) fn read(input: &Input<'_>) -> Result<LoadedVolume, IoError> {
    let zip = ZipFile::open(input.store, input.path)?;
    let (entry, series) = choose(input, &zip)?;
    let mut reader = zip.reader(entry)?;
    let n_left = reader.n_left_at_most();
    let array = Array::open(input, &mut reader)?;
    let meter = input.meter(array.n_bytes());
    let mut metered = Metered { source: &mut reader, meter: &meter };
    let loaded = array.read(input, &mut metered, n_left)?;
    if !reader.ends_soundly().map_err(IoError::read(input.path))? {
        let what = format!("{} in the archive is damaged: its checksum is another", entry.name);
        return Err(IoError::malformed(input.path, what));
    }
    let choices = super::choices_with(series, loaded.choices.clone());
    Ok(LoadedVolume { choices, ..loaded })
}

pub(super) fn list(input: &Input<'_>) -> Result<VolumeListing, IoError> {
    let zip = ZipFile::open(input.store, input.path)?;
    let (entry, series) = choose(input, &zip)?;
    let listing = Array::open(input, &mut zip.reader(entry)?)?.listing();
    let choices = super::choices_with(series, listing.choices.clone());
    Ok(VolumeListing { choices, ..listing })
}

/// The array that is asked for, by name or by number; else the first that has the axes of a volume.
fn choose<'z>(input: &Input<'_>, zip: &'z ZipFile<'_>) -> Result<(&'z Entry, Choice), IoError> {
    let arrays: Vec<&Entry> =
        zip.entries().iter().filter(|entry| entry.name.ends_with(".npy")).collect();
    let names: Vec<String> = arrays.iter().map(|entry| name_of(entry).to_owned()).collect();
    if arrays.is_empty() {
        let what = "the ZIP archive holds no arrays of NumPy: unpack it, and open what is in it";
        return Err(IoError::unsupported(input.path, what));
    }
    let chosen = match &input.options.array {
        Some(asked) => names.iter().position(|name| name == asked).ok_or_else(|| {
            let there = names.iter().take(12).cloned().collect::<Vec<_>>().join(", ");
            let what = format!("there is no array {asked:?}: there is {there}");
            IoError::unsupported(input.path, what)
        })?,
        None => arrays.iter().position(|entry| 3 <= n_axes(zip, entry)).unwrap_or(0),
    };
    let mut series = Choice { n: arrays.len(), names, chosen };
    if input.options.array.is_none() {
        series = input.choose_of(Part::Series, series)?;
    }
    Ok((arrays[series.chosen], series))
}

fn name_of(entry: &Entry) -> &str {
    entry.name.trim_end_matches(".npy")
}

/// The number of an array's axes; of one that cannot be read, none.
fn n_axes(zip: &ZipFile<'_>, entry: &Entry) -> usize {
    let header = zip.reader(entry).ok().and_then(|mut reader| Header::read(&mut reader).ok());
    header.and_then(Result::ok).map_or(0, |header| header.shape.len())
}
