//! Which volume is read of a file that holds several, and which there are.

use std::fmt;
use std::ops::Range;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::LoadedVolume;
use super::colors::{ColorUse, LoadedColors, OpacitySource};
use super::data::Share;
use super::formats::Input;
use super::zarr::ChunkCache;
use crate::printable::printable;
use crate::progress::ReadMeter;
use crate::{IoError, ProgressCallback, ReadProgress};

/// Of a name.
const MAX_NAME_CHARS: usize = 100;

/// Names that a message lists.
const MAX_LISTED: usize = 12;

/// Which volume is read, where a file or a folder holds several. What is left open is found out: of series
/// the largest is taken, of levels the finest that there is room for, of all else the first; a warning
/// says so.
///
/// ```
/// use slabsplat_io::VolumeOptions;
///
/// let options = VolumeOptions::default().channel(1).time(20);
/// assert_eq!((options.series, options.channel, options.time), (None, Some(1), Some(20)));
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[non_exhaustive]
pub struct VolumeOptions {
    /// Which series of a folder, or image of a file, counted from 0.
    pub series: Option<usize>,
    /// Which of the values that each voxel has, counted from 0.
    pub channel: Option<usize>,
    /// Which moment, counted from 0.
    pub time: Option<usize>,
    /// How coarse: 0 is the finest.
    pub level: Option<usize>,
    /// In which colours voxels of three or four values are drawn; by default in their own, if they are meant
    /// to be colours.
    pub colors: Option<ColorUse>,
    /// What their opacity is made of; by default alpha, if there is one that tells voxels apart, or else
    /// luminance.
    pub opacity_from: Option<OpacitySource>,
    /// Which array of a file that names its arrays; the path may say it, too, as `a.npz:name`.
    pub array: Option<String>,
    /// Whether a header may name files outside of its own folder; they are refused otherwise, since who
    /// wrote the header need not be who opens it.
    pub allow_external: bool,
    /// Which voxels along x, y and z; by default all. Of raw data, be they in NRRD, NIfTI, MetaImage, MRC,
    /// NumPy or a file of their own, and of OME-Zarr, no others are held in memory; other files are not read
    /// so ([`IoError::NotInBoxes`]). Of colours with alpha that is the opacity, unless something else is
    /// asked for: whether it tells voxels apart is not known of some.
    pub voxels: Option<[Range<usize>; 3]>,
    /// What hears how far reading is; it is no part of what is serialized.
    #[serde(skip)]
    pub progress: Option<ProgressCallback>,
    /// What several boxes of a store of chunks need of it.
    #[serde(skip)]
    pub(crate) chunks: Option<ChunkCache>,
}

/// A way in which a file may hold several volumes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Part {
    /// Volumes that have nothing to do with each other but that they are in one place.
    Series,
    /// Values of one voxel.
    Channel,
    /// Moments.
    Time,
    /// The same at several resolutions.
    Level,
}

/// How many parts of a kind there are, and which was read.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[non_exhaustive]
pub struct Choice {
    /// How many there are, at least 1.
    pub n: usize,
    /// What each is called; empty if they have no names.
    pub names: Vec<String>,
    /// Which of them was read, counted from 0.
    pub chosen: usize,
}

/// What a file holds, and what was read of it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[non_exhaustive]
pub struct VolumeChoices {
    /// Series of a folder, or images of a file.
    pub series: Choice,
    /// Values that each voxel has.
    pub channel: Choice,
    /// Moments.
    pub time: Choice,
    /// Resolutions, the finest first.
    pub level: Choice,
    /// Whether no single channel was read, but all values of a voxel, as its colour.
    pub is_color: bool,
    /// Whether nothing in the file says that they are one.
    pub(super) is_guess: bool,
}

impl VolumeOptions {
    /// Takes this series of a folder, or image of a file, counted from 0.
    #[must_use]
    pub fn series(self, series: usize) -> Self {
        Self { series: Some(series), ..self }
    }

    /// Takes this value of each voxel, counted from 0.
    #[must_use]
    pub fn channel(self, channel: usize) -> Self {
        Self { channel: Some(channel), ..self }
    }

