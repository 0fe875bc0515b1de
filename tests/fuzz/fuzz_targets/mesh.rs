//! Meshes: PLY, STL, OBJ. The first byte says what the name is.
#![no_main]

use libfuzzer_sys::fuzz_target;
use slabsplat_fuzz::{check_message, files};

fuzz_target!(|input: &[u8]| {
    let Some((first, bytes)) = input.split_first() else { return };
    let name = ["a.ply", "a.stl", "a.obj"][usize::from(*first) % 3];
    drop(files(&[name], bytes).read_mesh(name).inspect_err(check_message));
});
