//! Where the data of a MetaImage are.

use super::super::data_files::{DataFiles, Pattern, count};
use super::super::formats::Input;
use super::header::Header;
use crate::IoError;

/// Finds the data's files. Names are relative to the header's folder.
pub(super) fn find(
    input: &Input<'_>,
    header: &Header,
    sizes: &[usize],
) -> Result<DataFiles, IoError> {
    let text = header.needed("elementdatafile")?;
    if text.eq_ignore_ascii_case("local") {
        return Ok(DataFiles::Attached(header.path.clone(), header.n_bytes));
    }
    let n_axes = sizes.len();
    if header.is_list() {
        let n_axes_each = match text.split_whitespace().nth(1) {
            None => n_axes - 1,
            Some(word) => {
                let n_axes_each = word.parse().ok().filter(|n| (1..n_axes).contains(n));
                let what = || format!("a listed file has 1 to {} axes, not {word:?}", n_axes - 1);
                n_axes_each.ok_or_else(|| header.malformed(what()))?
            }
        };
        let n_files = n_files(header, sizes, n_axes_each, header.listed_files.len() as u64)?;
        let names = header.listed_files.iter().take(n_files);
        let paths = names.map(|name| input.beside(name));
        return Ok(DataFiles::Given(paths.collect::<Result<_, _>>()?));
    }
    let Some((name, numbers)) = numbered(text, sizes[n_axes - 1]) else {
        return Ok(DataFiles::Given(vec![input.beside(text)?]));
    };
    let what = || format!("the pattern {name:?} is not of the form name%03d.raw");
    let folder = input.folder_of(name)?;
    let pattern = Pattern::parse(name).ok_or_else(|| header.unsupported(what()))?;
    let n_files = n_files(header, sizes, n_axes - 1, count(numbers).unwrap_or(0))?;
    let [first, _, step] = numbers;
    Ok(DataFiles::Numbered { folder, pattern, first, step, n_files })
}

/// How many files of some axes each there are, if there are as many as are needed.
fn n_files(
    header: &Header,
    sizes: &[usize],
    n_axes_each: usize,
    n_given: u64,
) -> Result<usize, IoError> {
    let product = |sizes: &[usize]| sizes.iter().fold(1, |n: u64, &s| n.saturating_mul(s as u64));
    let n_needed = product(&sizes[n_axes_each..]);
    if n_given != n_needed {
        let what = format!("the header names {n_given} data files where {n_needed} are needed");
        return Err(header.malformed(what));
    }
    Ok(n_needed as usize)
}

/// A name with `%`, and first, last and step of its numbers, as far as they are there; else they count all
/// slices from 1 on.
fn numbered(text: &str, n_slices: usize) -> Option<(&str, [i64; 3])> {
    if !text.contains('%') {
        return None;
    }
    let mut numbers = Vec::new();
    let mut name = text;
    while let Some((before, last)) = name.rsplit_once(char::is_whitespace)
        && let Ok(number) = last.parse()
        && numbers.len() < 3
    {
        numbers.insert(0, number);
        name = before.trim_end();
    }
    let mut all = [1, i64::try_from(n_slices).ok()?, 1];
    all[..numbers.len()].copy_from_slice(&numbers);
    Some((name, all))
}
