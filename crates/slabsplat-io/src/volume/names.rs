//! The many names of a few sample types, as NRRD, MetaImage and descriptions of raw files spell them.

use slabsplat_core::SampleType;

/// Every spelling of a type that NRRD allows, in lower case.
const SPELLINGS: &[(SampleType, &[&str])] = &[
    (SampleType::U8, &["uchar", "unsigned char", "uint8", "uint8_t"]),
    (SampleType::I8, &["signed char", "int8", "int8_t"]),
    (SampleType::U16, &["ushort", "unsigned short", "unsigned short int", "uint16", "uint16_t"]),
    (
        SampleType::I16,
        &["short", "short int", "signed short", "signed short int", "int16", "int16_t"],
    ),
    (SampleType::U32, &["uint", "unsigned int", "uint32", "uint32_t"]),
    (SampleType::I32, &["int", "signed int", "int32", "int32_t"]),
    (SampleType::F32, &["float", "float32"]),
    (SampleType::F64, &["double", "float64"]),
];

/// The type that `name` means, in any case and with any blanks between its words.
pub(super) fn sample_type(name: &str) -> Option<SampleType> {
    let name = name.split_whitespace().collect::<Vec<_>>().join(" ").to_lowercase();
    SPELLINGS.iter().find(|(_, names)| names.contains(&name.as_str())).map(|(t, _)| *t)
}

/// What to say where a type has no such name.
pub(super) fn unknown_type(name: &str) -> String {
    let known = SampleType::NAMES.join(", ");
    format!("samples of type {name:?} cannot be read: convert them to one of {known}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sample_type_names_of_nrrd() {
        assert_eq!(sample_type("Unsigned  Short int"), Some(SampleType::U16));
        for &t in SampleType::ALL {
            assert_eq!(sample_type(t.name()), Some(t));
        }
        for other in ["int64", "block", "char", ""] {
            assert_eq!(sample_type(other), None);
        }
    }
}
