//! Where the voxels lie. World space is RAS+: an axis that points left or to the back changes sign,
//! a space that does not say where the body is stays as it is (model §1).

use slabsplat_core::Orientation;
use slabsplat_core::glam::{DAffine3, DMat3, DVec3};

use super::super::units::{millimetres, unknown};
use super::axes::Axes;
use super::header::Header;
use crate::IoError;

/// The place of the grid, from `space directions` or else `spacings`. A file with both is read,
/// though the format does not allow it: the directions say all that the spacings do.
pub(super) fn world_from_index(
    header: &Header,
    axes: &Axes,
    warnings: &mut Vec<String>,
) -> Result<DAffine3, IoError> {
    let n_axes = axes.file_sizes.len();
    let (columns, origin, unit) = match directions(header, n_axes)? {
        Some(directions) => {
            let columns = along_directions(header, axes, &directions)?;
            (columns, origin(header, warnings)?, space_unit(header, warnings))
        }
        None => {
            let columns = along_axes(header, axes, warnings)?;
            let origin = match header.get("space origin") {
                Some(_) => origin(header, warnings)?,
                None => origin_by_mins(header, axes, &columns)?,
            };
            (columns, origin, axis_unit(header, axes, warnings))
        }
    };
    let unit = DVec3::splat(unit);
    let world_from_space = DMat3::from_diagonal(signs(header, warnings) * unit);
    let [x, y, z] = columns;
    Ok(DAffine3::from_mat3_translation(
        world_from_space * DMat3::from_cols(x, y, z),
        world_from_space * origin,
    ))
}

/// The step along each axis of the file, `None` for those that are not in space.
pub(super) fn directions(
    header: &Header,
    n_axes: usize,
) -> Result<Option<Vec<Option<DVec3>>>, IoError> {
    let Some(text) = header.get("space directions") else {
        return Ok(None);
    };
    let directions = parse_directions(text).filter(|directions| directions.len() == n_axes);
    let what =
        || format!("space directions should be {n_axes} vectors (x,y,z) or \"none\", not {text:?}");
    directions.map(Some).ok_or_else(|| header.malformed(what()))
}

fn parse_directions(text: &str) -> Option<Vec<Option<DVec3>>> {
    let mut directions = Vec::new();
    let mut rest = text.trim_start();
    while !rest.is_empty() {
        rest = if let Some(after) = rest.strip_prefix("none") {
            directions.push(None);
            after
        } else {
            let end = rest.find(')')? + 1;
            let vector = parse_vector(&rest[..end])?;
            // Some writers give NaN where the format has "none".
            directions.push((!vector.is_nan()).then_some(vector));
            &rest[end..]
        }
        .trim_start();
    }
    Some(directions)
}

/// `(x,y,z)`; in a space with time, the fourth number is left out; in a plane, z is 0.
fn parse_vector(text: &str) -> Option<DVec3> {
    let inside = text.trim().strip_prefix('(')?.strip_suffix(')')?;
    let numbers: Option<Vec<f64>> = inside.split(',').map(|n| n.trim().parse().ok()).collect();
    match numbers?[..] {
        [x, y, z] | [x, y, z, _] => Some(DVec3::new(x, y, z)),
        [x, y] => Some(DVec3::new(x, y, 0.0)),
        _ => None,
    }
}

fn along_directions(
    header: &Header,
    axes: &Axes,
    directions: &[Option<DVec3>],
) -> Result<[DVec3; 3], IoError> {
    let column = |axis: usize| {
        let what = || format!("axis {axis} of the volume has no direction in space");
        directions[axis].ok_or_else(|| header.malformed(what()))
    };
    match axes.of_volume {
        [Some(x), Some(y), Some(z)] => Ok([column(x)?, column(y)?, column(z)?]),
        // A slice is 1 thick, to the side that makes its axes right-handed.
        of_slice => {
            let [x, y] = [of_slice[0], of_slice[1]].map(Option::unwrap_or_default);
            let [x, y] = [column(x)?, column(y)?];
            Ok([x, y, x.cross(y).normalize_or_zero()])
        }
    }
}

