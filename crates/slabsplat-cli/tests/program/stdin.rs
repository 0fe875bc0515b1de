//! Volumes that come by standard input.

use crate::{names_in, program, text};
use std::io::Write;
use std::path::Path;
use std::process::{Output, Stdio};

const NRRD: &[u8] = b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n\n12345678";

/// Runs the program with `bytes` on its standard input.
fn fed(directory: &Path, args: &str, bytes: &[u8]) -> Output {
    let mut command = program(directory, args);
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("the program starts");
    // A program that refuses its arguments reads nothing.
    let _ = child.stdin.take().expect("it is piped").write_all(bytes);
    child.wait_with_output().expect("the program ends")
}

fn error(directory: &Path, args: &str, bytes: &[u8]) -> String {
    let output = fed(directory, args, bytes);
    let stderr = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{args}: {stderr}");
    assert_eq!(stderr.lines().count(), 1, "{args}: {stderr}");
    stderr
}

#[test]
fn stdin_is_a_volume() {
    let dir = tempfile::tempdir().unwrap();
    for (args, expected) in [
        ("info -", "dims     2 x 2 x 2"),
        ("info - --spacing 1,2,3", "spacing  1 x 2 x 3"),
        ("info - --dims 7,5,2 --type uint8", "format   raw"),
    ] {
        let bytes = if args.contains("--dims") { &[7; 70] } else { NRRD };
        let output = fed(dir.path(), args, bytes);
        let (answer, stderr) = (text(&output.stdout), text(&output.stderr));
        assert!(output.status.success() && answer.contains(expected), "{args}: {answer} {stderr}");
    }
    let output = fed(dir.path(), "render - --width 16 --height 16 -o a.png", NRRD);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let output = fed(dir.path(), "convert - a.mha", NRRD);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert_eq!(names_in(dir.path()), ["a.mha", "a.png"]);
}

#[test]
fn stdin_errors_are_those_of_files() {
    let dir = tempfile::tempdir().unwrap();
    let detached =
        b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\ndata file: a.raw\n";
    for (args, bytes, expected) in [
        ("info -", &NRRD[..NRRD.len() - 1], "standard input: needs 8 bytes of data, has 7"),
        ("info -", b"", "standard input is not a volume file that can be read"),
        ("info -", b"some text", "--dims and --type"),
        ("info -", detached, "needs the file a.raw, which is beside no stream"),
        ("info - --channel 3", NRRD, "standard input: there is no channel 3"),
        (
            "info - --dims 2,2,2 --type uint8",
            b"123",
            "standard input: needs 8 bytes of data, has 3",
        ),
        ("render - --layer - -o a.png", NRRD, "can be read once"),
        ("render builtin:cube --labels - -o a.png", NRRD, "only volumes come by standard input"),
        ("render builtin:cube --mesh - -o a.png", NRRD, "only volumes come by standard input"),
    ] {
        let line = error(dir.path(), args, bytes);
        assert!(line.contains(expected), "{args}: {line}");
        assert!(names_in(dir.path()).is_empty(), "{args} leaves nothing behind");
    }
}
