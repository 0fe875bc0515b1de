//! Images in VTK's legacy format: lines of text, and after each array's line its numbers, in text or with the
//! most significant byte first.

use super::super::Endian;
use super::super::formats::{Input, VolumeListing};
use super::super::stored::StoredType;
use super::image::{self, ArrayDesc, Geometry, legacy_type};
use super::lines::Lines;
use super::text::NumbersInText;
use super::{Filling, LoadedVolume, n_bytes};
use crate::IoError;
use crate::printable::printable;

/// What a file says of its image, and where the numbers of each array are.
struct Header {
    geometry: Geometry,
    is_text: bool,
    arrays: Vec<ArrayDesc>,
    /// Where the numbers of each array begin.
    places: Vec<u64>,
    warnings: Vec<String>,
}

/// What the numbers that follow belong to.
#[derive(Clone, Copy)]
struct Attributes {
    is_of_cells: bool,
    are_colors: bool,
    n_tuples: u64,
}

const MAX_ARRAYS: usize = 1 << 12;

pub(super) fn is_begun_by(start: &[u8]) -> bool {
    start.starts_with(b"# vtk DataFile Version")
}

pub(super) fn list(input: &Input<'_>) -> Result<VolumeListing, IoError> {
    let header = Header::read(input)?;
    let chosen = image::choose(input, &header.arrays, None)?;
    image::listing(input, &header.geometry, &header.arrays[chosen.array_idx].clone(), chosen)
}

pub(super) fn read(input: &Input<'_>) -> Result<LoadedVolume, IoError> {
    let header = Header::read(input)?;
    let chosen = image::choose(input, &header.arrays, None)?;
    let array = &header.arrays[chosen.array_idx];
    let dims = header.geometry.grid(input, array.is_of_cells)?.dims();
    let (mut reader, n_left) = input.open_at(header.places[chosen.array_idx])?;
    let needed = match header.is_text {
        true => n_bytes(dims, array.n_components, StoredType::U8_SAMPLE).saturating_mul(2) - 1,
        false => n_bytes(dims, array.n_components, chosen.stored),
    };
    if n_left < needed {
        return Err(input.too_short(needed, n_left));
    }
    let endian = if header.is_text { Endian::NATIVE } else { Endian::Big };
    let mut filling = Filling::new(input, &header.geometry, array, &chosen, endian)?;
    if header.is_text {
        let mut numbers = match array.is_color {
            true => NumbersInText::of_shares(reader),
            false => NumbersInText::new(reader, chosen.stored),
        };
        filling.place(&mut numbers, dims, [0; 3])?;
    } else {
        filling.place(&mut reader, dims, [0; 3])?;
    }
    let is_of_cells = array.is_of_cells;
    filling.finish(&header.geometry, chosen, is_of_cells, header.warnings)
}

impl Header {
    fn read(input: &Input<'_>) -> Result<Self, IoError> {
        let (reader, n_bytes) = input.open_at(0)?;
        let mut lines = Lines { input, reader, n_bytes };
        // The version, and a title of any text.
        lines.next_raw()?;
        lines.next_raw()?;
        let kind = lines.next()?.unwrap_or_default();
        let is_text = match kind.to_uppercase().as_str() {
            "ASCII" => true,
            "BINARY" => false,
            _ => return Err(lines.malformed("the third line should be ASCII or BINARY")),
        };
        let mut header = Self {
            geometry: Geometry::IDENTITY,
            is_text,
            arrays: Vec::new(),
            places: Vec::new(),
            warnings: Vec::new(),
        };
        let mut attributes = None;
        while let Some(line) = lines.next()? {
            let words: Vec<&str> = line.split_whitespace().collect();
            match header.take_line(&mut lines, &words, &mut attributes) {
                Ok(()) => {}
                // The arrays before it are sound.
                Err(error) if !header.arrays.is_empty() => {
                    header.warnings.push(format!("the file was read up to a broken part: {error}"));
                    break;
                }
                Err(error) => return Err(error),
            }
        }
        if header.geometry.extent == [[0, 0]; 3] && header.arrays.is_empty() {
            return Err(lines.malformed("the file has no DIMENSIONS"));
        }
        Ok(header)
    }