fn along_axes(
    header: &Header,
    axes: &Axes,
    warnings: &mut Vec<String>,
) -> Result<[DVec3; 3], IoError> {
    let n_axes = axes.file_sizes.len();
    let spacings: Option<Vec<f64>> = header.numbers("spacings", n_axes)?;
    if spacings.is_none() && header.get("axis mins").is_some() {
        warnings.push("axis mins and axis maxs are not read: a spacing of 1 was assumed".into());
    }
    let mut spacing = |axis: usize| match spacings.as_ref().map(|s| s[axis]) {
        None => 1.0,
        Some(spacing) if spacing.is_nan() => {
            warnings.push(format!("axis {axis} has no spacing: 1 was assumed"));
            1.0
        }
        Some(spacing) => spacing,
    };
    let [x, y, z] = axes.of_volume.map(|axis| axis.map_or(1.0, &mut spacing));
    Ok([DVec3::X * x, DVec3::Y * y, DVec3::Z * z])
}

/// Where the first voxel's middle is, by where axes begin: `axis mins` beside `spacings`, as ITK has it. An
/// axis that does not say otherwise begins at the voxel's border.
fn origin_by_mins(header: &Header, axes: &Axes, columns: &[DVec3; 3]) -> Result<DVec3, IoError> {
    let n_axes = axes.file_sizes.len();
    let mins: Option<Vec<f64>> = header.numbers("axis mins", n_axes)?;
    let (Some(mins), Some(_)) = (mins, header.get("spacings")) else { return Ok(DVec3::ZERO) };
    let centers: Vec<&str> =
        header.get("centers").map(|text| text.split_whitespace().collect()).unwrap_or_default();
    let mut origin = DVec3::ZERO;
    let in_file = columns.iter().zip(axes.of_volume);
    for (column, axis) in in_file.filter_map(|(column, axis)| Some((column, axis?))) {
        let half = if centers.get(axis) == Some(&"node") { DVec3::ZERO } else { *column / 2.0 };
        if mins[axis].is_finite() {
            origin += half + column.normalize_or_zero().abs() * mins[axis];
        }
    }
    Ok(origin)
}

/// Millimetres of the unit in which all of space is measured.
fn space_unit(header: &Header, warnings: &mut Vec<String>) -> f64 {
    let units = header.get("space units").map(quoted).unwrap_or_default();
    one_unit(&units, warnings)
}

/// Millimetres of the unit of the volume's axes, if they all have one.
fn axis_unit(header: &Header, axes: &Axes, warnings: &mut Vec<String>) -> f64 {
    let units = header.get("units").map(quoted).unwrap_or_default();
    let of_volume = axes.of_volume.iter().flatten().filter_map(|&axis| units.get(axis).cloned());
    one_unit(&of_volume.collect::<Vec<_>>(), warnings)
}

/// Millimetres of the one unit that axes have; of none, of several, or of what is no length, 1.
fn one_unit(units: &[String], warnings: &mut Vec<String>) -> f64 {
    let Some(first) = units.first().filter(|unit| !unit.is_empty()) else { return 1.0 };
    let is_one = units.iter().all(|unit| unit == first);
    if let (Some(unit), true) = (millimetres(first), is_one) {
        return unit;
    }
    if is_one {
        warnings.push(unknown(first));
    } else {
        let shown: Vec<String> = units.iter().map(|unit| unit.chars().take(16).collect()).collect();
        warnings.push(format!("the units {shown:?} were taken as millimetres"));
    }
    1.0
}

/// Texts in quotes.
fn quoted(text: &str) -> Vec<String> {
    text.split('"').skip(1).step_by(2).map(|unit| unit.trim().to_owned()).collect()
}

