//! The many names of a few sample types, as NRRD, MetaImage and descriptions of raw files spell them.

use slabsplat_core::SampleType;

use super::stored::StoredType;

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

/// The same for integers of 64 bits.
const WIDE_SPELLINGS: &[(StoredType, &[&str])] = &[
    (
        StoredType::I64,
        &[
            "longlong",
            "long long",
            "long long int",
            "signed long long",
            "signed long long int",
            "int64",
            "int64_t",
        ],
    ),
    (
        StoredType::U64,
        &["ulonglong", "unsigned long long", "unsigned long long int", "uint64", "uint64_t"],
    ),
];

/// The type that `name` means, in any case and with any blanks between its words.
pub(super) fn sample_type(name: &str) -> Option<SampleType> {
    find(SPELLINGS, name)
}

/// The same where integers may have 64 bits, too.
pub(super) fn stored_type(name: &str) -> Option<StoredType> {
    sample_type(name).map(StoredType::Sample).or_else(|| find(WIDE_SPELLINGS, name))
}

fn find<T: Copy>(spellings: &[(T, &[&str])], name: &str) -> Option<T> {
    let name = name.split_whitespace().collect::<Vec<_>>().join(" ").to_lowercase();
    spellings.iter().find(|(_, names)| names.contains(&name.as_str())).map(|(t, _)| *t)
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
        assert_eq!(stored_type("short"), Some(StoredType::Sample(SampleType::I16)));
        assert_eq!(stored_type("unsigned  long long"), Some(StoredType::U64));
        assert_eq!(stored_type("int64_t"), Some(StoredType::I64));
        assert_eq!(stored_type("block"), None);
        for other in ["int64", "block", "char", ""] {
            assert_eq!(sample_type(other), None);
        }
    }
}