    fn take_line(
        &mut self,
        lines: &mut Lines<'_>,
        words: &[&str],
        attributes: &mut Option<Attributes>,
    ) -> Result<(), IoError> {
        let [keyword, words @ ..] = words else { return Ok(()) };
        match keyword.to_uppercase().as_str() {
            "DATASET" => match words.first().map(|word| word.to_uppercase()).as_deref() {
                Some("STRUCTURED_POINTS") => Ok(()),
                other => {
                    let other: String = other.unwrap_or_default().chars().take(40).collect();
                    let other = printable(&other);
                    let remedy = match other.as_str() {
                        "POLYDATA" => "ParaView saves it as a mesh, .ply",
                        _ => "save it as STRUCTURED_POINTS",
                    };
                    let what = format!("{other} is no image: {remedy}");
                    Err(IoError::unsupported(lines.input.path, what))
                }
            },
            "DIMENSIONS" => {
                let dims: [i64; 3] = lines.numbers(keyword, words)?;
                self.geometry.extent = dims.map(|n| [0, n.saturating_sub(1)]);
                Ok(())
            }
            "ORIGIN" => lines.numbers(keyword, words).map(|origin| self.geometry.origin = origin),
            "SPACING" | "ASPECT_RATIO" => {
                lines.numbers(keyword, words).map(|spacing| self.geometry.spacing = spacing)
            }
            "POINT_DATA" | "CELL_DATA" => {
                let [n_tuples] = lines.numbers(keyword, words)?;
                let is_of_cells = keyword.eq_ignore_ascii_case("CELL_DATA");
                self.check_count(lines, n_tuples, is_of_cells)?;
                *attributes = Some(Attributes { is_of_cells, are_colors: false, n_tuples });
                Ok(())
            }
            "METADATA" => lines.pass_over_metadata(),
            "LOOKUP_TABLE" => self.pass_over_table(lines, words),
            "FIELD" => self.take_field(lines, words, *attributes),
            other => self.take_attribute(lines, other, words, *attributes),
        }
    }

    fn check_count(
        &self,
        lines: &Lines<'_>,
        n_tuples: u64,
        is_of_cells: bool,
    ) -> Result<(), IoError> {
        let dims = self.geometry.dims(is_of_cells).unwrap_or([0; 3]);
        let expected = dims.into_iter().fold(1_u64, |n, d| n.saturating_mul(d as u64));
        if n_tuples == expected {
            return Ok(());
        }
        let [x, y, z] = dims;
        let what = format!("there are data of {n_tuples} points where {x} x {y} x {z} are needed");
        Err(lines.malformed(&what))
    }

    /// One line of an attribute: `SCALARS name type 1`.
    fn take_attribute(
        &mut self,
        lines: &mut Lines<'_>,
        keyword: &str,
        words: &[&str],
        attributes: Option<Attributes>,
    ) -> Result<(), IoError> {
        let count = |word: Option<&&str>, default| {
            word.map_or(Some(default), |word| word.parse().ok()).filter(|n| 0 < *n)
        };
        let (type_name, n_components) = match keyword {
            "SCALARS" => (words.get(1).copied(), count(words.get(2), 1)),
            // In text they are shares of the largest byte.
            "COLOR_SCALARS" => (Some("unsigned_char"), count(words.get(1), 1)),
            "VECTORS" | "NORMALS" => (words.get(1).copied(), Some(3)),
            "TENSORS" => (words.get(1).copied(), Some(9)),
            "TENSORS6" => (words.get(1).copied(), Some(6)),
            "TEXTURE_COORDINATES" => (words.get(2).copied(), count(words.get(1), 1)),
            _ => {
                let shown: String = keyword.chars().take(40).collect();
                return Err(lines.malformed(&format!("{shown:?} is no keyword of an image")));
            }
        };
        let (Some(name), Some(type_name), Some(n_components)) =
            (words.first(), type_name, n_components)
        else {
            return Err(lines.malformed(&format!("{keyword} needs a name and a type")));
        };
        let Some(attributes) = attributes else {
            return Err(lines.malformed(&format!("{keyword} comes before POINT_DATA")));
        };
        if keyword == "SCALARS" {
            lines.pass_over_table_name()?;
        }
        let attributes = Attributes { are_colors: keyword == "COLOR_SCALARS", ..attributes };
        self.push(lines, name, type_name, n_components, attributes)
    }