fn origin(header: &Header, warnings: &mut Vec<String>) -> Result<DVec3, IoError> {
    let Some(text) = header.get("space origin") else {
        return Ok(DVec3::ZERO);
    };
    let what = || format!("space origin should be a vector (x,y,z), not {text:?}");
    let origin = parse_vector(text).ok_or_else(|| header.malformed(what()))?;
    if origin.is_nan() {
        warnings.push("the space origin is not known: 0 was assumed".to_owned());
        return Ok(DVec3::ZERO);
    }
    Ok(origin)
}

/// Whether the file's space is that of a body.
pub(super) fn orientation(header: &Header) -> Orientation {
    let space = header.get("space").map(str::to_lowercase).unwrap_or_default();
    let name = space.strip_suffix("-time").unwrap_or(&space);
    match anatomical_signs(name) {
        Some(_) => Orientation::Anatomical,
        None => Orientation::Unknown,
    }
}

/// −1 for the axes of the file's space that run against the world's.
fn signs(header: &Header, warnings: &mut Vec<String>) -> DVec3 {
    let Some(space) = header.get("space") else {
        return DVec3::ONE;
    };
    let name = space.to_lowercase();
    let name = name.strip_suffix("-time").unwrap_or(&name);
    if let "scanner-xyz" | "3d-right-handed" | "3d-left-handed" = name {
        return DVec3::ONE;
    }
    anatomical_signs(name).unwrap_or_else(|| {
        warnings.push(format!("the space {space:?} is not known: it was taken as it is"));
        DVec3::ONE
    })
}

/// For `left-posterior-superior` and its kin, and for the abbreviation `LPS`.
fn anatomical_signs(name: &str) -> Option<DVec3> {
    let letters: String = match name.len() {
        3 | 4 => name.trim_end_matches('t').to_owned(),
        _ => name.split('-').filter_map(|word| word.chars().next()).collect(),
    };
    let mut signs = [1.0; 3];
    if letters.chars().count() != 3 {
        return None;
    }
    for (sign, (letter, [along, against])) in
        signs.iter_mut().zip(letters.chars().zip([['r', 'l'], ['a', 'p'], ['s', 'i']]))
    {
        *sign = match letter {
            l if l == along => 1.0,
            l if l == against => -1.0,
            _ => return None,
        };
    }
    Some(DVec3::from_array(signs))
}

#[cfg(test)]
mod tests {
    use super::super::axes;
    use super::*;

    const HEAD: &str = "dimension: 3\nsizes: 2 3 4\n";

    fn place(lines: &str) -> Result<(DAffine3, Vec<String>), String> {
        let header = Header::of(&format!("{HEAD}{lines}"));
        let mut warnings = Vec::new();
        let axes = axes::find(&header).map_err(|e| e.to_string())?;
        let affine = world_from_index(&header, &axes, &mut warnings).map_err(|e| e.to_string())?;
        Ok((affine, warnings))
    }

    #[test]
    fn space_becomes_ras() {
        let check = |space: &str, signs: [f64; 3]| {
            let (affine, warnings) = place(&format!(
                "space: {space}\nspace directions: (2,0,0) (0,3,0) (0, 1, 4)\nspace origin: (5,6,7)"
            ))
            .unwrap();
            let signs = DVec3::from_array(signs);
            assert_eq!(affine.matrix3.x_axis, signs * DVec3::X * 2.0, "{space}");
            assert_eq!(affine.matrix3.z_axis, signs * DVec3::new(0.0, 1.0, 4.0), "{space}");
            assert_eq!(affine.translation, signs * DVec3::new(5.0, 6.0, 7.0), "{space}");
            assert!(warnings.is_empty(), "{warnings:?}");
        };
        check("left-posterior-superior", [-1.0, -1.0, 1.0]);
        check("LPS", [-1.0, -1.0, 1.0]);
        check("right-anterior-superior", [1.0, 1.0, 1.0]);
        check("Left-Anterior-Superior", [-1.0, 1.0, 1.0]);
        check("LAST", [-1.0, 1.0, 1.0]);
        check("left-posterior-superior-time", [-1.0, -1.0, 1.0]);
        check("scanner-xyz", [1.0, 1.0, 1.0]);
        check("3D-left-handed", [1.0, 1.0, 1.0]);
        assert_eq!(place("space: heavenly").unwrap().1.len(), 1);
    }

