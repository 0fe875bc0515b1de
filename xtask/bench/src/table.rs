//! Tables in Markdown, as the documentation takes them, and the numbers in them.

/// A table; the first column holds names.
pub(super) fn markdown(head: &[String], rows: &[Vec<String>]) -> String {
    let rule = vec!["---".to_owned(); head.len()];
    let lines = [head, &rule].into_iter().chain(rows.iter().map(Vec::as_slice));
    lines.map(|cells| format!("| {} |\n", cells.join(" | "))).collect()
}

/// Three digits that count, and all before the point.
pub(super) fn rounded(number: f64) -> String {
    let n_before = if 0.0 < number { number.log10().floor() + 1.0 } else { 1.0 };
    let n_after = (3.0 - n_before).clamp(0.0, 6.0) as usize;
    format!("{number:.n_after$}")
}

/// With a comma at each thousand.
pub(super) fn thousands(count: u64) -> String {
    let digits = count.to_string();
    let mut text = String::new();
    for (idx, digit) in digits.chars().enumerate() {
        if 0 < idx && (digits.len() - idx).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// The middle number, or the mean of the two in the middle; NaN of none.
pub(super) fn median(numbers: &[f64]) -> f64 {
    let mut sorted = numbers.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    match sorted.len() {
        0 => f64::NAN,
        n if n % 2 == 1 => sorted[middle],
        _ => f64::midpoint(sorted[middle - 1], sorted[middle]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markdown_of_two_columns() {
        let [head, row] = [["", "ms"], ["a", "1"]].map(|row| row.map(str::to_owned).to_vec());
        assert_eq!(markdown(&head, &[row]), "|  | ms |\n| --- | --- |\n| a | 1 |\n");
    }

    #[test]
    fn numbers_for_people() {
        let cases = [(0.0, "0.00"), (0.01234, "0.0123"), (1.0, "1.00"), (98.76, "98.8")];
        for (number, expected) in cases.into_iter().chain([(1234.5, "1234"), (999.6, "1000")]) {
            assert_eq!(rounded(number), expected);
        }
        for (count, expected) in [(0, "0"), (999, "999"), (1000, "1,000"), (1234567, "1,234,567")] {
            assert_eq!(thousands(count), expected);
        }
    }

    #[test]
    fn median_of_a_few() {
        for (numbers, expected) in [(&[3.0][..], 3.0), (&[4.0, 1.0], 2.5), (&[9.0, 1.0, 2.0], 2.0)]
        {
            assert_eq!(median(numbers), expected, "{numbers:?}");
        }
        assert!(median(&[]).is_nan(), "of none");
    }
}
