//! Images of VTK, in XML and in the legacy format.
#![no_main]

use libfuzzer_sys::fuzz_target;
use slabsplat_fuzz::{files, read_volume};

fuzz_target!(|input: &[u8]| {
    let files = files(&["a.vti"], input);
    read_volume(&files, "a.vti");
    read_volume(&files, "a.vti:b");
});
