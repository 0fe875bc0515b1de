//! Which volume is read of a file that holds several, and which there are.

use std::fmt;
use std::path::Path;

use super::data::Share;
use super::formats::Input;
use crate::IoError;
use crate::printable::printable;

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
#[derive(Clone, Debug, Default, PartialEq, Eq)]
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
    /// Which array of a file that names its arrays; the path may say it, too, as `a.npz:name`.
    pub array: Option<String>,
    /// Whether a header may name files outside of its own folder; they are refused otherwise, since who
    /// wrote the header need not be who opens it.
    pub allow_external: bool,
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
#[derive(Clone, Debug, PartialEq, Eq)]
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
#[derive(Clone, Debug, Default, PartialEq, Eq)]
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

    /// What is said of a part.
    pub fn get(&self, part: Part) -> Option<usize> {
        match part {
            Part::Series => self.series,
            Part::Channel => self.channel,
            Part::Time => self.time,
            Part::Level => self.level,
        }
    }

    /// Says what was chosen of what there is more of than one, where nothing is said.
    pub fn choose(&mut self, choices: &VolumeChoices) {
        for &part in Part::ALL {
            let Choice { n, chosen, .. } = *choices.get(part);
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
        Ok(())
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
        Share {
            n_channels: channel.n,
            channel: channel.chosen,
            n_volumes: time.n,
            volume: time.chosen,
        }
    }

    /// Whether there is one volume and no more.
    pub(super) fn is_single(&self) -> bool {
        Part::ALL.iter().all(|&part| self.get(part).n == 1)
    }

    /// What was chosen though nobody said so.
    pub(super) fn warnings(&self, options: &VolumeOptions) -> impl Iterator<Item = String> {
        Part::ALL.iter().filter_map(|&part| {
            let choice = self.get(part);
            let is_named = part == Part::Series && options.array.is_some();
            let is_guess = 1 < choice.n && options.get(part).is_none() && !is_named;
            is_guess.then(|| {
                let (name, many) = (part.name(), part.plural());
                format!("there are {} {many}: {name} {} was taken", choice.n, choice.chosen)
            })
        })
    }
}

impl Input<'_> {
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

    #[test]
    fn choices_are_what_is_there() {
        let options = VolumeOptions::default().channel(2);
        let input = Input { store: Store::Disk, path: Path::new("a.tif"), options: &options };
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
        chosen.choose(&choices);
        assert_eq!(chosen, VolumeOptions::default().channel(3).time(1));
        let options = VolumeOptions::default().series(1);
        assert!(options.check(Path::new("a"), &choices).is_err());
    }
}
