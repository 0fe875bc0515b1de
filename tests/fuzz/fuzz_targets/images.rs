//! A folder of up to three images.
#![no_main]

use libfuzzer_sys::fuzz_target;
use slabsplat_fuzz::{files, read_volume};

fuzz_target!(|input: &[u8]| {
    read_volume(&files(&["a/1.png", "a/2.png", "a/10.png"], input), "a");
});
