//! Images in VTK's XML: tags are read one by one, and the data only of the array that is wanted.

use std::io::{BufRead, BufReader};

use super::super::Endian;
use super::super::formats::{Input, VolumeListing};
use super::super::placed::Source;
use super::super::stream::MAX_GZIP_RATIO;
use super::base64::Base64;
use super::blocks::{Blocks, Compressor, Words};
use super::image::{self, ArrayDesc, Extent, Geometry, stored_type};
use super::tags::{Tag, Tags};
use super::text::NumbersInText;
use super::{Filling, LoadedVolume, n_bytes};
use crate::IoError;
use crate::printable::printable;
use crate::store::StoredFile;

/// What the tags of a file say.
struct Header {
    geometry: Geometry,
    words: Words,
    /// How blocks are packed, by VTK's name.
    compressor: Option<String>,
    pieces: Vec<Piece>,
    /// The array that the file calls its scalars.
    active: Option<String>,
    appended: Option<Appended>,
}

/// A part of an image.
#[derive(Default)]
struct Piece {
    extent: Extent,
    arrays: Vec<Array>,
}

struct Array {
    desc: ArrayDesc,
    format: Format,
    /// Where its text begins.
    text_at: u64,
}

/// Where an array's data are.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Format {
    Text,
    Base64,
    /// So far into the appended data.
    Appended(u64),
    Unknown,
}

/// Data at the end of the file.
#[derive(Clone, Copy)]
struct Appended {
    /// After the underscore.
    at: u64,
    is_raw: bool,
}

/// Where the tags are that the scan is in.
#[derive(Default)]
struct Place {
    is_of_cells: bool,
    in_array: bool,
}

/// VTK writes one piece, or one a process.
const MAX_PIECES: usize = 1 << 16;

/// Arrays of all pieces together.
const MAX_ARRAYS: usize = 1 << 20;

pub(super) fn is_begun_by(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(start);
    let text = text.trim_start_matches('\u{feff}').trim_start();
    (text.starts_with("<?xml") || text.starts_with("<VTKFile")) && text.contains("<VTKFile")
}

pub(super) fn list(input: &Input<'_>) -> Result<VolumeListing, IoError> {
    let header = Header::read(input)?;
    let descs = header.descs(input)?;
    let chosen = image::choose(input, &descs, header.active.as_deref())?;
    image::listing(input, &header.geometry, &descs[chosen.array_idx].clone(), chosen)
}

pub(super) fn read(input: &Input<'_>) -> Result<LoadedVolume, IoError> {
    let header = Header::read(input)?;
    let descs = header.descs(input)?;
    let chosen = image::choose(input, &descs, header.active.as_deref())?;
    let desc = &descs[chosen.array_idx];
    let mut warnings = Vec::new();
    header.check_backed(input, desc)?;
    let is_text = header.parts(desc).any(|(_, array)| array.format == Format::Text);
    let endian = if is_text { Endian::NATIVE } else { header.words.endian };
    let mut filling = Filling::new(input, &header.geometry, desc, &chosen, endian)?;
    let mut n_placed = 0_u64;
    for (piece, array) in header.parts(desc) {
        let (dims, first) = header.dims_of(input, piece, desc)?;
        header.read_array(
            input,
            array,
            n_bytes(dims, desc.n_components, filling.stored),
            |mut source| filling.place(&mut source, dims, first),
        )?;
        n_placed = n_placed.saturating_add(n_bytes(dims, 1, filling.stored));
    }
    if n_placed < n_bytes(filling.dims, 1, filling.stored) {
        warnings
            .push("the pieces in the file are not all of the image: what lacks is 0".to_owned());
    }
    let is_of_cells = desc.is_of_cells;
    filling.finish(&header.geometry, chosen, is_of_cells, warnings)
}

