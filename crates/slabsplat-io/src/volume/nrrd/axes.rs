//! Which of a file's axes are the volume's three. Files of four and more axes are read as long as
//! the others are one long.

use super::header::Header;
use crate::IoError;

/// The format's own limit.
const MAX_AXES: usize = 16;

/// Kinds of axes along which places change. Along all others the parts of one value lie.
const DOMAIN_KINDS: &[&str] = &["domain", "space", "???", "none"];

/// A file's axes, as far as a volume goes.
#[derive(Debug, PartialEq)]
pub(super) struct Axes {
    /// Sizes of all axes of the file.
    pub(super) file_sizes: Vec<usize>,
    /// Which of them are x, y and z.
    pub(super) of_volume: [usize; 3],
    /// Their sizes.
    pub(super) dims: [usize; 3],
}

/// Picks the three axes of the volume.
pub(super) fn find(header: &Header) -> Result<Axes, IoError> {
    let n_axes = n_axes(header)?;
    let sizes: Vec<usize> = header
        .numbers("sizes", n_axes)?
        .ok_or_else(|| header.malformed("the header has no field \"sizes\""))?;
    let kinds = kinds(header, n_axes)?;
    if let Some(axis) = (0..n_axes).find(|&axis| 1 < sizes[axis] && !is_domain(&kinds[axis])) {
        let (kind, size) = (&kinds[axis], sizes[axis]);
        return Err(header.unsupported(format!(
            "axis {axis} (kind {kind:?}, {size} long) holds more than one value a voxel: save one \
             of them as a volume of its own"
        )));
    }
    let of_volume = without_flat_axes(header, &sizes, &kinds)?;
    let dims = of_volume.map(|axis| sizes[axis]);
    Ok(Axes { file_sizes: sizes, of_volume, dims })
}

fn n_axes(header: &Header) -> Result<usize, IoError> {
    let n_axes = header
        .parsed("dimension")?
        .ok_or_else(|| header.malformed("the header has no field \"dimension\""))?;
    match n_axes {
        3..=MAX_AXES => Ok(n_axes),
        _ => Err(header.unsupported(format!("the file has {n_axes} axes, and a volume needs 3"))),
    }
}

/// The kind of each axis; one without a direction in space is no domain, whatever it is called.
fn kinds(header: &Header, n_axes: usize) -> Result<Vec<String>, IoError> {
    let mut kinds = vec!["domain".to_owned(); n_axes];
    if let Some(text) = header.get("kinds") {
        kinds = text.split_whitespace().map(str::to_lowercase).collect();
        if kinds.len() != n_axes {
            return Err(header.malformed(format!("kinds should be {n_axes} words, not {text:?}")));
        }
    }
    let directions = super::space::directions(header, n_axes)?.unwrap_or_default();
    for (kind, direction) in kinds.iter_mut().zip(&directions) {
        if direction.is_none() && is_domain(kind) {
            *kind = "without a direction".to_owned();
        }
    }
    Ok(kinds)
}

fn is_domain(kind: &str) -> bool {
    DOMAIN_KINDS.contains(&kind)
}

/// Leaves out axes that are one long until three are left: first those that are no domain, then
/// the last.
fn without_flat_axes(
    header: &Header,
    sizes: &[usize],
    kinds: &[String],
) -> Result<[usize; 3], IoError> {
    let mut kept: Vec<usize> = (0..sizes.len()).collect();
    while 3 < kept.len() {
        let is_flat = |&&axis: &&usize| sizes[axis] == 1;
        let is_flat_value = |axis: &&usize| is_flat(axis) && !is_domain(&kinds[**axis]);
        let flat = kept.iter().find(is_flat_value).or_else(|| kept.iter().rev().find(is_flat));
        let Some(&flat) = flat else {
            let last = kept[kept.len() - 1];
            return Err(header.unsupported(format!(
                "axis {last} ({} long) is one too many: a volume has 3 axes, cut out a part of the \
                 file that is 1 long along this one",
                sizes[last]
            )));
        };
        kept.retain(|&axis| axis != flat);
    }
    Ok([kept[0], kept[1], kept[2]])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_leave_out_flat_ones() {
        let check = |lines: &str, of_volume: [usize; 3]| {
            let axes = find(&Header::of(lines)).unwrap();
            assert_eq!(axes.of_volume, of_volume, "{lines}");
            assert_eq!(axes.dims, of_volume.map(|axis| axes.file_sizes[axis]));
        };
        check("dimension: 3\nsizes: 4 5 1", [0, 1, 2]);
        check("dimension: 4\nsizes: 1 4 5 6", [1, 2, 3]);
        check("dimension: 4\nsizes: 4 5 6 1", [0, 1, 2]);
        check("dimension: 4\nsizes: 1 4 5 1\nkinds: vector domain domain domain", [1, 2, 3]);
        check("dimension: 4\nsizes: 1 4 5 1\nkinds: space space space list", [0, 1, 2]);
        let directions = "space directions: none (1,0,0) (0,1,0) (0,0,1)";
        check(&format!("dimension: 4\nsizes: 1 4 5 1\n{directions}"), [1, 2, 3]);
    }

    #[test]
    fn axes_name_what_is_too_much() {
        let check = |lines: &str, expected: &str| {
            let err = find(&Header::of(lines)).unwrap_err().to_string();
            assert!(err.contains(expected), "{err} should contain {expected}");
        };
        check("sizes: 4 5 6", "\"dimension\"");
        check("dimension: three\nsizes: 4 5 6", "\"three\"");
        check("dimension: 2\nsizes: 4 5", "has 2 axes");
        check("dimension: 99999999999\nsizes: 4 5", "has 99999999999 axes");
        check("dimension: 3", "\"sizes\"");
        check("dimension: 3\nsizes: 4 5", "3 numbers");
        check("dimension: 3\nsizes: 4 -5 6", "3 numbers");
        check("dimension: 4\nsizes: 4 5 6 7", "axis 3 (7 long)");
        check("dimension: 4\nsizes: 3 5 6 7\nkinds: RGB-color domain domain domain", "axis 0");
        check("dimension: 4\nsizes: 4 5 6 7\nkinds: space space space time", "axis 3");
        check("dimension: 3\nsizes: 3 5 6\nkinds: vector domain", "3 words");
    }
}
