//! What goes through a WebSocket.

use serde_json::{Value, json};

/// A picture that a viewer asks for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Ask {
    /// Where it is shown: pictures of different panes do not replace each other.
    pub(crate) pane: usize,
    /// Tells pictures of a pane from each other.
    pub(crate) number: u64,
    pub(crate) urgency: Urgency,
    /// The numbers of the layers that the scene has; `None` if it has all.
    pub(crate) layers: Option<Vec<usize>>,
    /// A scene file, not looked at yet.
    pub(crate) scene: String,
}

/// How soon a picture is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Urgency {
    /// Something moves: a frame that has begun is drawn to its end, so that there is something to be seen.
    Moving,
    /// All is at rest: a frame that has begun is given up for one that is newer.
    AtRest,
}

/// Panes that a viewer has at most.
pub(crate) const MAX_PANES: usize = 4;

impl Urgency {
    fn name(self) -> &'static str {
        match self {
            Self::Moving => "moving",
            Self::AtRest => "rest",
        }
    }
}

impl Ask {
    /// The request that a text is; or what is wrong with it.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let mut value: Value = serde_json::from_str(text).map_err(|error| error.to_string())?;
        let pane = value["pane"].as_u64().and_then(|pane| usize::try_from(pane).ok());
        let pane = pane.filter(|&pane| pane < MAX_PANES);
        let pane = pane.ok_or_else(|| format!("pane must be 0 to {}", MAX_PANES - 1))?;
        let number = value["number"].as_u64().ok_or("number must be a whole number, 0 or more")?;
        let urgency = match value["urgency"].as_str() {
            Some("moving") => Urgency::Moving,
            Some("rest") => Urgency::AtRest,
            _ => return Err("urgency must be moving or rest".to_owned()),
        };
        let layers = parse_layers(&value["layers"])?;
        let Some(Value::String(scene)) = value.get_mut("scene").map(Value::take) else {
            return Err("scene must be the text of a scene file".to_owned());
        };
        Ok(Self { pane, number, urgency, layers, scene })
    }

    /// The message that this picture cannot be made.
    pub(crate) fn failed(&self, why: &str) -> String {
        json!({ "pane": self.pane, "number": self.number, "error": why }).to_string()
    }
}

/// Which layers a request names, if it does.
fn parse_layers(value: &Value) -> Result<Option<Vec<usize>>, String> {
    if value.is_null() {
        return Ok(None);
    }
    let number = |value: &Value| value.as_u64().and_then(|number| usize::try_from(number).ok());
    let numbers = value.as_array().and_then(|all| all.iter().map(number).collect());
    let numbers: Vec<usize> = numbers.ok_or("layers must be a list of whole numbers, 0 or more")?;
    if !numbers.is_sorted_by(|a, b| a < b) {
        return Err("layers must rise".to_owned());
    }
    Ok(Some(numbers))
}

/// The message that something should be known.
pub(crate) fn note(text: &str) -> String {
    json!({ "note": text }).to_string()
}

/// A picture as it is sent.
pub(crate) struct Encoded {
    pub(crate) format: &'static str,
    pub(crate) bytes: Vec<u8>,
    pub(crate) ms: f64,
    pub(crate) n_voxels: u64,
    pub(crate) notes: Vec<String>,
}

impl Encoded {
    /// The message that answers a request: the length of a header, the header, and the picture.
    pub(crate) fn message(&self, ask: &Ask) -> Vec<u8> {
        let header = json!({
            "pane": ask.pane,
            "number": ask.number,
            "urgency": ask.urgency.name(),
            "format": self.format,
            "ms": self.ms,
            "n_voxels": self.n_voxels,
            "notes": self.notes,
        });
        let header = header.to_string();
        let length = u32::try_from(header.len()).expect("a header has a few lines");
        [&length.to_le_bytes(), header.as_bytes(), &self.bytes].concat()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ask_is_parsed() {
        let text = r#"{"pane":3,"number":18446744073709551615,"urgency":"rest","scene":"a\nb"}"#;
        let (urgency, scene) = (Urgency::AtRest, "a\nb".to_owned());
        let expected = Ask { pane: 3, number: u64::MAX, urgency, layers: None, scene };
        assert_eq!(Ask::parse(text).as_ref(), Ok(&expected));
        let some = Ask::parse(&text.replace("\"scene\"", "\"layers\":[0,2],\"scene\""));
        assert_eq!(some, Ok(Ask { layers: Some(vec![0, 2]), ..expected }));
        for (from, to, expected) in [
            (":3", ":4", "pane must be 0 to 3"),
            (":3", ":-1", "pane must be 0 to 3"),
            ("18446744073709551615", "1.5", "number must be"),
            ("\"rest\"", "\"soon\"", "urgency must be"),
            ("\"a\\nb\"", "7", "scene must be"),
            ("}", ",\"layers\":3}", "layers must be"),
            ("}", ",\"layers\":[-1]}", "layers must be"),
            ("}", ",\"layers\":[1,1]}", "layers must rise"),
            ("}", "", "EOF"),
        ] {
            let error = Ask::parse(&text.replace(from, to)).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
        assert!(Ask::parse("[]").is_err() && Ask::parse("7").is_err());
    }
}
