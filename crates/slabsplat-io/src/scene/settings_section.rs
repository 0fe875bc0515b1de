//! A section whose keys are the rows of a settings table, beside one key that is none of them.

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use slabsplat_core::{
    Phong, RenderSettings, Settings, Shading, deserialize_settings, serialize_settings,
};

/// The settings of a section, by default those of `S`, and the word of its other key.
#[derive(Debug)]
pub(super) struct SettingsSection<S> {
    pub(super) settings: S,
    pub(super) other: Option<String>,
}

/// A table with the section that its settings stand in.
pub(super) trait Section: Settings {
    /// The key that is no row.
    const OTHER_KEY: &'static str;
}

impl Section for Phong {
    const OTHER_KEY: &'static str = Shading::MODEL_KEY;
}

impl Section for RenderSettings {
    const OTHER_KEY: &'static str = "backend";
}

impl<S: Section> Default for SettingsSection<S> {
    fn default() -> Self {
        Self { settings: S::default(), other: None }
    }
}

impl<'de, S: Section> Deserialize<'de> for SettingsSection<S> {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        let (settings, other) = deserialize_settings(d, Some(S::OTHER_KEY))?;
        Ok(Self { settings, other })
    }
}

impl<S: Section> Serialize for SettingsSection<S> {
    fn serialize<Z: Serializer>(&self, serializer: Z) -> Result<Z::Ok, Z::Error> {
        let other = self.other.as_deref().map(|word| (S::OTHER_KEY, word));
        serialize_settings(&self.settings, other, serializer)
    }
}
