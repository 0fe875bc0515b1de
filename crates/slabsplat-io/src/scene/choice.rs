//! Values of a scene file that are words, or a word or numbers.

use std::fmt;

use serde::de::value::SeqAccessDeserializer;
use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};
use slabsplat_core::Light;
use slabsplat_core::glam::DVec3;

use super::camera::ProjectionKind;

/// Orthographic or perspective, for a key that has no default.
pub(super) fn projection<'de, D: Deserializer<'de>>(
    d: D,
) -> Result<Option<ProjectionKind>, D::Error> {
    let word = String::deserialize(d)?;
    ProjectionKind::from_name(&word).map(Some).map_err(D::Error::custom)
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
                "headlight" => Ok(Light::default()),
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