impl Header {
    fn read(input: &Input<'_>) -> Result<Self, IoError> {
        let (reader, _) = input.open_at(0)?;
        let mut tags = Tags::new(reader);
        let malformed = |what: String| IoError::malformed(input.path, what);
        let mut header = Self {
            geometry: Geometry::IDENTITY,
            words: Words { n_bytes: 4, endian: Endian::Little },
            compressor: None,
            pieces: Vec::new(),
            active: None,
            appended: None,
        };
        let mut place = Place::default();
        while let Some(tag) = tags.next().map_err(IoError::read(input.path))?.map_err(malformed)? {
            if tag.name == "AppendedData" {
                header.appended = Some(appended(input, &tag)?);
                break;
            }
            header.take(&tag, &mut place).map_err(|what| IoError::unsupported(input.path, what))?;
        }
        Ok(header)
    }

    fn take(&mut self, tag: &Tag, place: &mut Place) -> Result<(), String> {
        match tag.name.as_str() {
            "VTKFile" => self.take_file(tag)?,
            "ImageData" => self.take_image(tag)?,
            "Piece" => {
                let extent = tag.get("Extent").map_or(Some(self.geometry.extent), extent);
                let extent = extent.ok_or("a piece has no extent of six numbers")?;
                self.pieces.push(Piece { extent, arrays: Vec::new() });
                if MAX_PIECES < self.pieces.len() {
                    return Err("the image has too many pieces".to_owned());
                }
            }
            "PointData" | "CellData" => {
                place.is_of_cells = tag.name == "CellData";
                let scalars = tag.get("Scalars").filter(|name| !name.is_empty());
                self.active = self.active.take().or_else(|| scalars.map(str::to_owned));
            }
            "DataArray" => {
                let array = Array::of(tag, place.is_of_cells)?;
                place.in_array = true;
                let n_arrays = self.pieces.iter().map(|piece| piece.arrays.len()).sum::<usize>();
                if let Some(piece) = self.pieces.last_mut().filter(|_| n_arrays < MAX_ARRAYS) {
                    piece.arrays.push(array);
                }
            }
            "/DataArray" => place.in_array = false,
            // What is known of an array may come before its numbers.
            _ if place.in_array && tag.follows_blanks => {
                let array = self.pieces.last_mut().and_then(|piece| piece.arrays.last_mut());
                if let Some(array) = array {
                    array.text_at = tag.end;
                }
            }
            _ => place.in_array = false,
        }
        Ok(())
    }

    fn take_file(&mut self, tag: &Tag) -> Result<(), String> {
        match tag.get("type") {
            Some("ImageData") => {}
            Some("PImageData") => {
                return Err(
                    "the pieces of the image are in files of their own: save it as .vti".to_owned()
                );
            }
            other => {
                let other =
                    printable(&other.unwrap_or("nothing").chars().take(40).collect::<String>());
                let remedy = match other.as_str() {
                    "PolyData" => "ParaView saves it as a mesh, .ply",
                    _ => "resample it to ImageData",
                };
                return Err(format!("VTK's {other} is no image: {remedy}"));
            }
        }
        if tag.get("byte_order") == Some("BigEndian") {
            self.words.endian = Endian::Big;
        }
        self.words.n_bytes = match tag.get("header_type") {
            None | Some("UInt32") => 4,
            Some("UInt64") => 8,
            Some(other) => return Err(format!("a header_type of {other:?} is unknown")),
        };
        self.compressor = tag.get("compressor").filter(|name| !name.is_empty()).map(str::to_owned);
        Ok(())
    }

    fn take_image(&mut self, tag: &Tag) -> Result<(), String> {
        let whole = tag.get("WholeExtent").and_then(extent);
        self.geometry.extent = whole.ok_or("the image has no WholeExtent of six numbers")?;
        for (name, numbers) in [
            ("Origin", &mut self.geometry.origin[..]),
            ("Spacing", &mut self.geometry.spacing),
            ("Direction", &mut self.geometry.direction),
        ] {
            if let Some(text) = tag.get(name) {
                let parsed: Option<Vec<f64>> =
                    text.split_whitespace().map(|word| word.parse().ok()).collect();
                let parsed = parsed.filter(|parsed| parsed.len() == numbers.len());
                let what = || format!("the image's {name} should be {} numbers", numbers.len());
                numbers.copy_from_slice(&parsed.ok_or_else(what)?);
            }
        }
        Ok(())
    }

