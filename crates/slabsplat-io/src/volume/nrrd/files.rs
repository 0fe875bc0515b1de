//! Where the header says that the data are.

use super::super::data_files::{DataFiles, Pattern, count};
use super::super::formats::Input;
use super::header::Header;
use crate::IoError;

/// Finds the data's files. Names are relative to the header's folder.
pub(super) fn find(
    input: &Input<'_>,
    header: &Header,
    file_sizes: &[usize],
) -> Result<DataFiles, IoError> {
    let Some(text) = header.get("data file") else {
        return Ok(DataFiles::Attached(header.path.clone(), header.n_bytes));
    };
    let words: Vec<&str> = text.split_whitespace().collect();
    if words.first() == Some(&"LIST") {
        let names = &header.listed_files;
        check_count(header, names.len() as u64, words.get(1).copied(), file_sizes)?;
        let paths = names.iter().map(|name| input.beside(name));
        return Ok(DataFiles::Given(paths.collect::<Result<_, _>>()?));
    }
    let Some((name, numbers, subdim)) = numbered(text) else {
        return Ok(DataFiles::Given(vec![input.beside(text)?]));
    };
    let what = || format!("the pattern {name:?} is not of the form name%03d.raw");
    let folder = input.folder_of(name)?;
    let pattern = Pattern::parse(name).ok_or_else(|| header.unsupported(what()))?;
    let n_files = count(numbers).unwrap_or(0);
    check_count(header, n_files, subdim, file_sizes)?;
    let [first, _, step] = numbers;
    Ok(DataFiles::Numbered { folder, pattern, first, step, n_files: n_files as usize })
}

/// Checks that the files together are the volume. `subdim` says how many axes one file has; without
/// it, one file is a slice.
fn check_count(
    header: &Header,
    n_files: u64,
    subdim: Option<&str>,
    file_sizes: &[usize],
) -> Result<(), IoError> {
    let n_axes = file_sizes.len();
    let n_axes_each = match subdim {
        None => n_axes - 1,
        Some(word) => word.parse().ok().filter(|n| (1..=n_axes).contains(n)).ok_or_else(|| {
            let what = format!("a data file has 1 to {n_axes} axes, not {word:?}");
            header.malformed(what)
        })?,
    };
    let product = |sizes: &[usize]| sizes.iter().fold(1, |n: u64, &s| n.saturating_mul(s as u64));
    let needed = product(&file_sizes[n_axes_each..]);
    // Files of all axes are slabs: any number of them that parts the last axis evenly.
    let are_slabs = n_axes_each == n_axes
        && 0 < n_files
        && (file_sizes[n_axes - 1] as u64).is_multiple_of(n_files);
    if n_files == needed || are_slabs {
        return Ok(());
    }
    Err(header
        .malformed(format!("the header names {n_files} data files where {needed} are needed")))
}

/// A name with `%`, then min, max, step and maybe the number of axes of one file.
fn numbered(text: &str) -> Option<(&str, [i64; 3], Option<&str>)> {
    let words: Vec<&str> = text.split_whitespace().collect();
    let parse = |words: &[&str]| -> Option<[i64; 3]> {
        let numbers: Vec<i64> = words.iter().map(|w| w.parse().ok()).collect::<Option<_>>()?;
        numbers.try_into().ok()
    };
    for n_numbers in [4, 3] {
        let n_name = words.len().saturating_sub(n_numbers);
        let name = name_of(text, n_numbers);
        let numbers = words.get(n_name..n_name + 3).and_then(parse);
        if let (Some(numbers), true) = (numbers, name.contains('%')) {
            return Some((name, numbers, words.get(n_name + 3).copied()));
        }
    }
    None
}

/// The text without its last words; the name itself may hold blanks.
fn name_of(text: &str, n_last_words: usize) -> &str {
    (0..n_last_words).fold(text, |text, _| {
        let text = text.trim_end();
        text.rsplit_once(char::is_whitespace).map_or("", |(before, _)| before)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::VolumeOptions;
    use crate::store::Store;

    fn names(data_file: &str, file_sizes: &[usize]) -> Result<Vec<String>, String> {
        let header = Header::of(&format!("data file: {data_file}"));
        let options = VolumeOptions::default();
        let input =
            Input { store: Store::Disk, path: &header.path, options: &options, spill: None };
        let files = find(&input, &header, file_sizes).map_err(|e| e.to_string())?;
        Ok((0..files.len()).map(|idx| files.get(idx).0.display().to_string()).collect())
    }

    #[test]
    fn files_of_a_pattern() {
        assert_eq!(names("s.%d 9 11 1", &[2, 2, 3]).unwrap(), ["s.9", "s.10", "s.11"]);
        assert_eq!(names("a b%03u.raw 4 0 -2", &[2, 2, 3]).unwrap()[2], "a b000.raw");
        assert_eq!(names("s%2d 1 6 1 1", &[2, 2, 3]).unwrap()[0], "s 1");
        assert_eq!(names("s%d 1 2 1 3", &[2, 2, 6]).unwrap().len(), 2);
        let far = [i64::MIN, i64::MAX, i64::MAX];
        let far = far.map(|n| n.to_string()).join(" ");
        assert_eq!(names(&format!("s%d {far}"), &[2, 2, 3]).unwrap()[2], "s9223372036854775806");
        assert_eq!(names("50% 1.raw", &[2, 2, 6]).unwrap(), ["50% 1.raw"]);
    }

    #[test]
    fn files_of_a_list() {
        assert_eq!(names("LIST\nb.raw\na c.raw", &[2, 2, 2]).unwrap(), ["b.raw", "a c.raw"]);
        assert_eq!(names("LIST 3\nb.raw", &[2, 2, 2]).unwrap(), ["b.raw"]);
    }

    #[test]
    fn files_must_make_the_volume() {
        for (data_file, expected) in [
            ("LIST\na.raw", "names 1 data files where 3"),
            ("LIST", "names 0 data files"),
            ("LIST x\na.raw", "not \"x\""),
            ("LIST 7\na.raw", "not \"7\""),
            ("s%d 1 9 1", "names 9 data files where 3"),
            ("s%d 1 3 0", "names 0 data files"),
            ("s%d 3 1 1", "names 0 data files"),
            ("s%d -9223372036854775808 9223372036854775807 1", "data files where 3"),
            ("s%d%d 1 3 1", "not of the form"),
            ("s%999d 1 3 1", "not of the form"),
        ] {
            let err = names(data_file, &[2, 2, 3]).unwrap_err();
            assert!(err.contains(expected), "{err} should contain {expected}");
        }
    }
}
