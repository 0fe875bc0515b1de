//! MetaImage: a header, or one with its data, and up to three files that it may name.
#![no_main]

use libfuzzer_sys::fuzz_target;
use slabsplat_fuzz::{files, read_volume};

fuzz_target!(|input: &[u8]| {
    read_volume(&files(&["a.mhd", "a.raw", "slice01.raw", "slice02.raw"], input), "a.mhd");
});
