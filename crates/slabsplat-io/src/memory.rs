//! Whether what a scene shows has room in memory, before any of it is read.
//!
//! How much is free is what the system says (`sysinfo`), and no more than a container's limit leaves. What a
//! frame needs beside the volumes depends on what is visible, and is not counted.

use std::fmt;
use std::path::Path;

use sysinfo::{CGroupLimits, MemoryRefreshKind, RefreshKind, System};

use crate::builtin::builtin_bytes;
use crate::printable::shown_path;
use crate::{IoError, LayerFile, RawDesc, VolumeOptions, VolumeSource, list_volume};

/// Memory that something takes.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct MemoryNeed {
    /// What takes it, for people.
    pub what: String,
    /// How much that is.
    pub bytes: u64,
}

/// What [`IoError::OutOfMemory`] lists.
#[derive(Clone, Debug, PartialEq, Eq)]
#[expect(clippy::exhaustive_structs, reason = "a list is a list")]
pub struct MemoryNeeds(pub Vec<MemoryNeed>);

impl MemoryNeed {
    /// What volumes and labels of layers take, on the word of their headers. What cannot be read takes
    /// nothing: that is told when it is.
    pub fn of_layers(layers: &[LayerFile]) -> Vec<Self> {
        let with_index = layers.iter().enumerate();
        let is_first = |(idx, layer): &(usize, &LayerFile)| {
            !layers[..*idx].iter().any(|before| layer.shares_volume(before))
        };
        let volumes = with_index.filter(is_first).filter_map(|(_, layer)| layer.need_of_volume());
        volumes.chain(layers.iter().filter_map(LayerFile::need_of_labels)).collect()
    }
}

impl LayerFile {
    fn need_of_volume(&self) -> Option<MemoryNeed> {
        match (&self.volume, &self.raw) {
            (VolumeSource::Builtin { name, size }, _) => {
                Some(MemoryNeed { what: name.clone(), bytes: builtin_bytes(name, *size)? })
            }
            (VolumeSource::File(path), Some(raw)) => MemoryNeed::of_raw(path, raw),
            (VolumeSource::File(path), None) => MemoryNeed::of_file(path, &self.options),
        }
    }

    fn need_of_labels(&self) -> Option<MemoryNeed> {
        let labels = self.labels.as_ref()?;
        MemoryNeed::of_file(&labels.path, &VolumeOptions::default())
    }
}

impl MemoryNeed {
    fn of_file(path: &Path, options: &VolumeOptions) -> Option<Self> {
        let bytes = list_volume(path, options).ok()?.bytes();
        Some(Self { what: shown_path(path), bytes })
    }

    /// Of a file that is as long as its description says; no other is read.
    fn of_raw(path: &Path, raw: &RawDesc) -> Option<Self> {
        let bytes = std::fs::metadata(path).ok()?.len().checked_sub(raw.header_bytes)?;
        (bytes == raw.bytes()).then(|| Self { what: shown_path(path), bytes })
    }
}

/// That all of it has room at once.
///
/// # Errors
/// If it has not, which says how much each needs.
pub fn check_memory(needs: Vec<MemoryNeed>) -> Result<(), IoError> {
    match free_bytes() {
        Some(free_bytes) => check_within(needs, free_bytes),
        None => Ok(()),
    }
}

fn check_within(needs: Vec<MemoryNeed>, free_bytes: u64) -> Result<(), IoError> {
    let needs = MemoryNeeds(needs);
    if needs.total_bytes() <= free_bytes {
        return Ok(());
    }
    Err(IoError::OutOfMemory { needs, free_bytes })
}

/// `None` where the system does not tell.
pub(crate) fn free_bytes() -> Option<u64> {
    let memory =
        RefreshKind::nothing().with_memory(MemoryRefreshKind::nothing().with_ram().with_swap());
    let system = System::new_with_specifics(memory);
    let free = system.available_memory().saturating_add(system.free_swap());
    let of_container = system.cgroup_limits().map(|limits| room_of(&limits));
    Some(free.min(of_container.unwrap_or(u64::MAX))).filter(|&free| 0 < free)
}

/// What a container's programs do not hold. What its system retains of files that were read is theirs for the
/// asking, though it counts as used.
fn room_of(limits: &CGroupLimits) -> u64 {
    limits.total_memory.saturating_sub(limits.rss)
}

impl MemoryNeeds {
    pub(crate) fn total_bytes(&self) -> u64 {
        self.0.iter().fold(0, |sum, need| sum.saturating_add(need.bytes))
    }
}

impl fmt::Display for MemoryNeeds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (idx, MemoryNeed { what, bytes }) in self.0.iter().enumerate() {
            let separator = if idx == 0 { "" } else { ", " };
            write!(f, "{separator}{what} {}", in_units(*bytes))?;
        }
        Ok(())
    }
}