    /// The arrays of the first piece, which all pieces should have.
    fn descs(&self, input: &Input<'_>) -> Result<Vec<ArrayDesc>, IoError> {
        let piece = self
            .pieces
            .first()
            .ok_or_else(|| IoError::malformed(input.path, "the file has no piece of an image"))?;
        Ok(piece.arrays.iter().map(|array| array.desc.clone()).collect())
    }

    /// The pieces that have the array, and theirs of it.
    fn parts<'h>(&'h self, desc: &'h ArrayDesc) -> impl Iterator<Item = (&'h Piece, &'h Array)> {
        self.pieces.iter().filter_map(move |piece| {
            let array = piece.arrays.iter().find(|array| array.desc == *desc)?;
            Some((piece, array))
        })
    }

    /// Samples of a piece along each axis, and where in the image its first one is.
    fn dims_of(
        &self,
        input: &Input<'_>,
        piece: &Piece,
        desc: &ArrayDesc,
    ) -> Result<([usize; 3], [usize; 3]), IoError> {
        let whole = &self.geometry.extent;
        let is_within = piece.extent.iter().zip(whole).all(|([a, b], [c, d])| c <= a && b <= d);
        let dims = image::dims(&piece.extent, desc.is_of_cells).filter(|_| is_within);
        let what = || format!("a piece of {:?} is not within {whole:?}", piece.extent);
        let dims = dims.ok_or_else(|| IoError::malformed(input.path, what()))?;
        let whole_dims = self.geometry.dims(desc.is_of_cells).unwrap_or([0; 3]);
        let first = [0, 1, 2].map(|axis| (piece.extent[axis][0] - whole[axis][0]) as usize);
        if (0..3).any(|axis| whole_dims[axis] < first[axis] + dims[axis]) {
            return Err(IoError::malformed(input.path, what()));
        }
        Ok((dims, first))
    }

    /// That the file is long enough for what the image takes in memory.
    fn check_backed(&self, input: &Input<'_>, desc: &ArrayDesc) -> Result<(), IoError> {
        let dims = self.geometry.dims(desc.is_of_cells).unwrap_or([0; 3]);
        let (_, n_in_file) = input.open_at(0)?;
        let found = match self.compressor {
            Some(_) => n_in_file.saturating_mul(MAX_GZIP_RATIO),
            None => n_in_file,
        };
        // A number in text has a digit and a blank, whatever it takes in memory.
        let is_text = self.parts(desc).any(|(_, array)| array.format == Format::Text);
        let needed = match desc.stored {
            Some(stored) if !is_text => n_bytes(dims, desc.n_components, stored),
            _ => dims.into_iter().fold(2, |n: u64, d| n.saturating_mul(d as u64)).saturating_sub(1),
        };
        if found < needed { Err(input.too_short(needed, found)) } else { Ok(()) }
    }

    fn read_array(
        &self,
        input: &Input<'_>,
        array: &Array,
        needed: u64,
        mut place: impl FnMut(&mut dyn Source) -> Result<(), IoError>,
    ) -> Result<(), IoError> {
        let malformed = |what: &str| IoError::malformed(input.path, what);
        match (array.format, self.appended) {
            (Format::Text, _) => {
                let (reader, _) = input.open_at(array.text_at)?;
                let stored = array.desc.stored.ok_or_else(|| malformed("an array has no type"))?;
                place(&mut NumbersInText::new(reader, stored))
            }
            (Format::Base64, _) => {
                let (reader, n_left) = input.open_at(array.text_at)?;
                self.read_packed(input, Base64::new(reader), n_left, needed, place)
            }
            (Format::Appended(offset), Some(appended)) => {
                let at = appended.at.saturating_add(offset);
                let (reader, n_left) = input.open_at(at)?;
                if appended.is_raw {
                    self.read_packed(input, reader, n_left, needed, place)
                } else {
                    self.read_packed(input, Base64::new(reader), n_left, needed, place)
                }
            }
            (Format::Appended(_), None) => Err(malformed("the file has no appended data")),
            (Format::Unknown, _) => {
                Err(malformed("an array has a format other than ascii, binary and appended"))
            }
        }
    }

    fn read_packed(
        &self,
        input: &Input<'_>,
        mut source: impl Source,
        n_left: u64,
        needed: u64,
        mut place: impl FnMut(&mut dyn Source) -> Result<(), IoError>,
    ) -> Result<(), IoError> {
        let compressor = match self.compressor.as_deref() {
            None => {
                let n_bytes = self.words.read(&mut source).map_err(|e| input.failed(e))?;
                let found = n_bytes.min(n_left);
                return if found < needed {
                    Err(input.too_short(needed, found))
                } else {
                    place(&mut source)
                };
            }
            Some("vtkZLibDataCompressor") => Compressor::Zlib,
            Some("vtkLZ4DataCompressor") => Compressor::Lz4,
            Some(other) => {
                let other = printable(&other.chars().take(40).collect::<String>());
                let what =
                    format!("data packed by {other} cannot be read: save them with ZLib or LZ4");
                return Err(IoError::unsupported(input.path, what));
            }
        };
        let blocks = Blocks::open(source, compressor, self.words, n_left);
        place(&mut blocks.map_err(|error| input.failed(error))?)
    }
}

