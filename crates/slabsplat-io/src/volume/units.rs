//! Units of length, which become millimetres everywhere alike.

/// Prefixes of the metre, as symbols and as words, and their powers of ten.
const PREFIXES: &[(&str, &str, i32)] = &[
    ("Y", "yotta", 24),
    ("Z", "zetta", 21),
    ("E", "exa", 18),
    ("P", "peta", 15),
    ("T", "tera", 12),
    ("G", "giga", 9),
    ("M", "mega", 6),
    ("k", "kilo", 3),
    ("h", "hecto", 2),
    ("da", "deca", 1),
    ("", "", 0),
    ("d", "deci", -1),
    ("c", "centi", -2),
    ("m", "milli", -3),
    // The micro sign, the Greek letter, and ImageJ's ways round both.
    ("µ", "micro", -6),
    ("μ", "micro", -6),
    ("u", "micro", -6),
    ("\\u00B5", "micro", -6),
    ("n", "nano", -9),
    ("p", "pico", -12),
    ("f", "femto", -15),
    ("a", "atto", -18),
    ("z", "zepto", -21),
    ("y", "yocto", -24),
];

/// Lengths that have no prefix, by all their names, in millimetres.
const OTHERS: &[(&[&str], f64)] = &[
    (&["micron", "microns"], 1e-3),
    (&["Å", "å", "angstrom", "ångström", "ångstrom"], 1e-7),
    (&["thou", "mil"], 0.0254),
    (&["pt"], 25.4 / 72.0),
    (&["li"], 25.4 / 12.0),
    (&["in", "inch", "inches"], 25.4),
    (&["ft", "foot", "feet"], 304.8),
    (&["yd", "yard", "yards"], 914.4),
    (&["mi", "mile", "miles"], 1_609_344.0),
    (&["ua", "au"], 1.495_978_707e14),
    (&["ly"], 9.460_730_472_580_8e18),
    (&["pc", "parsec"], 3.085_677_581_491_367e19),
];

/// How many millimetres a unit has, as OME, UDUNITS, ImageJ and NRRD name it; `None` for what is no length.
pub(super) fn millimetres(unit: &str) -> Option<f64> {
    let unit = unit.trim();
    // Of symbols the case decides: mm, Mm.
    let lower = if unit.len() < 4 { unit.to_owned() } else { unit.to_lowercase() };
    of_metre(unit).or_else(|| of_metre(&lower)).or_else(|| {
        let is_it =
            |(names, _): &&(&[&str], f64)| names.contains(&unit) || names.contains(&&*lower);
        OTHERS.iter().find(is_it).map(|(_, millimetres)| *millimetres)
    })
}

/// What to say of a unit that is none.
pub(super) fn unknown(unit: &str) -> String {
    let shown: String = unit.chars().take(40).collect();
    format!("{shown:?} is no unit of length that is known: millimetres were assumed")
}

/// What to say of a file that has no lengths at all.
pub(super) const NO_SIZE: &str =
    "the file does not say how large its voxels are: 1 x 1 x 1 was assumed";

/// What to say of a stack of which only the pixels' size is known.
pub(super) const NO_DEPTH: &str =
    "the file does not say how far apart slices are: as far as pixels was assumed";

/// Sizes along three axes in millimetres. With a unit that is none the proportions are kept, if it is that of
/// all; sizes of which only some can be read say nothing.
pub(super) fn in_millimetres(
    sizes: [f64; 3],
    units: [&str; 3],
    warnings: &mut Vec<String>,
) -> [f64; 3] {
    if let [Some(x), Some(y), Some(z)] = units.map(millimetres) {
        return [sizes[0] * x, sizes[1] * y, sizes[2] * z];
    }
    if units.iter().all(|unit| *unit == units[0]) {
        warnings.push(unknown(units[0]));
        return sizes;
    }
    let shown = units.map(|unit| unit.chars().take(16).collect::<String>());
    warnings.push(format!(
        "voxels are measured in {shown:?}, not all of which are lengths: 1 x 1 x 1 was assumed"
    ));
    [1.0; 3]
}

fn of_metre(unit: &str) -> Option<f64> {
    let words = ["meters", "metres", "meter", "metre"];
    let prefix_word = words.iter().find_map(|word| unit.strip_suffix(word));
    let power = match (prefix_word, unit.strip_suffix('m')) {
        (Some(word), _) => PREFIXES.iter().find(|(_, name, _)| *name == word),
        (None, Some(symbol)) => PREFIXES.iter().find(|(prefix, _, _)| *prefix == symbol),
        (None, None) => None,
    };
    let (_, _, power) = power?;
    // Parsing rounds once, a product of tens at every step.
    format!("1e{}", power + 3).parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_of_length_by_all_their_names() {
        for (names, expected) in [
            (&["m", "meter", "metre", "Meter"][..], 1e3),
            (&["mm", "millimeter", "millimetres", " mm "], 1.0),
            (
                &["µm", "μm", "um", "\\u00B5m", "micron", "Microns", "micrometer", "micrometre"],
                1e-3,
            ),
            (&["nm", "nanometer"], 1e-6),
            (&["pm", "picometer"], 1e-9),
            (&["Å", "angstrom"], 1e-7),
            (&["cm", "centimeter"], 10.0),
            (&["dm", "decimeter"], 100.0),
            (&["km", "kilometre"], 1e6),
            (&["Mm", "megameter"], 1e9),
            (&["ym", "yoctometer"], 1e-21),
            (&["in", "inch", "inches"], 25.4),
            (&["ft", "foot"], 304.8),
            (&["yd", "yard"], 914.4),
            (&["mi", "mile"], 1_609_344.0),
        ] {
            for name in names {
                assert_eq!(millimetres(name), Some(expected), "{name}");
            }
        }
        for name in ["", "s", "pixel", "reference frame", "furlong", "1", "xm", "metermeter", "M"] {
            assert_eq!(millimetres(name), None, "{name}");
        }
    }
}
