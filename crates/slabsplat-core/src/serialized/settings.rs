//! A table of settings is a map from the names of its rows, beside which may stand one key that is no row.

use std::fmt;
use std::marker::PhantomData;

use serde::de::{DeserializeSeed, Error as _, MapAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::{Access, Field, KernelName, Phong, RenderSettings, Setting, Settings, Shading};

/// Reads a table of settings, and the word of a key beside its rows that is called `other`. What is left out
/// is as by default. Ranges are not checked.
///
/// # Errors
/// If a key is neither a row nor `other`, or a value is none of its row's type.
pub fn deserialize_settings<'de, S: Settings, D: Deserializer<'de>>(
    d: D,
    other: Option<&'static str>,
) -> Result<(S, Option<String>), D::Error> {
    d.deserialize_map(TableVisitor { other, table: PhantomData })
}

/// Writes a table of settings, after a key beside its rows and its word.
///
/// # Errors
/// As the serializer.
pub fn serialize_settings<S: Settings, Z: Serializer>(
    settings: &S,
    other: Option<(&'static str, &str)>,
    serializer: Z,
) -> Result<Z::Ok, Z::Error> {
    let mut map = serializer.serialize_map(Some(S::ROWS.len() + usize::from(other.is_some())))?;
    if let Some((key, word)) = other {
        map.serialize_entry(key, word)?;
    }
    for row in S::ROWS {
        map.serialize_entry(row.name, &RowValue(row, settings))?;
    }
    map.end()
}

struct TableVisitor<S> {
    other: Option<&'static str>,
    table: PhantomData<S>,
}

impl<'de, S: Settings> Visitor<'de> for TableVisitor<S> {
    type Value = (S, Option<String>);

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a section")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        let (mut settings, mut word) = (S::default(), None);
        let key = || KeySeed { other: self.other, table: PhantomData };
        while let Some(row) = map.next_key_seed(key())? {
            match row {
                Some(row) => map.next_value_seed(ValueSeed(row, &mut settings))?,
                None => word = Some(map.next_value()?),
            }
        }
        Ok((settings, word))
    }
}

/// A key is turned into its row while the reader still knows where it stands; `None` is the other key.
struct KeySeed<S> {
    other: Option<&'static str>,
    table: PhantomData<S>,
}

impl<'de, S: Settings> DeserializeSeed<'de> for KeySeed<S> {
    type Value = Option<&'static Setting<S>>;

    fn deserialize<D: Deserializer<'de>>(self, d: D) -> Result<Self::Value, D::Error> {
        let key = String::deserialize(d)?;
        if self.other == Some(&key) {
            return Ok(None);
        }
        S::ROWS.iter().find(|row| row.name == key).map(Some).ok_or_else(|| {
            let known = S::ROWS.iter().map(|row| row.name).chain(self.other);
            let known = known.map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
            // As serde words it, whose own message takes a list that is known when it is compiled.
            D::Error::custom(format!("unknown field `{key}`, expected one of {known}"))
        })
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
            Field::Kernel(Access { set, .. }) => set(settings, KernelName::deserialize(d)?),
            Field::Number { access, .. } => (access.set)(settings, f64::deserialize(d)?),
            Field::Count { access, .. } => (access.set)(settings, u32::deserialize(d)?),
            Field::Switch(Access { set, .. }) => set(settings, bool::deserialize(d)?),
        }
        Ok(())
    }
}

/// The value of a row, to be written.
struct RowValue<'a, S>(&'a Setting<S>, &'a S);

impl<S> Serialize for RowValue<'_, S> {
    fn serialize<Z: Serializer>(&self, serializer: Z) -> Result<Z::Ok, Z::Error> {
        let Self(row, settings) = *self;
        match &row.field {
            Field::Choice { get, .. } => serializer.serialize_str(get(settings)),
            Field::Kernel(access) => (access.get)(settings).serialize(serializer),
            Field::Number { access, .. } => serializer.serialize_f64((access.get)(settings)),
            Field::Count { access, .. } => serializer.serialize_u32((access.get)(settings)),
            Field::Switch(access) => serializer.serialize_bool((access.get)(settings)),
        }
    }
}

impl<'de> Deserialize<'de> for RenderSettings {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        let (settings, _) = deserialize_settings::<Self, D>(d, None)?;
        settings.checked().map_err(D::Error::custom)
    }
}

impl Serialize for RenderSettings {
    fn serialize<Z: Serializer>(&self, serializer: Z) -> Result<Z::Ok, Z::Error> {
        serialize_settings(self, None, serializer)
    }
}

impl Shading {
    /// The key of a scene file's section that says which it is.
    pub const MODEL_KEY: &'static str = "model";

    /// What that key may say.
    pub const MODELS: &[&'static str] = &["phong", "none"];

    /// The shading of that model, with those coefficients if it has any.
    ///
    /// # Errors
    /// If there is no such model.
    pub fn of_model(model: Option<&str>, phong: Phong) -> Result<Self, crate::NotAChoice> {
        match model {
            Some("phong") | None => Ok(Self::Phong(phong)),
            Some("none") => Ok(Self::None),
            Some(word) => Err(crate::NotAChoice { word: word.to_owned(), choices: Self::MODELS }),
        }
    }
}

impl<'de> Deserialize<'de> for Shading {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        let (phong, model) = deserialize_settings::<Phong, D>(d, Some(Self::MODEL_KEY))?;
        let phong = phong.checked().map_err(D::Error::custom)?;
        Self::of_model(model.as_deref(), phong).map_err(D::Error::custom)
    }
}

impl Serialize for Shading {
    fn serialize<Z: Serializer>(&self, serializer: Z) -> Result<Z::Ok, Z::Error> {
        let (model, phong) = match self {
            Self::None => ("none", &Phong::default()),
            Self::Phong(phong) => ("phong", phong),
        };
        serialize_settings(phong, Some((Self::MODEL_KEY, model)), serializer)
    }
}
