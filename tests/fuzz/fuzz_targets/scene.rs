//! Scene files. What they name is not there. What is read is written, and read as the same.
#![no_main]

use libfuzzer_sys::fuzz_target;
use slabsplat_fuzz::check_message;
use slabsplat_io::{SceneFile, parse_scene, scene_text};

fuzz_target!(|input: &[u8]| {
    let text = String::from_utf8_lossy(input);
    let scene: Result<SceneFile, _> = parse_scene(&text, "a.toml");
    let Ok(scene) = scene.inspect_err(check_message) else { return };
    if !scene.is_fitted() {
        return;
    }
    let written = scene_text(&scene, "a.toml").expect("what was text can be text");
    let read = parse_scene(&written, "a.toml").expect("what is written can be read");
    // Texts, since what is no number does not equal itself.
    assert_eq!(scene_text(&read, "a.toml").expect("as before"), written);
});