    /// Takes this moment, counted from 0.
    #[must_use]
    pub fn time(self, time: usize) -> Self {
        Self { time: Some(time), ..self }
    }

    /// Takes this resolution; 0 is the finest.
    #[must_use]
    pub fn level(self, level: usize) -> Self {
        Self { level: Some(level), ..self }
    }

    /// Draws voxels of three or four values in these colours.
    #[must_use]
    pub fn colors(self, colors: ColorUse) -> Self {
        Self { colors: Some(colors), ..self }
    }

    /// Makes the opacity of voxels with colours of this.
    #[must_use]
    pub fn opacity_from(self, source: OpacitySource) -> Self {
        Self { opacity_from: Some(source), ..self }
    }

    /// Takes the array of this name.
    #[must_use]
    pub fn array(self, name: impl Into<String>) -> Self {
        Self { array: Some(name.into()), ..self }
    }

    /// Lets headers name files outside of their own folders.
    #[must_use]
    pub fn allow_external(self, allow_external: bool) -> Self {
        Self { allow_external, ..self }
    }

    /// Takes these voxels alone.
    #[must_use]
    pub fn voxels(self, voxels: [Range<usize>; 3]) -> Self {
        Self { voxels: Some(voxels), ..self }
    }

    /// Tells `hear` how far reading is, as [`ProgressCallback::new`] says.
    ///
    /// ```
    /// use slabsplat_io::{FilesInMemory, VolumeOptions};
    /// use std::sync::Arc;
    /// use std::sync::atomic::{AtomicU64, Ordering};
    ///
    /// let n_done = Arc::new(AtomicU64::new(0));
    /// let heard = n_done.clone();
    /// let options = VolumeOptions::default()
    ///     .on_progress(move |progress| heard.store(progress.n_done, Ordering::Relaxed));
    /// let nrrd = b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n\n12345678";
    /// FilesInMemory::from_iter([("a.nrrd", &nrrd[..])]).read_volume_with("a.nrrd", &options)?;
    /// assert_eq!(n_done.load(Ordering::Relaxed), 8);
    /// # Ok::<(), slabsplat_io::IoError>(())
    /// ```
    #[must_use]
    pub fn on_progress(self, hear: impl Fn(ReadProgress) + Send + Sync + 'static) -> Self {
        Self { progress: Some(ProgressCallback::new(hear)), ..self }
    }

    /// What is said of a part.
    pub fn get(&self, part: Part) -> Option<usize> {
        match part {
            Part::Series => self.series,
            Part::Channel => self.channel,
            Part::Time => self.time,
            Part::Level => self.level,
        }
    }

    /// Says what was chosen of what there is more of than one, and which colours, where nothing is said.
    pub fn choose(&mut self, loaded: &LoadedVolume) {
        if let Some(LoadedColors { voxels, opacity_from, .. }) = &loaded.colors {
            let use_of_colors = if voxels.is_some() { ColorUse::Own } else { ColorUse::None };
            self.colors = Some(use_of_colors);
            self.opacity_from = Some(*opacity_from);
        }
        for &part in Part::ALL {
            let Choice { n, chosen, .. } = *loaded.choices.get(part);
            // Of colours all channels are read.
            if part == Part::Channel && loaded.colors.is_some() {
                continue;
            }
            let option = match part {
                Part::Series => &mut self.series,
                Part::Channel => &mut self.channel,
                Part::Time => &mut self.time,
                Part::Level => &mut self.level,
            };
            *option = option.or((1 < n).then_some(chosen));
        }
    }

    /// That there is what is asked for.
    pub(crate) fn check(&self, path: &Path, choices: &VolumeChoices) -> Result<(), IoError> {
        for &part in Part::ALL {
            choices.get(part).index_of(self.get(part), part, path)?;
        }
        self.check_colors(path, choices)
    }

    /// That there are colours, if something is asked for that only those have.
    fn check_colors(&self, path: &Path, choices: &VolumeChoices) -> Result<(), IoError> {
        let asked = match (self.colors, self.opacity_from) {
            (_, Some(_)) => "opacity_from",
            (Some(ColorUse::Own), _) => "colors",
            (Some(ColorUse::None) | None, None) => return Ok(()),
        };
        if choices.is_color {
            return Ok(());
        }
        let what = match self.channel {
            Some(_) => {
                format!("one channel has no colours of its own: leave out channel, or {asked}")
            }
            None => format!(
                "its voxels have no colours, which are three or four integers of 8 or 16 bits: leave out {asked}"
            ),
        };
        Err(IoError::unsupported(path, what))
    }
}

