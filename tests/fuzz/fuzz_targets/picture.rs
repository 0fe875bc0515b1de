//! What pictures say of the scenes that they show.
#![no_main]

use libfuzzer_sys::fuzz_target;
use slabsplat_fuzz::{check_line, check_message, files};

fuzz_target!(|input: &[u8]| {
    for name in ["in/a.png", "in/a.exr", "in/a.tif", "in/a.jpg", "in/a.webp"] {
        let read = files(&[name], input).read_picture_scene(name).inspect_err(check_message);
        if let Ok(Some(picture)) = read {
            picture.program.iter().for_each(|program| check_line(program));
        }
    }
});
