//! Rules for text: how long files are, how they open and end, and what rustfmt does not see to in shaders.

use super::{File, Finding};

/// Three times what a file should have.
const MAX_LINES: usize = 600;

/// As rustfmt does it for Rust, which leaves comments alone as well.
const MAX_SHADER_CHARS: usize = 100;

/// Comments are read beside code, at most so wide.
const MAX_COMMENT_CHARS: usize = 110;

/// Formats whose files may be written as some other program writes them.
const DATA_EXTENSIONS: &[&str] = &["csv", "hdr", "lock", "mhd", "nhdr", "nrrd", "svg"];

pub(super) fn too_long(file: &File) -> Vec<Finding> {
    let n_lines = handwritten(file).map_or(0, |text| text.lines().count());
    if n_lines <= MAX_LINES {
        return Vec::new();
    }
    let advice = "some 200 are good, and one subject: split it";
    vec![file.finding(format!("{n_lines} lines, {MAX_LINES} is the cap; {advice}"))]
}

/// Lines end in what can be seen, and then LF; so does the last.
pub(super) fn untidy_end(file: &File) -> Vec<Finding> {
    let Some(text) = handwritten(file) else { return Vec::new() };
    let is_bad = |line: &str| line.ends_with([' ', '\t', '\r']);
    let mut findings = file.bad_lines(text, is_bad, "space, tab or CR at the end of the line");
    if !text.is_empty() && !text.ends_with('\n') {
        findings.push(file.finding("no newline at the end of the file"));
    }
    findings
}

/// The compiler asks for the documentation of a crate, not for that of a module, a test or a shader.
pub(super) fn header(file: &File) -> Vec<Finding> {
    let opening = match file.extension() {
        "rs" => "//! ",
        "wgsl" => "// ",
        _ => return Vec::new(),
    };
    if file.text.as_deref().is_some_and(|text| text.starts_with(opening)) {
        return Vec::new();
    }
    let message = format!("must open with `{opening}`: what this is, why, what it does not do");
    vec![file.finding_at(1, message)]
}

pub(super) fn wide_shader(file: &File) -> Vec<Finding> {
    let Some(text) = file.text_if("wgsl") else { return Vec::new() };
    let is_bad = |line: &str| {
        let code = line.split("//").next().unwrap_or_default();
        MAX_SHADER_CHARS < code.trim_end().chars().count()
    };
    file.bad_lines(text, is_bad, "over 100 characters of code")
}

/// rustfmt breaks code, and leaves comments as they are.
pub(super) fn wide_comment(file: &File) -> Vec<Finding> {
    let Some(text) = file.text_if("rs") else { return Vec::new() };
    let is_bad = |line: &str| {
        let line = line.trim_end();
        // A row of a table stays one line.
        let is_row = line.trim_start().trim_start_matches(['/', '!', ' ']).starts_with('|');
        line.trim_start().starts_with("//") && !is_row && MAX_COMMENT_CHARS < line.chars().count()
    };
    file.bad_lines(text, is_bad, "a comment of over 110 characters")
}

/// Work left over names the issue in which it will be done.
pub(super) fn bare_todo(file: &File) -> Vec<Finding> {
    let text = handwritten(file).filter(|_| !file.path.starts_with("xtask/src/tidy/"));
    let Some(text) = text else { return Vec::new() };
    let is_bad = |line: &str| line.replace("TODO(#", "").contains("TODO") || line.contains("FIXME");
    file.bad_lines(text, is_bad, "work left over must name its issue: `TODO(#12): what is left`")
}

/// The text of a file that people write.
fn handwritten(file: &File) -> Option<&str> {
    file.text.as_deref().filter(|_| !DATA_EXTENSIONS.contains(&file.extension()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The lines that `rule` finds in a file of that name and content, 0 where the whole file is meant.
    fn check(rule: fn(&File) -> Vec<Finding>, path: &str, content: &str, expected: &[usize]) {
        let file = File::new(path, content.as_bytes().to_vec());
        let lines: Vec<usize> = rule(&file).iter().map(|found| found.line.unwrap_or(0)).collect();
        assert_eq!(lines, expected, "{path} with {content:?}");
    }

    #[test]
    fn too_long_cap() {
        check(too_long, "a.rs", &"\n".repeat(MAX_LINES), &[]);
        check(too_long, "a.rs", &"\n".repeat(MAX_LINES + 1), &[0]);
        check(too_long, "Cargo.lock", &"\n".repeat(2000), &[]);
    }

    #[test]
    fn untidy_end_of_lines_and_files() {
        check(untidy_end, "a.toml", "a = 1\nb = 2 \n\t\nc\n", &[2, 3]);
        check(untidy_end, "a.md", "a\nb\r\nc", &[2, 0]);
        check(untidy_end, "a.nhdr", "a\r\n", &[]);
        check(untidy_end, "a", "", &[]);
    }

    #[test]
    fn header_missing() {
        check(header, "a.rs", "//! A\n", &[]);
        check(header, "a.rs", "// A\n", &[1]);
        check(header, "a.rs", "", &[1]);
        check(header, "a.wgsl", "// A\n", &[]);
        check(header, "a.wgsl", "//#include \"b.wgsl\"\n", &[1]);
        check(header, "a.sh", "a\n", &[]);
    }

    #[test]
    fn wide_shader_code() {
        let wide = "é".repeat(100);
        let source = format!("{wide}\n{wide} // comment\n// {wide}\n{wide};\n");
        check(wide_shader, "a.wgsl", &source, &[4]);
        check(wide_shader, "a.rs", &source, &[]);
    }

    #[test]
    fn wide_comments() {
        let (wide, row) = ("é".repeat(108), format!("| {} |", "é".repeat(120)));
        let source =
            format!("// {wide}\n//{wide}\nlet a = \"{wide}{wide}\"; // {wide}\n//! {row}\n");
        check(wide_comment, "a.rs", &source, &[1]);
    }

    #[test]
    fn bare_todo_spellings() {
        check(bare_todo, "a.sh", "# TODO: later\n# TODO(#12): later\n# FIXME\n# to do\n", &[1, 3]);
        check(bare_todo, "a.rs", "// TODO(me): later\n", &[1]);
    }
}