impl Part {
    /// All of them.
    pub const ALL: &[Self] = &[Self::Series, Self::Channel, Self::Time, Self::Level];

    /// The part's name, as flags and keys spell it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Series => "series",
            Self::Channel => "channel",
            Self::Time => "time",
            Self::Level => "level",
        }
    }

    fn plural(self) -> &'static str {
        match self {
            Self::Series => "series",
            Self::Channel => "channels",
            Self::Time => "times",
            Self::Level => "levels",
        }
    }
}

impl Default for Choice {
    fn default() -> Self {
        Self { n: 1, names: Vec::new(), chosen: 0 }
    }
}

impl Choice {
    /// The part that is asked for, or else `chosen`.
    fn index_of(&self, asked: Option<usize>, part: Part, path: &Path) -> Result<usize, IoError> {
        let chosen = asked.unwrap_or(self.chosen);
        if chosen < self.n {
            return Ok(chosen);
        }
        let part = part.name();
        let there = self.to_string();
        Err(IoError::NoSuchPart { path: path.to_owned(), part, asked: chosen, there })
    }
}

/// All that may be chosen: `0 to 2 (0 DAPI, 1 GFP, 2 RFP)`.
impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.n {
            1 => f.write_str("only 0")?,
            n => write!(f, "0 to {}", n - 1)?,
        }
        if self.names.is_empty() {
            return Ok(());
        }
        let names = self.names.iter().take(MAX_LISTED).enumerate();
        let names: Vec<String> = names.map(|(idx, name)| format!("{idx} {name}")).collect();
        let more = if MAX_LISTED < self.names.len() { ", .." } else { "" };
        write!(f, " ({}{more})", names.join(", "))
    }
}

impl VolumeChoices {
    /// What there is of a part, and which was read.
    pub fn get(&self, part: Part) -> &Choice {
        match part {
            Part::Series => &self.series,
            Part::Channel => &self.channel,
            Part::Time => &self.time,
            Part::Level => &self.level,
        }
    }

    /// Which samples are read, of volumes that follow each other and channels that do in each voxel.
    pub(super) fn share(&self) -> Share {
        let (channel, time) = (&self.channel, &self.time);
        let [n_channels, channel] =
            if self.is_color { [1, 0] } else { [channel.n, channel.chosen] };
        Share { n_channels, channel, n_volumes: time.n, volume: time.chosen }
    }

    /// Whether there is one volume and no more.
    pub(super) fn is_single(&self) -> bool {
        let is_one = |part: Part| part == Part::Channel && self.is_color || self.get(part).n == 1;
        Part::ALL.iter().all(|&part| is_one(part))
    }

    /// What was chosen though nobody said so.
    pub(super) fn warnings(&self, options: &VolumeOptions) -> impl Iterator<Item = String> {
        let n_values = self.channel.n;
        let of_colors = (self.is_guess && options.colors.is_none()).then(|| {
            format!(
                "{n_values} values of 8 bits a voxel were taken for its colour: --channel takes one alone"
            )
        });
        let of_parts = Part::ALL.iter().filter_map(|&part| {
            let choice = self.get(part);
            let is_named = part == Part::Series && options.array.is_some();
            let is_read_whole = part == Part::Channel && self.is_color;
            let is_guess =
                1 < choice.n && options.get(part).is_none() && !is_named && !is_read_whole;
            is_guess.then(|| {
                let (name, many) = (part.name(), part.plural());
                format!("there are {} {many}: {name} {} was taken", choice.n, choice.chosen)
            })
        });
        of_parts.chain(of_colors)
    }
}

