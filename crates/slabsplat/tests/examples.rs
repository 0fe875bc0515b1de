//! The examples, run as their users run them.

#[expect(dead_code, reason = "an example's `main` reads the command line")]
#[path = "../examples/guide_figures.rs"]
mod guide_figures;
#[expect(dead_code, reason = "an example's `main` reads the command line")]
#[path = "../examples/own_backend.rs"]
mod own_backend;
#[cfg(feature = "wgpu")]
#[expect(dead_code, reason = "an example's `main` reads the command line")]
#[path = "../examples/own_device.rs"]
mod own_device;
#[expect(dead_code, reason = "an example's `main` reads the command line")]
#[path = "../examples/own_kernel.rs"]
mod own_kernel;
#[cfg(feature = "film")]
#[expect(dead_code, reason = "an example's `main` reads the command line")]
#[path = "../examples/turntable.rs"]
mod turntable;

use std::path::Path;

/// The first bytes of a PNG.
fn is_png(path: &Path) -> bool {
    std::fs::read(path).is_ok_and(|bytes| bytes.starts_with(b"\x89PNG"))
}

#[test]
fn examples_draw_a_picture() {
    let dir = tempfile::tempdir().unwrap();
    for (name, draw) in
        [("backend.png", own_backend::draw as fn(&Path) -> _), ("kernel.png", own_kernel::draw)]
    {
        let picture = dir.path().join(name);
        draw(&picture).unwrap();
        assert!(is_png(&picture), "{name}");
    }
}

/// Where there is no device for it, as on a machine without drivers, there is nothing to be drawn on.
#[cfg(feature = "wgpu")]
#[test]
fn example_own_device_draws_a_picture() {
    let dir = tempfile::tempdir().unwrap();
    let picture = dir.path().join("device.png");
    match own_device::draw(&picture) {
        Ok(()) => assert!(is_png(&picture)),
        Err(none) if std::env::var_os("SLABSPLAT_REQUIRE_GPU").is_some() => panic!("{none}"),
        Err(none) => println!("skipped: {none}"),
    }
}

/// Those in the guide are the program's, but for what rounding does on another machine.
#[test]
fn example_guide_figures_are_those_of_the_guide() {
    let dir = tempfile::tempdir().unwrap();
    guide_figures::draw(dir.path()).unwrap();
    let guide = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/guide/src/figures");
    for name in ["sections.png", "sheets.png", "popping.png"] {
        let [drawn, kept] =
            [dir.path(), &guide].map(|dir| image::open(dir.join(name)).unwrap().into_rgba8());
        assert_eq!(drawn.dimensions(), kept.dimensions(), "{name}");
        let most = drawn.iter().zip(kept.iter()).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(most <= Some(3), "{name}: {most:?}");
    }
}

#[cfg(feature = "film")]
#[test]
fn example_turntable_draws_all_frames() {
    let dir = tempfile::tempdir().unwrap();
    let film = dir.path().join("a.png-sequence");
    turntable::turn(&film).unwrap();
    let frames = std::fs::read_dir(&film).unwrap();
    let frames = frames.map(|frame| frame.unwrap().path()).collect::<Vec<_>>();
    assert_eq!(frames.len(), 48);
    assert!(frames.iter().all(|frame| is_png(frame)));
}
