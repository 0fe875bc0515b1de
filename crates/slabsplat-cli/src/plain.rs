//! Numbers as people write them.

/// Six digits after the point, without trailing zeros; exponents only where that says nothing.
pub(crate) fn plain(value: f64) -> String {
    let is_tiny = value != 0.0 && value.abs() < 1e-4;
    if is_tiny || (value.is_finite() && 1e12 <= value.abs()) {
        return format!("{value:e}");
    }
    let text = format!("{value:.6}");
    if !text.contains('.') {
        return text;
    }
    match text.trim_end_matches('0').trim_end_matches('.') {
        "-0" => "0".to_owned(),
        trimmed => trimmed.to_owned(),
    }
}

/// How many there are: `1 frame`, `2 frames`.
pub(crate) fn counted(n: usize, what: &str) -> String {
    if n == 1 { format!("1 {what}") } else { format!("{n} {what}s") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counted_things() {
        let said = [0, 1, 2].map(|n| counted(n, "frame"));
        assert_eq!(said, ["0 frames", "1 frame", "2 frames"]);
    }

    #[test]
    fn plain_numbers() {
        for (value, expected) in [
            (0.0, "0"),
            (-0.0, "0"),
            (1.5, "1.5"),
            (-255.0, "-255"),
            (0.1 + 0.2, "0.3"),
            (1e-7, "1e-7"),
            (2e20, "2e20"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(plain(value), expected);
        }
    }
}
