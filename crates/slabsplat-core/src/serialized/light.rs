//! A light comes from `"headlight"`, or from a direction.

use std::fmt;

use serde::de::value::SeqAccessDeserializer;
use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::{Light, LightSource};

const HEADLIGHT: &str = "headlight";

impl<'de> Deserialize<'de> for LightSource {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        d.deserialize_any(SourceVisitor)
    }
}

struct SourceVisitor;

impl<'de> Visitor<'de> for SourceVisitor {
    type Value = LightSource;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("\"headlight\" or a direction [x, y, z]")
    }

    fn visit_str<E: Error>(self, word: &str) -> Result<LightSource, E> {
        match word {
            HEADLIGHT => Ok(LightSource::Headlight),
            other => Err(E::custom(format!(
                "{other:?} is no light: use \"headlight\" or a direction [x, y, z]"
            ))),
        }
    }

    fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<LightSource, A::Error> {
        let direction = <[f64; 3]>::deserialize(SeqAccessDeserializer::new(seq))?;
        Light::towards(direction).map(|light| light.source).map_err(A::Error::custom)
    }
}

impl Serialize for LightSource {
    fn serialize<Z: Serializer>(&self, serializer: Z) -> Result<Z::Ok, Z::Error> {
        match self {
            Self::Headlight => serializer.serialize_str(HEADLIGHT),
            Self::Direction(direction) => direction.get().to_array().serialize(serializer),
        }
    }
}
