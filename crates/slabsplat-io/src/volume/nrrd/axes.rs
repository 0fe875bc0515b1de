//! Which of a file's axes are the volume's three. Of the others the first may be that of channels, and the
//! last that of times, unless they are one long.

use super::super::choices::{Part, VolumeChoices};
use super::super::colors::{Meaning, Values};
use super::super::formats::Input;
use super::super::stored::StoredType;

use super::header::Header;
use crate::IoError;

/// The format's own limit.
const MAX_AXES: usize = 16;

/// Kinds of axes along which places change. Along all others the parts of one value lie.
const DOMAIN_KINDS: &[&str] = &["domain", "space", "???", "none"];

/// Kinds of axes along which the parts of a colour lie that can be shown as it is.
const COLOR_KINDS: &[&str] = &["rgb-color", "rgba-color"];

/// A file's axes, as far as a volume goes.
#[derive(Debug, PartialEq)]
pub(super) struct Axes {
    /// Sizes of all axes of the file.
    pub(super) file_sizes: Vec<usize>,
    /// Which of them are x, y and z; an image of two axes is a slice, and has no z.
    pub(super) of_volume: [Option<usize>; 3],
    /// Their sizes.
    pub(super) dims: [usize; 3],
    /// How many values each voxel has, one after the other.
    n_channels: usize,
    /// Whether these are a colour.
    is_color: bool,
    /// How many volumes follow each other.
    n_times: usize,
}

impl Axes {
    /// Which channel and time are read.
    pub(super) fn choices(
        &self,
        input: &Input<'_>,
        stored: StoredType,
    ) -> Result<VolumeChoices, IoError> {
        let meaning = if self.is_color { Meaning::Color } else { Meaning::Other };
        let values = Values { n: self.n_channels, stored, meaning };
        let time = input.choose(Part::Time, self.n_times)?;
        Ok(VolumeChoices { time, ..input.choose_values(&values)? })
    }
}

/// Picks the three axes of the volume.
pub(super) fn find(header: &Header) -> Result<Axes, IoError> {
    let n_axes = n_axes(header)?;
    let sizes: Vec<usize> = header
        .numbers("sizes", n_axes)?
        .ok_or_else(|| header.malformed("the header has no field \"sizes\""))?;
    let kinds = kinds(header, n_axes)?;
    let is_value = |axis: usize| 1 < sizes[axis] && !is_domain(&kinds[axis]);
    let [channel, time] = outer_axes(&sizes, is_value);
    let is_other = |axis: &usize| is_value(*axis) && ![channel, time].contains(&Some(*axis));
    if let Some(axis) = (0..n_axes).find(is_other) {
        let (kind, size) = (&kinds[axis], sizes[axis]);
        return Err(header.unsupported(format!(
            "axis {axis} (kind {kind:?}, {size} long) holds more than one value a voxel, and is neither \
             the first nor the last: save one of them as a volume of its own"
        )));
    }
    let left: Vec<usize> =
        (0..n_axes).filter(|axis| ![channel, time].contains(&Some(*axis))).collect();
    // Of four axes that all may be of space, the last is one of time.
    let n_long = left.iter().filter(|&&axis| 1 < sizes[axis]).count();
    let last = left.iter().rev().copied().find(|&axis| 1 < sizes[axis]);
    let time = if 3 < n_long && time.is_none() { last } else { time };
    let left: Vec<usize> = left.into_iter().filter(|&axis| Some(axis) != time).collect();
    let of_volume = without_flat_axes(header, left, &sizes, &kinds)?;
    let dims = of_volume.map(|axis| axis.map_or(1, |axis| sizes[axis]));
    let size = |axis: Option<usize>| axis.map_or(1, |axis| sizes[axis]);
    let (n_channels, n_times) = (size(channel), size(time));
    let is_color = channel.is_some_and(|axis| COLOR_KINDS.contains(&kinds[axis].as_str()));
    Ok(Axes { file_sizes: sizes, of_volume, dims, n_channels, is_color, n_times })
}

fn n_axes(header: &Header) -> Result<usize, IoError> {
    let n_axes = header
        .parsed("dimension")?
        .ok_or_else(|| header.malformed("the header has no field \"dimension\""))?;
    match n_axes {
        2..=MAX_AXES => Ok(n_axes),
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
    mut kept: Vec<usize>,
    sizes: &[usize],
    kinds: &[String],
) -> Result<[Option<usize>; 3], IoError> {
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
    match kept[..] {
        [x, y, z] => Ok([x, y, z].map(Some)),
        [x, y] if sizes.len() <= 3 => Ok([Some(x), Some(y), None]),
        _ => {
            let n = kept.len();
            Err(header.unsupported(format!("the file has {n} axes in space, and a volume needs 3")))
        }
    }
}

/// The first axis and the last of those that are not one long, if along them are values: the values of a
/// voxel, and times.
fn outer_axes(sizes: &[usize], is_value: impl Fn(usize) -> bool) -> [Option<usize>; 2] {
    let long: Vec<usize> = (0..sizes.len()).filter(|&axis| sizes[axis] != 1).collect();
    let first = long.first().copied().filter(|&axis| is_value(axis));
    let last = long.last().copied().filter(|&axis| is_value(axis) && Some(axis) != first);
    [first, last]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_leave_out_flat_ones() {
        let check = |lines: &str, of_volume: [usize; 3]| {
            let axes = find(&Header::of(lines)).unwrap();
            assert_eq!(axes.of_volume, of_volume.map(Some), "{lines}");
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
    fn axes_of_an_image_are_those_of_a_slice() {
        for (lines, of_volume, dims) in [
            ("dimension: 2\nsizes: 4 5", [Some(0), Some(1), None], [4, 5, 1]),
            (
                "dimension: 3\nsizes: 3 4 5\nkinds: vector space space",
                [Some(1), Some(2), None],
                [4, 5, 1],
            ),
            (
                "dimension: 3\nsizes: 4 5 9\nkinds: space space list",
                [Some(0), Some(1), None],
                [4, 5, 1],
            ),
        ] {
            let axes = find(&Header::of(lines)).unwrap();
            assert_eq!((axes.of_volume, axes.dims), (of_volume, dims), "{lines}");
        }
    }

    #[test]
    fn axes_name_what_is_too_much() {
        let check = |lines: &str, expected: &str| {
            let err = find(&Header::of(lines)).unwrap_err().to_string();
            assert!(err.contains(expected), "{err} should contain {expected}");
        };
        check("sizes: 4 5 6", "\"dimension\"");
        check("dimension: three\nsizes: 4 5 6", "\"three\"");
        check("dimension: 1\nsizes: 4", "has 1 axes");
        check("dimension: 99999999999\nsizes: 4 5", "has 99999999999 axes");
        check("dimension: 3", "\"sizes\"");
        check("dimension: 3\nsizes: 4 5", "3 numbers");
        check("dimension: 3\nsizes: 4 -5 6", "3 numbers");
        check("dimension: 5\nsizes: 4 5 6 7 8", "axis 3 (7 long)");
        check("dimension: 4\nsizes: 4 5 6 7\nkinds: space vector space space", "axis 1");
        check("dimension: 2\nsizes: 4 5\nkinds: vector space", "has 1 axes in space");
        check("dimension: 3\nsizes: 3 5 6\nkinds: vector domain", "3 words");
    }
}
