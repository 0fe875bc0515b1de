//! A section whose keys are the rows of a settings table, beside one key that is none of them.

use std::fmt;
use std::marker::PhantomData;

use serde::de::{Deserialize, DeserializeSeed, Deserializer, Error, MapAccess, Visitor};
use slabsplat_core::{Access, Field, KernelName, Setting, Settings};

/// The settings of a section, by default those of `S`, and the word of its other key.
#[derive(Debug)]
pub(super) struct SettingsSection<S> {
    pub(super) settings: S,
    pub(super) other: Option<String>,
}

/// A table with the section that its settings stand in.
pub(super) trait Section: Settings {
    /// The keys that the section may have: one a row, and last the one that is none.
    const KEYS: &'static [&'static str];
}

/// The names of `rows`, and `other`.
pub(super) const fn keys<S, const N: usize>(
    rows: &[Setting<S>],
    other: &'static str,
) -> [&'static str; N] {
    let mut keys = [other; N];
    let mut idx = 0;
    while idx < rows.len() {
        keys[idx] = rows[idx].name;
        idx += 1;
    }
    keys
}

impl<S: Section> Default for SettingsSection<S> {
    fn default() -> Self {
        Self { settings: S::default(), other: None }
    }
}

impl<'de, S: Section> Deserialize<'de> for SettingsSection<S> {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        d.deserialize_map(SectionVisitor(PhantomData))
    }
}

struct SectionVisitor<S>(PhantomData<S>);

impl<'de, S: Section> Visitor<'de> for SectionVisitor<S> {
    type Value = SettingsSection<S>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a section")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        let mut section = SettingsSection::default();
        while let Some(row) = map.next_key_seed(RowSeed(PhantomData))? {
            match row {
                Some(row) => map.next_value_seed(ValueSeed(row, &mut section.settings))?,
                None => section.other = Some(map.next_value()?),
            }
        }
        Ok(section)
    }
}

/// A key is turned into its row while the reader still knows where it stands; `None` is the other key.
struct RowSeed<S>(PhantomData<S>);

impl<'de, S: Section> DeserializeSeed<'de> for RowSeed<S> {
    type Value = Option<&'static Setting<S>>;

    fn deserialize<D: Deserializer<'de>>(self, d: D) -> Result<Self::Value, D::Error> {
        let key = String::deserialize(d)?;
        if S::KEYS.contains(&key.as_str()) {
            return Ok(S::ROWS.iter().find(|row| row.name == key));
        }
        Err(D::Error::unknown_field(&key, S::KEYS))
    }
}

/// Reads the value of a row into the settings.
struct ValueSeed<'a, S: 'static>(&'static Setting<S>, &'a mut S);

impl<'de, S> DeserializeSeed<'de> for ValueSeed<'_, S> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, d: D) -> Result<(), D::Error> {
        let Self(row, settings) = self;
        match &row.field {
            Field::Choice { set, .. } => {
                set(settings, &String::deserialize(d)?).map_err(D::Error::custom)?;
            }
            Field::Kernel(Access { set, .. }) => {
                set(settings, KernelName(String::deserialize(d)?.into()));
            }
            Field::Number { access, .. } => (access.set)(settings, f64::deserialize(d)?),
            Field::Count { access, .. } => (access.set)(settings, u32::deserialize(d)?),
            Field::Switch(Access { set, .. }) => set(settings, bool::deserialize(d)?),
        }
        Ok(())
    }
}
