//! Values of a scene file that are words, or a word or numbers.

use std::fmt;

use serde::de::value::SeqAccessDeserializer;
use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};
use slabsplat_core::glam::DVec3;
use slabsplat_core::{Compositing, Light, Lookup, Method, Normalization};

use super::camera::ProjectionKind;

/// A closed set of names.
pub(super) trait Choice: Copy + 'static {
    const CHOICES: &'static [Self];

    fn word(self) -> &'static str;
}

macro_rules! impl_choice {
    ($($ty:ty),*) => {$(
        impl Choice for $ty {
            const CHOICES: &'static [Self] = Self::ALL;

            fn word(self) -> &'static str {
                self.name()
            }
        }
    )*};
}

impl_choice!(Method, Compositing, Normalization, Lookup, ProjectionKind);

/// One of the names of `T`.
pub(super) fn choice<'de, D: Deserializer<'de>, T: Choice>(d: D) -> Result<T, D::Error> {
    let word = String::deserialize(d)?;
    T::CHOICES.iter().copied().find(|choice| choice.word() == word).ok_or_else(|| {
        let words: Vec<&str> = T::CHOICES.iter().map(|choice| choice.word()).collect();
        D::Error::custom(format!("{word:?} is not a choice here: use one of {}", words.join(", ")))
    })
}

/// The same for a key that has no default.
pub(super) fn maybe_choice<'de, D: Deserializer<'de>, T: Choice>(
    d: D,
) -> Result<Option<T>, D::Error> {
    choice(d).map(Some)
}

/// `"headlight"`, or the direction towards the light.
pub(super) fn light<'de, D: Deserializer<'de>>(d: D) -> Result<Light, D::Error> {
    struct LightVisitor;

    impl<'de> Visitor<'de> for LightVisitor {
        type Value = Light;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("\"headlight\" or a direction [x, y, z]")
        }

        fn visit_str<E: Error>(self, word: &str) -> Result<Light, E> {
            match word {
                "headlight" => Ok(Light::Headlight),
                other => Err(E::custom(format!(
                    "{other:?} is no light: use \"headlight\" or a direction [x, y, z]"
                ))),
            }
        }

        fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<Light, A::Error> {
            let direction = <[f64; 3]>::deserialize(SeqAccessDeserializer::new(seq))?;
            Light::towards(DVec3::from_array(direction)).map_err(A::Error::custom)
        }
    }

    d.deserialize_any(LightVisitor)
}
