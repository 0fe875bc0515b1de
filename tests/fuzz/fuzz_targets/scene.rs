//! Scene files. What they name is not there.
#![no_main]

use libfuzzer_sys::fuzz_target;
use slabsplat_fuzz::check_message;
use slabsplat_io::{SceneFile, parse_scene};

fuzz_target!(|input: &[u8]| {
    let text = String::from_utf8_lossy(input);
    let scene: Result<SceneFile, _> = parse_scene(&text, "nowhere/a.toml");
    drop(scene.inspect_err(check_message));
});