/// Bytes as people read them.
pub(crate) fn in_units(bytes: u64) -> String {
    const UNITS: [&str; 5] = ["bytes", "KiB", "MiB", "GiB", "TiB"];
    let mut number = bytes as f64;
    let mut unit = 0;
    while 1024.0 <= number && unit + 1 < UNITS.len() {
        number /= 1024.0;
        unit += 1;
    }
    if unit == 0 { format!("{bytes} bytes") } else { format!("{number:.1} {}", UNITS[unit]) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Endian;
    use slabsplat_core::SampleType;

    #[test]
    fn memory_of_files_that_were_read_is_free() {
        let (total_memory, rss) = (8 << 30, 1 << 30);
        // The system retains nearly all of it for files.
        let limits = CGroupLimits { total_memory, rss, free_memory: 1 << 28, free_swap: 0 };
        assert_eq!(room_of(&limits), 7 << 30);
        let limits = CGroupLimits { rss: 9 << 30, ..limits };
        assert_eq!(room_of(&limits), 0, "swap holds what is over");
    }

    #[test]
    fn memory_errors_say_what_each_needs() {
        let need = |what: &str, bytes| MemoryNeed { what: what.to_owned(), bytes };
        let needs = vec![need("cortex.nii.gz", 3 << 30), need("vessels.nrrd", 5 << 20)];
        assert!(check_within(needs.clone(), 4 << 30).is_ok());
        let error = check_within(needs, 2 << 30).unwrap_err().to_string();
        assert_eq!(
            error,
            "the volumes need 3.0 GiB of memory, and 2.0 GiB are free: cortex.nii.gz 3.0 GiB, vessels.nrrd \
             5.0 MiB"
        );
        assert!(check_within(vec![need("a", u64::MAX), need("b", 1)], 9).is_err());
    }

    #[test]
    fn memory_needs_are_those_of_headers() {
        let dir = tempfile::tempdir().unwrap();
        let check = |name: &str, header: &str, expected: &[u64]| {
            let path = dir.path().join(name);
            std::fs::write(&path, header).unwrap();
            let layer = LayerFile::of_volume(VolumeSource::File(path));
            let needs = MemoryNeed::of_layers(&[layer.clone(), layer]);
            let bytes: Vec<u64> = needs.iter().map(|need| need.bytes).collect();
            assert_eq!(bytes, expected, "{header}");
        };
        let nrrd = |sizes: &str| {
            format!(
                "NRRD0004\ntype: int16\ndimension: 3\nsizes: {sizes}\nencoding: gzip\nendian: little\n\n"
            )
        };
        check("a.nrrd", &nrrd("4 5 6"), &[240]);
        check("b.nrrd", &nrrd("4000000000 4000000000 4000000000"), &[u64::MAX]);
        check("a.json", r#"{"dims": [2, 3, 4], "type": "float64"}"#, &[192]);
        check("broken.json", "{}", &[]);
    }

    #[test]
    fn memory_needs_without_headers() {
        let bytes_of = |layer: LayerFile| {
            MemoryNeed::of_layers(&[layer]).iter().map(|need| need.bytes).collect::<Vec<_>>()
        };
        let builtin = |name: &str, size| {
            bytes_of(LayerFile::of_volume(VolumeSource::Builtin { name: name.to_owned(), size }))
        };
        assert_eq!(builtin("cube", None), [28 * 28 * 28]);
        assert_eq!(builtin("marschner-lobb", Some(1024)), [4 << 30]);
        assert_eq!([builtin("cube", Some(1025)), builtin("teapot", None)], [[0; 0]; 2]);
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.raw");
        std::fs::write(&path, [0; 50]).unwrap();
        let mut layer = LayerFile::of_volume(VolumeSource::File(path));
        for (dims, expected) in [([2, 3, 4], vec![48]), ([2, 3, 5], vec![])] {
            let sample_type = SampleType::U16;
            let (endian, spacing, header_bytes) = (Endian::Little, [1.0; 3], 2);
            layer.raw = Some(RawDesc { dims, sample_type, endian, spacing, header_bytes });
            assert_eq!(bytes_of(layer.clone()), expected);
        }
    }

    #[test]
    fn memory_is_told_in_units() {
        assert_eq!(in_units(1023), "1023 bytes");
        assert_eq!(in_units(1536), "1.5 KiB");
        assert_eq!(in_units(u64::MAX), "16777216.0 TiB");
    }

    /// Where it is not known nothing is refused; where it is, a byte has room.
    #[test]
    fn memory_that_is_free_is_some() {
        assert!(free_bytes().is_none_or(|free| 1 << 20 < free));
        let byte = MemoryNeed { what: "a byte".to_owned(), bytes: 1 };
        assert!(check_memory(vec![byte]).is_ok());
    }
}
