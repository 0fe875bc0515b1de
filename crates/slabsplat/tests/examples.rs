//! The examples, run as their users run them.

#[expect(dead_code, reason = "an example's `main` reads the command line")]
#[path = "../examples/own_kernel.rs"]
mod own_kernel;
#[expect(dead_code, reason = "an example's `main` reads the command line")]
#[path = "../examples/turntable.rs"]
mod turntable;

use std::path::Path;

/// The first bytes of a PNG.
fn is_png(path: &Path) -> bool {
    std::fs::read(path).is_ok_and(|bytes| bytes.starts_with(b"\x89PNG"))
}

#[test]
fn example_own_kernel_draws_a_picture() {
    let dir = tempfile::tempdir().unwrap();
    let picture = dir.path().join("a.png");
    own_kernel::draw(&picture).unwrap();
    assert!(is_png(&picture));
}

#[test]
fn example_turntable_draws_all_frames() {
    let dir = tempfile::tempdir().unwrap();
    turntable::turn(dir.path()).unwrap();
    let frames = std::fs::read_dir(dir.path()).unwrap();
    let frames = frames.map(|frame| frame.unwrap().path()).collect::<Vec<_>>();
    assert_eq!(frames.len(), 24);
    assert!(frames.iter().all(|frame| is_png(frame)));
}
