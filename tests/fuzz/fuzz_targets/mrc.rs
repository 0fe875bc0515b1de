//! MRC.
#![no_main]

use libfuzzer_sys::fuzz_target;
use slabsplat_fuzz::{files, read_volume};

fuzz_target!(|input: &[u8]| read_volume(&files(&["a.mrc"], input), "a.mrc"));
