//! Words and numbers of files that are text, whatever bytes their names and comments have.

/// The words of a line, parted by blanks.
pub(super) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

/// A number, maybe NaN or infinite.
pub(super) fn number(word: &[u8]) -> Result<f64, String> {
    let number = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
    number.ok_or_else(|| format!("{} is not a number", quoted(word)))
}

/// The next so many numbers.
pub(super) fn numbers<'a, const N: usize>(
    words: &mut impl Iterator<Item = &'a [u8]>,
) -> Result<[f64; N], String> {
    let mut numbers = [0.0; N];
    for (idx, it) in numbers.iter_mut().enumerate() {
        *it = number(words.next().ok_or_else(|| format!("{N} numbers are needed, not {idx}"))?)?;
    }
    Ok(numbers)
}

/// A word as a message can have it.
pub(super) fn quoted(word: &[u8]) -> String {
    const LONGEST: usize = 40;
    let text = String::from_utf8_lossy(&word[..word.len().min(LONGEST)]);
    format!("{text:?}{}", if LONGEST < word.len() { " …" } else { "" })
}
