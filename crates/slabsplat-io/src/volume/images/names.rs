//! Which files of a folder are its slices, and in which order.

use std::cmp::Ordering;
use std::path::{Path, PathBuf};

/// Extensions of images, those of one kind together.
const KINDS: &[&[&str]] = &[&["tif", "tiff"], &["png"], &["jpg", "jpeg"]];

/// The images of a folder.
#[derive(Debug, PartialEq)]
pub(super) struct Slices {
    /// In the order of their names, at least two.
    pub(super) paths: Vec<PathBuf>,
    /// Files that are none of them, but for hidden ones.
    pub(super) n_others: usize,
}

impl Slices {
    /// The files of the kind that most are of; `None` if there are fewer than two.
    pub(super) fn of(files: &[PathBuf]) -> Option<Self> {
        let seen: Vec<&PathBuf> = files.iter().filter(|file| !is_hidden(file)).collect();
        let of_kind = |kind: &[&str]| -> Vec<PathBuf> {
            let is_it = |file: &&&PathBuf| kind.contains(&extension(file).as_str());
            seen.iter().filter(is_it).map(|file| (**file).clone()).collect()
        };
        let kinds = KINDS.iter().map(|kind| of_kind(kind));
        // Of several that are as many the first.
        let mut paths =
            kinds.reduce(|most, next| if most.len() < next.len() { next } else { most })?;
        paths.sort_by(|a, b| in_order(&name(a), &name(b)));
        let n_others = seen.len() - paths.len();
        (2 <= paths.len()).then_some(Self { paths, n_others })
    }
}

/// What systems leave in folders: `.DS_Store`, `._a.tif`, `Thumbs.db`.
fn is_hidden(file: &Path) -> bool {
    let name = name(file);
    name.starts_with('.') || name.eq_ignore_ascii_case("thumbs.db")
}

fn extension(file: &Path) -> String {
    file.extension().map(|extension| extension.to_string_lossy().to_lowercase()).unwrap_or_default()
}

fn name(file: &Path) -> String {
    file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

/// Numbers in names count as numbers, so that `a2` is before `a10`.
fn in_order(a: &str, b: &str) -> Ordering {
    let (mut rest_a, mut rest_b) = (a, b);
    while !rest_a.is_empty() && !rest_b.is_empty() {
        let (part_a, part_b) = (first_part(rest_a), first_part(rest_b));
        let order = match (number(part_a), number(part_b)) {
            // Without zeros in front the longer one is the larger one.
            (Some(x), Some(y)) => x.len().cmp(&y.len()).then(x.cmp(y)),
            _ => part_a.cmp(part_b),
        };
        if order != Ordering::Equal {
            return order;
        }
        rest_a = &rest_a[part_a.len()..];
        rest_b = &rest_b[part_b.len()..];
    }
    rest_a.len().cmp(&rest_b.len()).then(a.cmp(b))
}

/// The digits that a text begins with, or else all up to the first digit.
fn first_part(text: &str) -> &str {
    let begins_with_digit = text.starts_with(|c: char| c.is_ascii_digit());
    let end = text.find(|c: char| c.is_ascii_digit() != begins_with_digit);
    &text[..end.unwrap_or(text.len())]
}

fn number(part: &str) -> Option<&str> {
    part.starts_with(|c: char| c.is_ascii_digit()).then(|| part.trim_start_matches('0'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_in_the_order_of_their_numbers() {
        let check = |sorted: &[&str]| {
            let mut names = sorted.to_vec();
            names.reverse();
            names.sort_by(|a, b| in_order(a, b));
            assert_eq!(names, sorted);
        };
        check(&["a1.png", "a2.png", "a10.png", "b1.png"]);
        check(&["0.png", "01.png", "1.png", "2.png", "99999999999999999999999.png"]);
        check(&["z1t2", "z1t10", "z2t1", "z10t1"]);
        check(&["", "a", "a0", "ab", "ä1", "ä2"]);
    }

    #[test]
    fn names_of_the_kind_that_most_are_of() {
        let slices = |names: &[&str]| {
            let files: Vec<PathBuf> = names.iter().map(PathBuf::from).collect();
            let slices = Slices::of(&files)?;
            let names = slices.paths.iter().map(|path| name(path)).collect::<Vec<_>>().join(" ");
            Some((names, slices.n_others))
        };
        let mixed = ["s10.TIF", "preview.png", "s9.tiff", ".DS_Store", "._s9.tiff", "notes.txt"];
        assert_eq!(slices(&mixed), Some(("s9.tiff s10.TIF".to_owned(), 2)));
        assert_eq!(slices(&["a.jpg", "b.jpeg", "Thumbs.db"]).unwrap().1, 0);
        assert_eq!(slices(&["a.png", "b.tif"]), None);
        assert_eq!(slices(&[]), None);
    }
}