    #[test]
    fn space_without_directions() {
        let diagonal = |lines: &str| {
            let (affine, warnings) = place(lines).unwrap();
            let m = affine.matrix3;
            ([m.x_axis.x, m.y_axis.y, m.z_axis.z], warnings.len())
        };
        assert_eq!(diagonal(""), ([1.0; 3], 0));
        assert_eq!(diagonal("spacings: 1 2 -3"), ([1.0, 2.0, -3.0], 0));
        assert_eq!(diagonal("spacings: 1 NaN 3"), ([1.0, 1.0, 3.0], 1));
        assert_eq!(diagonal("space: 3D-left-handed\nspacings: 1 2 3"), ([1.0, 2.0, 3.0], 0));
        assert_eq!(diagonal("space: LPS\nspacings: 1 2 3"), ([-1.0, -2.0, 3.0], 0));
        let directions = "space directions: (4,0,0) (0,5,0) (0,0,6)";
        assert_eq!(diagonal(&format!("spacings: 1 2 3\n{directions}")), ([4.0, 5.0, 6.0], 0));
    }

    /// As SimpleITK 2 reads them.
    #[test]
    fn space_begins_at_axis_mins() {
        let origin = |lines: &str| place(lines).unwrap().0.translation;
        let mins = "spacings: 2 3 4\naxis mins: 10 20 30\n";
        assert_eq!(origin(mins), DVec3::new(11.0, 21.5, 32.0));
        let nodes = format!("{mins}centers: node node node");
        assert_eq!(origin(&nodes), DVec3::new(10.0, 20.0, 30.0));
        let unknown = mins.replace("20", "NaN");
        assert_eq!(origin(&unknown), DVec3::new(11.0, 0.0, 32.0));
    }

    #[test]
    fn space_has_units() {
        let spacing = |lines: &str| {
            let (affine, warnings) = place(lines).unwrap();
            (affine.matrix3.y_axis.y, affine.translation.x, warnings.len())
        };
        let directions = "space directions: (1,0,0) (0,2,0) (0,0,1)\nspace origin: (5,0,0)\n";
        let micrometres = r#"space units: "um" "um" "um""#;
        assert_eq!(spacing(&format!("{directions}{micrometres}")), (0.002, 0.005, 0));
        assert_eq!(
            spacing(&format!("{directions}space units: \"m\" \"mm\" \"mm\"")),
            (2.0, 5.0, 1)
        );
        assert_eq!(spacing(r#"units: "m" "m" "m""#), (1000.0, 0.0, 0));
        assert_eq!(spacing(r#"units: "s" "s" "s""#), (1.0, 0.0, 1));
        assert_eq!(spacing(r#"units: "" "" """#), (1.0, 0.0, 0));
    }

    #[test]
    fn space_errors_show_the_text() {
        for (lines, expected) in [
            ("spacings: 1 1", "spacings"),
            ("space directions: (1,0,0) (0,1,0)", "3 vectors"),
            ("space directions: (1,0,0) (0,1,0) (0,0", "3 vectors"),
            ("space directions: (1) (0) (0)", "3 vectors"),
            ("space directions: none none (0,1,0)", "axis 1"),
            ("space origin: 1 2 3", "space origin"),
        ] {
            let err = place(lines).unwrap_err();
            assert!(err.contains(expected), "{err} should contain {expected}");
        }
    }
}
