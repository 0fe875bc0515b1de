//! Options of the kinds of benchmark: counts by name, and nothing else.

use std::ffi::OsString;

/// Sets each count that `args` name, as `--frames 12`.
pub(super) fn parse_counts(
    args: &[OsString],
    counts: &mut [(&str, &mut usize)],
) -> Result<(), String> {
    let mut args = args.iter().map(|arg| arg.to_string_lossy());
    while let Some(name) = args.next() {
        let Some((_, count)) = counts.iter_mut().find(|(known, _)| *known == name) else {
            let known: Vec<&str> = counts.iter().map(|(known, _)| *known).collect();
            return Err(format!("`{name}` is none of {}", known.join(", ")));
        };
        let value = args.next().ok_or(format!("`{name}` needs a number"))?;
        **count = value
            .parse()
            .ok()
            .filter(|number| 0 < *number)
            .ok_or(format!("`{name}` needs a number from 1 on, not `{value}`"))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(args: &str, expected: Result<[usize; 2], &str>) {
        let args: Vec<OsString> = args.split_whitespace().map(OsString::from).collect();
        let (mut a, mut b) = (1, 2);
        let result = parse_counts(&args, &mut [("--a", &mut a), ("--b", &mut b)]);
        assert_eq!(result.map(|()| [a, b]), expected.map_err(str::to_owned), "{args:?}");
    }

    #[test]
    fn parse_counts_by_name() {
        check("", Ok([1, 2]));
        check("--b 30", Ok([1, 30]));
        check("--b 30 --a 4", Ok([4, 30]));
        check("--c 1", Err("`--c` is none of --a, --b"));
        check("--a", Err("`--a` needs a number"));
        check("--a 0", Err("`--a` needs a number from 1 on, not `0`"));
        check("--a many", Err("`--a` needs a number from 1 on, not `many`"));
    }
}
