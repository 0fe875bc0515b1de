//! What is behind a picture, as people say it: in scene files and on command lines, by one parser.

use std::fmt;
use std::str::FromStr;

use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// A colour, or a gradient from one at the upper edge to another at the lower.
///
/// ```
/// use slabsplat_io::Background;
///
/// let white = [1.0; 4];
/// assert_eq!("white".parse(), Ok(Background::new(white)));
/// let blue = [0.0, 0.0, 1.0, 0.5];
/// assert_eq!("#fff:0,0,1,0.5".parse(), Ok(Background::new(white).below(blue)));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Background {
    /// Straight red, green, blue and opacity, 0 … 1 each.
    pub above: [f32; 4],
    /// The same of a gradient's lower end.
    pub below: Option<[f32; 4]>,
}

/// Why a text is no background.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NotABackground {
    /// It is no colour.
    #[error(
        "{0:?} is no colour: name one of CSS, as steelblue, or give #rrggbb, or R,G,B or R,G,B,A from 0 to 1"
    )]
    NotAColor(String),
    /// A channel is outside 0 … 1.
    #[error("red, green, blue and opacity are from 0 to 1 each, not {0:?}")]
    BadChannel(String),
}

impl Background {
    /// One colour.
    pub fn new(above: [f32; 4]) -> Self {
        Self { above, below: None }
    }

    /// The same as a gradient to that colour.
    #[must_use]
    pub fn below(self, below: [f32; 4]) -> Self {
        Self { below: Some(below), ..self }
    }
}

impl FromStr for Background {
    type Err = NotABackground;

    /// A colour, or two of them parted by a colon: names of CSS, `#rgb`, `#rrggbb` and with opacity `#rgba`,
    /// `#rrggbbaa`; `R,G,B` or `R,G,B,A`, 0 to 1 each. What says no opacity is opaque.
    fn from_str(text: &str) -> Result<Self, NotABackground> {
        match text.split_once(':') {
            None => Ok(Self { above: color(text)?, below: None }),
            Some((above, below)) => Ok(Self { above: color(above)?, below: Some(color(below)?) }),
        }
    }
}

fn color(text: &str) -> Result<[f32; 4], NotABackground> {
    let text = text.trim();
    let unknown = || NotABackground::NotAColor(text.to_owned());
    if text.starts_with(|c: char| c == '#' || c.is_ascii_alphabetic()) {
        // The parser also takes functions, of colours that are not whole numbers of 255.
        let is_function = text.contains('(');
        let color = color::parse_color(text).ok().filter(|_| !is_function).ok_or_else(unknown)?;
        let channels = color.to_alpha_color::<color::Srgb>().to_rgba8().to_u8_array();
        return Ok(channels.map(|channel| f32::from(channel) / 255.0));
    }
    let numbers: Result<Vec<f32>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    let color = of_channels(&numbers.map_err(|_| unknown())?).ok_or_else(unknown)?;
    let is_color = color.iter().all(|channel| (0.0..=1.0).contains(channel));
    if is_color { Ok(color) } else { Err(NotABackground::BadChannel(text.to_owned())) }
}

/// Three channels are opaque; `None` if there are neither three nor four.
fn of_channels(channels: &[f32]) -> Option<[f32; 4]> {
    match *channels {
        [r, g, b] => Some([r, g, b, 1.0]),
        [r, g, b, a] => Some([r, g, b, a]),
        _ => None,
    }
}

/// A text, or an array of three or four numbers.
struct TextOrChannels;

impl<'de> Visitor<'de> for TextOrChannels {
    type Value = Background;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a colour, or an array of 3 or 4 numbers from 0 to 1")
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Background, E> {
        text.parse().map_err(E::custom)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Background, A::Error> {
        let mut channels = Vec::new();
        while let Some(channel) = seq.next_element()? {
            channels.push(channel);
            if 4 < channels.len() {
                break;
            }
        }
        let above = of_channels(&channels)
            .ok_or_else(|| A::Error::invalid_length(channels.len(), &"3 or 4 numbers"))?;
        Ok(Background { above, below: None })
    }
}

impl<'de> Deserialize<'de> for Background {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(TextOrChannels)
    }
}

impl Serialize for Background {
    /// A colour as numbers, which are read back to the bit; of two of them that is a text.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Some(below) = self.below else { return self.above.serialize(serializer) };
        let text_of = |channels: [f32; 4]| channels.map(|channel| channel.to_string()).join(",");
        serializer.serialize_str(&format!("{}:{}", text_of(self.above), text_of(below)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn background_is_written_and_read_back() {
        let check = |background: Background, expected: &str| {
            let text = serde_json::to_string(&background).unwrap();
            assert_eq!(text, expected);
            assert_eq!(serde_json::from_str::<Background>(&text).unwrap(), background);
        };
        let above = [0.5, 1.0, 0.0, 0.25];
        check(Background { above, below: None }, "[0.5,1.0,0.0,0.25]");
        let below = Some([0.1, 1.0 / 3.0, 0.0, 1.0]);
        check(Background { above, below }, "\"0.5,1,0,0.25:0.1,0.33333334,0,1\"");
        let opaque: Background = serde_json::from_str("[0, 0.5, 1]").unwrap();
        assert_eq!(opaque, "0,0.5,1,1".parse().unwrap());
        for text in ["[0, 0]", "[0, 0, 0, 0, 0]", "1", "true", "[\"a\"]", "\"wite\""] {
            assert!(serde_json::from_str::<Background>(text).is_err(), "{text}");
        }
    }

    #[test]
    fn background_is_said_in_many_ways() {
        let check = |text: &str, above: [f32; 4], below: Option<[f32; 4]>| {
            assert_eq!(text.parse(), Ok(Background { above, below }), "{text}");
        };
        check("0,0.5,1", [0.0, 0.5, 1.0, 1.0], None);
        check(" 0, 0.5 ,1,0 ", [0.0, 0.5, 1.0, 0.0], None);
        check("White", [1.0; 4], None);
        check("transparent", [0.0; 4], None);
        check("#f00", [1.0, 0.0, 0.0, 1.0], None);
        check("#f000", [1.0, 0.0, 0.0, 0.0], None);
        check("#00ff0000", [0.0, 1.0, 0.0, 0.0], None);
        check("#336699", [0.2, 0.4, 0.6, 1.0], None);
        check("white:#000", [1.0; 4], Some([0.0, 0.0, 0.0, 1.0]));
        check("0,0,0 : 0,0,1,0.5", [0.0, 0.0, 0.0, 1.0], Some([0.0, 0.0, 1.0, 0.5]));
    }

    #[test]
    fn background_says_what_is_wrong() {
        for (text, expected) in [
            ("nonsense", "\"nonsense\" is no colour: name one of CSS"),
            ("bad", "\"bad\" is no colour"),
            ("#ggg", "\"#ggg\" is no colour"),
            ("rgb(1,2,3)", "is no colour"),
            ("", "\"\" is no colour"),
            ("white:", "\"\" is no colour"),
            ("white:wite", "\"wite\" is no colour"),
            ("a:b:c", "is no colour"),
            ("1,1", "\"1,1\" is no colour"),
            ("1,1,1,1,1", "is no colour"),
            ("1,x,1", "\"1,x,1\" is no colour"),
            ("2,0,0", "from 0 to 1 each, not \"2,0,0\""),
            ("0,0,NaN", "from 0 to 1 each"),
        ] {
            let error = text.parse::<Background>().unwrap_err().to_string();
            assert!(error.contains(expected), "{text}: {error} should contain {expected}");
        }
    }
}