impl Input<'_> {
    /// Counts how much of so many bytes has been read.
    pub(super) fn meter(&self, n_bytes: u64) -> ReadMeter {
        ReadMeter::new(self.options.progress.as_ref(), n_bytes)
    }

    /// Which of `n` parts is to be read: the one that is asked for, or the first.
    ///
    /// # Errors
    /// If there is none of that number.
    pub(super) fn choose(&self, part: Part, n: usize) -> Result<Choice, IoError> {
        self.choose_of(part, Choice { n, ..Choice::default() })
    }

    /// Which is to be read: the one that is asked for, or else the one that is chosen already.
    ///
    /// # Errors
    /// If there is none of that number.
    pub(super) fn choose_of(&self, part: Part, mut choice: Choice) -> Result<Choice, IoError> {
        // Names are a file's, and are shown on terminals.
        for name in &mut choice.names {
            *name = printable(name).chars().take(MAX_NAME_CHARS).collect();
        }
        let chosen = choice.index_of(self.options.get(part), part, self.path)?;
        choice.chosen = chosen;
        Ok(choice)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::Store;
    use slabsplat_core::{Grid, Scaling, Volume};

    #[test]
    fn choices_are_what_is_there() {
        let options = VolumeOptions::default().channel(2);
        let input =
            Input { store: Store::Disk, path: Path::new("a.tif"), options: &options, spill: None };
        assert_eq!(input.choose(Part::Channel, 3).unwrap().chosen, 2);
        assert_eq!(input.choose(Part::Time, 3).unwrap().chosen, 0);
        let largest = Choice { n: 4, names: vec![], chosen: 3 };
        assert_eq!(input.choose_of(Part::Series, largest).unwrap().chosen, 3);
        let names = ["DAPI", "GFP"].map(str::to_owned).to_vec();
        for (choice, expected) in [
            (Choice { n: 2, names, chosen: 0 }, "0 to 1 (0 DAPI, 1 GFP)"),
            (Choice { n: 2, names: vec![], chosen: 0 }, "0 to 1"),
            (Choice::default(), "only 0"),
        ] {
            let error = input.choose_of(Part::Channel, choice).unwrap_err().to_string();
            assert_eq!(error, format!("a.tif: there is no channel 2: there is {expected}"));
        }
        let names = vec!["a\u{1b}[2J\n".to_owned(), "x".repeat(999)];
        let shown = input.choose_of(Part::Time, Choice { n: 2, names, chosen: 0 }).unwrap().names;
        assert_eq!((shown[0].as_str(), shown[1].len()), ("a\u{fffd}[2J\u{fffd}", MAX_NAME_CHARS));
        let names = vec!["x".to_owned(); 99];
        assert!(Choice { n: 99, names, chosen: 0 }.to_string().ends_with("11 x, ..)"));
    }

    #[test]
    fn choices_that_nobody_made_are_warned_of() {
        let two = Choice { n: 2, names: vec![], chosen: 1 };
        let choices = VolumeChoices { time: two, ..VolumeChoices::default() };
        let warnings = |options: VolumeOptions| choices.warnings(&options).collect::<Vec<_>>();
        assert_eq!(warnings(VolumeOptions::default()), ["there are 2 times: time 1 was taken"]);
        assert_eq!(warnings(VolumeOptions::default().time(1)), [""; 0]);
        let mut chosen = VolumeOptions::default().channel(3);
        let samples = vec![0_u8, 1].into();
        let grid = Grid::with_spacing([2, 1, 1], [1.0; 3]).unwrap();
        let volume = Volume::new(grid, samples, Scaling::IDENTITY).unwrap();
        let mut loaded = LoadedVolume { choices, ..LoadedVolume::computed(volume) };
        chosen.choose(&loaded);
        assert_eq!(chosen, VolumeOptions::default().channel(3).time(1));
        let opacity_from = OpacitySource::Alpha;
        loaded.choices.channel.n = 4;
        loaded.colors = Some(LoadedColors { voxels: None, has_alpha: true, opacity_from });
        let mut of_colors = VolumeOptions::default();
        of_colors.choose(&loaded);
        let expected = VolumeOptions { colors: Some(ColorUse::None), ..VolumeOptions::default() };
        let expected = VolumeOptions { opacity_from: Some(opacity_from), ..expected };
        assert_eq!(of_colors, expected.time(1));
        let choices = loaded.choices;
        let options = VolumeOptions::default().series(1);
        assert!(options.check(Path::new("a"), &choices).is_err());
    }
}