impl Array {
    fn of(tag: &Tag, is_of_cells: bool) -> Result<Self, String> {
        let number = |name: &str, default: u64| match tag.get(name) {
            None | Some("") => Ok(default),
            Some(text) => text.trim().parse::<u64>().map_err(|_| {
                let text: String = text.chars().take(40).collect();
                format!("an array's {name} is {text:?}, no number")
            }),
        };
        let type_name: String = tag.get("type").unwrap_or_default().chars().take(40).collect();
        let format = match tag.get("format") {
            None | Some("ascii") => Format::Text,
            Some("binary") => Format::Base64,
            Some("appended") => Format::Appended(number("offset", 0)?),
            Some(_) => Format::Unknown,
        };
        let desc = ArrayDesc {
            name: printable(tag.get("Name").unwrap_or("unnamed")),
            stored: stored_type(&type_name),
            type_name,
            n_components: usize::try_from(number("NumberOfComponents", 1)?.max(1))
                .map_err(|_| "an array has too many components".to_owned())?,
            is_color: false,
            is_of_cells,
        };
        Ok(Self { desc, format, text_at: tag.end })
    }
}

/// Six numbers.
fn extent(text: &str) -> Option<Extent> {
    let numbers: Option<Vec<i64>> = text.split_whitespace().map(|word| word.parse().ok()).collect();
    let numbers: [i64; 6] = numbers?.try_into().ok()?;
    let [a, b, c, d, e, f] = numbers;
    Some([[a, b], [c, d], [e, f]])
}

/// The data at the end begin after an underscore.
fn appended(input: &Input<'_>, tag: &Tag) -> Result<Appended, IoError> {
    let (mut reader, _): (BufReader<StoredFile<'_>>, u64) = input.open_at(tag.end)?;
    let bytes = reader.fill_buf().map_err(IoError::read(input.path))?;
    let at = bytes.iter().position(|&byte| byte == b'_');
    let at = at.filter(|&at| bytes[..at].trim_ascii().is_empty());
    let what = "the appended data do not begin with an underscore";
    let at = at.ok_or_else(|| IoError::malformed(input.path, what))?;
    let is_raw = tag.get("encoding") == Some("raw");
    Ok(Appended { at: tag.end + at as u64 + 1, is_raw })
}
