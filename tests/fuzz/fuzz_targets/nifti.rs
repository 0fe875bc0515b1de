//! NIfTI-1 and -2 in one file, and pairs, which Analyze 7.5 has, too.
#![no_main]

use libfuzzer_sys::fuzz_target;
use slabsplat_fuzz::{files, read_volume};

fuzz_target!(|input: &[u8]| {
    read_volume(&files(&["a.hdr", "a.img"], input), "a.hdr");
});