    /// `FIELD name n`, and for each array `name components tuples type`.
    fn take_field(
        &mut self,
        lines: &mut Lines<'_>,
        words: &[&str],
        attributes: Option<Attributes>,
    ) -> Result<(), IoError> {
        let [n_arrays] = lines.numbers::<u64, 1>("FIELD", words.get(1..).unwrap_or_default())?;
        for _ in 0..n_arrays {
            let Some(mut line) = lines.next()? else {
                return Err(lines.malformed("the file breaks off in a FIELD"));
            };
            if line.eq_ignore_ascii_case("METADATA") {
                lines.pass_over_metadata()?;
                line = lines.next()?.unwrap_or_default();
            }
            let words: Vec<&str> = line.split_whitespace().collect();
            let &[name, n_components, n_tuples, type_name] = words.as_slice() else {
                return Err(
                    lines.malformed("an array of a FIELD needs a name, two sizes and a type")
                );
            };
            let (Ok(n_components), Ok(n_tuples)) = (n_components.parse(), n_tuples.parse::<u64>())
            else {
                return Err(lines.malformed("an array of a FIELD has sizes that are no numbers"));
            };
            match attributes {
                Some(attributes) if attributes.n_tuples == n_tuples && 0 < n_components => {
                    self.push(lines, name, type_name, n_components, attributes)?;
                }
                // What is known of the whole file.
                _ => {
                    let n_items = (n_components as u64).saturating_mul(n_tuples);
                    self.pass_over_numbers(lines, type_name, n_items)?;
                }
            }
        }
        Ok(())
    }

    /// An array whose numbers come next; they are passed over.
    fn push(
        &mut self,
        lines: &mut Lines<'_>,
        name: &str,
        type_name: &str,
        n_components: usize,
        attributes: Attributes,
    ) -> Result<(), IoError> {
        if MAX_ARRAYS < self.arrays.len() {
            return Err(lines.malformed("the image has too many arrays"));
        }
        self.places.push(lines.at()?);
        self.arrays.push(ArrayDesc {
            name: with_escapes(name),
            stored: legacy_type(type_name),
            type_name: type_name.chars().take(40).collect(),
            n_components,
            is_color: attributes.are_colors,
            is_of_cells: attributes.is_of_cells,
        });
        let n_items = (n_components as u64).saturating_mul(attributes.n_tuples);
        self.pass_over_numbers(lines, type_name, n_items)
    }

    fn pass_over_numbers(
        &self,
        lines: &mut Lines<'_>,
        type_name: &str,
        n_items: u64,
    ) -> Result<(), IoError> {
        if self.is_text {
            return lines.pass_over_tokens(n_items);
        }
        let n_bytes = match (legacy_type(type_name), type_name) {
            (Some(stored), _) => n_items.saturating_mul(stored.size_bytes() as u64),
            (None, "bit") => n_items.div_ceil(8),
            (None, _) => {
                let shown: String = type_name.chars().take(40).collect();
                return Err(lines.malformed(&format!("the type {shown:?} is unknown")));
            }
        };
        lines.pass_over_bytes(n_bytes)
    }

    /// `LOOKUP_TABLE name size`, and as many colours.
    fn pass_over_table(&self, lines: &mut Lines<'_>, words: &[&str]) -> Result<(), IoError> {
        let [n_colors] =
            lines.numbers::<u64, 1>("LOOKUP_TABLE", words.get(1..).unwrap_or_default())?;
        let n_items = n_colors.saturating_mul(4);
        if self.is_text { lines.pass_over_tokens(n_items) } else { lines.pass_over_bytes(n_items) }
    }
}

/// Names have `%20` for a blank, and the like.
fn with_escapes(name: &str) -> String {
    let bytes = name.as_bytes();
    let mut plain = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let digits = name.get(at + 1..at + 3).filter(|_| bytes[at] == b'%');
        match digits.and_then(|digits| u8::from_str_radix(digits, 16).ok()) {
            Some(byte) => {
                plain.push(byte);
                at += 3;
            }
            None => {
                plain.push(bytes[at]);
                at += 1;
            }
        }
    }
    printable(&String::from_utf8_lossy(&plain))
}
