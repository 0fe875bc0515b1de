//! The built program, run as a user runs it: what it prints, what it writes, and how it ends.

mod annotations;
mod backends;
mod batch;
mod bench;
#[cfg(feature = "viewer")]
mod browser;
mod colors;
mod compare;
mod convert;
mod demo;
mod distributed;
mod errors;
mod film;
mod gallery;
mod help;
mod info;
mod manual;
mod memory;
mod pictures;
mod popping;
mod render;
mod reproduce;
mod scene;
#[cfg(feature = "serve")]
mod serve;
#[cfg(unix)]
mod signals;
mod stdin;
mod transfer;
#[cfg(feature = "viewer")]
mod view;

use std::path::Path;
use std::process::{Command, Output, Stdio};

/// The program, to be run in `directory` with `args`, parted by blanks.
fn program(directory: &Path, args: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_slabsplat"));
    command
        .args(args.split_whitespace())
        .current_dir(directory)
        // As in a container: nothing may complain of that.
        .env_remove("XDG_RUNTIME_DIR")
        .stdin(Stdio::null());
    command
}

/// Runs the program.
fn slabsplat(directory: &Path, args: &str) -> Output {
    program(directory, args).output().expect("the program starts")
}

/// Runs the program where it must succeed, and gives what it prints.
fn answer(directory: &Path, args: &str) -> String {
    let output = slabsplat(directory, args);
    assert!(output.status.success(), "{args}: {}", text(&output.stderr));
    text(&output.stdout)
}

/// Runs the program where it must succeed with `--json`.
fn json(directory: &Path, args: &str) -> serde_json::Value {
    let text = answer(directory, args);
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{args}: {error}: {text}"))
}

/// Runs the program where it must fail as the world's fault, in one line, which is returned.
fn diagnostic(directory: &Path, args: &str) -> String {
    let output = slabsplat(directory, args);
    let stderr = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{args}: {stderr}");
    assert!(output.stdout.is_empty(), "{args}: an error does not go to stdout");
    assert_eq!(stderr.lines().count(), 1, "{args}: {stderr}");
    assert!(stderr.starts_with("error: "), "{args}: {stderr}");
    stderr
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("the program prints text")
}

/// The names of the files in a directory, sorted.
fn names_in(directory: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(directory).expect("the directory is there");
    let name = |entry: std::io::Result<std::fs::DirEntry>| {
        entry.expect("the directory can be read").file_name().to_string_lossy().into_owned()
    };
    let mut names: Vec<String> = entries.map(name).collect();
    names.sort();
    names
}
