//! Rules for shaders: what rustfmt and rustc see to in Rust, and where entry points may stand.
//!
//! That a stage, which is a file directly in `shaders/`, has one entry point called as the file is not judged here: the
//! build script of `slabsplat-shaders` refuses it otherwise.
//! It cannot see what no stage includes.

use super::rust_text::{is_word, split};
use super::{File, Finding};

/// As rustfmt does it for Rust, which leaves comments alone as well.
const MAX_CODE_CHARS: usize = 100;

pub(super) fn header(file: &File) -> Vec<Finding> {
    match file.text_if("wgsl") {
        Some(text) if !text.starts_with("// ") => {
            vec![file.finding_at(1, "must open with `//`: its role, and what it reads and writes")]
        }
        _ => Vec::new(),
    }
}

pub(super) fn long_line(file: &File) -> Vec<Finding> {
    let Some(text) = file.text_if("wgsl") else { return Vec::new() };
    let is_bad = |line: &str| MAX_CODE_CHARS < line.trim_end().chars().count();
    // WGSL has the comments of Rust.
    file.bad_lines(&split(text).code, is_bad, &format!("over {MAX_CODE_CHARS} characters of code"))
}

/// What is shared is included by stages, and a stage has an entry point of its own.
pub(super) fn shared_entry_point(file: &File) -> Vec<Finding> {
    let text = file.text_if("wgsl").filter(|_| file.path.starts_with("shaders/shared/"));
    let Some(text) = text else { return Vec::new() };
    let message = "no entry point in shared code: it belongs to a stage, directly in `shaders/`";
    file.bad_lines(&split(text).code, has_stage_attribute, message)
}

fn has_stage_attribute(line: &str) -> bool {
    line.split('@').skip(1).any(|after| {
        let name = after.trim_start();
        let name = &name[..name.find(|c| !is_word(c)).unwrap_or(name.len())];
        matches!(name, "compute" | "vertex" | "fragment")
    })
}

#[cfg(test)]
mod tests {
    use super::super::{NONE, lines_found};
    use super::*;

    #[test]
    fn header_missing() {
        assert_eq!(lines_found(header, "shaders/a.wgsl", "// A\n"), NONE, "there");
        assert_eq!(lines_found(header, "shaders/a.wgsl", "const A = 1;\n"), [1], "code");
        assert_eq!(
            lines_found(header, "shaders/a.wgsl", "//#include \"b.wgsl\"\n"),
            [1],
            "include"
        );
        assert_eq!(lines_found(header, "a.sh", "a\n"), NONE, "no shader");
    }

    #[test]
    fn long_line_of_code() {
        let wide = "é".repeat(100);
        let source = format!("{wide}\n{wide} // comment\n// {wide}\n{wide};\n");
        assert_eq!(lines_found(long_line, "shaders/a.wgsl", &source), [4], "code only");
        assert_eq!(lines_found(long_line, "a.rs", &source), NONE, "rustfmt's");
    }

    #[test]
    fn shared_entry_point_kinds() {
        let source = "// @compute\n@compute @workgroup_size(64)\nfn a(@builtin(b) c: u32) {}\n\
                      @workgroup_size(1) @ vertex\n@computed\n@fragment\n";
        let check = |path: &str| lines_found(shared_entry_point, path, source);
        assert_eq!(check("shaders/shared/a.wgsl"), [2, 4, 6], "attributes, not comments");
        assert_eq!(check("shaders/a.wgsl"), NONE, "a stage");
    }
}
