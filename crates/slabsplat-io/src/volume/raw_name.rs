//! Raw files whose names say what they hold: `engine_256x256x128_uint8.raw`, `tooth-103x94x161-u16be.raw`.

use std::path::{Path, PathBuf};

use slabsplat_core::SampleType;

use super::formats::{Input, Reader, VolumeListing};
use super::{Endian, LoadedVolume, RawDesc, VolumeChoices, VolumeFormat, names, read_raw_from};
use crate::IoError;
use crate::store::Store;

/// Raw files that need no description.
pub(super) struct RawName;

/// What a name says.
#[derive(Debug, PartialEq)]
struct Said {
    dims: [usize; 3],
    sample_type: SampleType,
    endian: Option<Endian>,
}

impl Reader for RawName {
    fn listed(&self) -> &'static str {
        "raw with a name such as a_256x256x128_uint8.raw"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["raw", "bin", "dat", "vol"]
    }

    fn is_begun_by(&self, _start: &[u8]) -> bool {
        false
    }

    fn is_named(&self, _store: Store<'_>, path: &Path) -> bool {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        extension.is_some_and(|e| self.extensions().contains(&e.as_str())) && said(path).is_some()
    }

    fn header_of(&self, _store: Store<'_>, path: &Path) -> Result<PathBuf, IoError> {
        Ok(path.to_owned())
    }

    fn reads_boxes(&self) -> bool {
        true
    }

    fn read(&self, input: &Input<'_>) -> Result<LoadedVolume, IoError> {
        let said = said_by(input)?;
        let Said { dims, sample_type, endian } = said;
        let desc = RawDesc {
            dims,
            sample_type,
            endian: endian.unwrap_or(Endian::Little),
            spacing: [1.0; 3],
            header_bytes: 0,
        };
        let mut loaded = read_raw_from(input.store, input.path, &desc, input.options)?;
        let [x, y, z] = dims;
        let is_guess = endian.is_none() && 1 < sample_type.size_bytes();
        let order = if is_guess { ", little-endian (which it does not say)" } else { "" };
        loaded.warnings.push(format!(
            "taken from the file's name: {x} x {y} x {z} voxels of {}{order}; 1 x 1 x 1 was assumed for \
             their size",
            sample_type.name()
        ));
        Ok(loaded)
    }

    fn list(&self, input: &Input<'_>) -> Result<VolumeListing, IoError> {
        let Said { dims, sample_type, .. } = said_by(input)?;
        let (format, choices) = (VolumeFormat::Raw, VolumeChoices::default());
        Ok(VolumeListing { format, dims, sample_type, choices })
    }
}

fn said_by(input: &Input<'_>) -> Result<Said, IoError> {
    said(input.path).ok_or_else(|| IoError::UnknownFormat {
        path: input.path.to_owned(),
        known: RawName.listed().to_owned(),
    })
}

/// What the words of a name say, if they say both sizes and type.
fn said(path: &Path) -> Option<Said> {
    let stem = path.file_stem()?.to_str()?.to_lowercase();
    let words: Vec<&str> = stem.split(['_', '-', '.', ' ', ',', '(', ')', '[', ']']).collect();
    let dims = words.iter().find_map(|word| dims(word))?;
    let (at, (sample_type, endian)) =
        words.iter().enumerate().find_map(|(at, word)| Some((at, type_and_order(word)?)))?;
    let endian = endian.or_else(|| order(words.get(at + 1)?));
    Some(Said { dims, sample_type, endian })
}

/// `256x256x128`.
fn dims(word: &str) -> Option<[usize; 3]> {
    let sizes = word.split(['x', '×']).map(|size| size.parse().ok().filter(|n| 0 < *n));
    sizes.collect::<Option<Vec<usize>>>()?.try_into().ok()
}

/// `uint8`, `u16be`, `float32le`, `int16`.
fn type_and_order(word: &str) -> Option<(SampleType, Option<Endian>)> {
    let endings = [("be", Some(Endian::Big)), ("le", Some(Endian::Little)), ("", None)];
    endings.into_iter().find_map(|(ending, endian)| {
        let name = word.strip_suffix(ending)?;
        let long = match name {
            "u8" | "8bit" | "8u" => "uint8",
            "i8" | "s8" | "8s" => "int8",
            "u16" | "16u" => "uint16",
            "i16" | "s16" | "16s" => "int16",
            "u32" | "32u" => "uint32",
            "i32" | "s32" | "32s" => "int32",
            "f32" | "32f" => "float32",
            "f64" | "64f" => "float64",
            other => other,
        };
        Some((names::sample_type(long)?, endian))
    })
}

fn order(word: &str) -> Option<Endian> {
    match word {
        "be" | "big" | "bigendian" | "msb" => Some(Endian::Big),
        "le" | "little" | "littleendian" | "lsb" => Some(Endian::Little),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::read_from_both as read;
    use slabsplat_core::Samples;

    #[test]
    fn raw_names_are_read() {
        let check = |name: &str,
                     dims: [usize; 3],
                     sample_type: SampleType,
                     endian: Option<Endian>| {
            assert_eq!(said(Path::new(name)), Some(Said { dims, sample_type, endian }), "{name}");
        };
        let engine = [256, 256, 128];
        check("in/engine_256x256x128_uint8.raw", engine, SampleType::U8, None);
        check("tooth-103x94x161-uint16be.raw", [103, 94, 161], SampleType::U16, Some(Endian::Big));
        check("A_256X256X128_int16_LE.raw", engine, SampleType::I16, Some(Endian::Little));
        check("f32.256x256x128.big.raw", engine, SampleType::F32, None);
        check("a(256x256x128)_f64_big.dat", engine, SampleType::F64, Some(Endian::Big));
        check("u8 256x256x128.bin", engine, SampleType::U8, None);
        for name in ["256x256x128.raw", "a_uint8.raw", "256x256_uint8.raw", "0x2x2_u8.raw", "x.raw"]
        {
            assert_eq!(said(Path::new(name)), None, "{name}");
        }
    }

    #[test]
    fn raw_names_say_what_a_file_holds() {
        let loaded = read(&[("a_2x1x2_u16be.raw", &[0, 1, 0, 2, 0, 3, 1, 0])]).unwrap();
        assert_eq!(loaded.volume.samples(), &Samples::U16(vec![1, 2, 3, 256]));
        assert!(
            loaded.warnings[0].contains("2 x 1 x 2 voxels of uint16;"),
            "{:?}",
            loaded.warnings
        );
        let guessed = read(&[("a_2x1x1_i16.raw", &[1, 0, 2, 0])]).unwrap();
        assert!(guessed.warnings[0].contains("little-endian"), "{:?}", guessed.warnings);
        let error = read(&[("a_2x1x2_u8.raw", &[0; 8])]).unwrap_err();
        assert!(
            error.contains("needs 4 bytes of data, has 8: what would fit is type uint16"),
            "{error}"
        );
        // A description says more than a name.
        let json = r#"{"dims": [4, 1, 2], "type": "uint8"}"#;
        let files: [(&str, &[u8]); 2] =
            [("a_2x1x2_u8.raw", &[0; 8]), ("a_2x1x2_u8.json", json.as_bytes())];
        assert_eq!(read(&files).unwrap().volume.grid().dims(), [4, 1, 2]);
    }
}
