//! Arrays of NumPy, alone and in archives.
#![no_main]

use libfuzzer_sys::fuzz_target;
use slabsplat_fuzz::{files, read_volume};

fuzz_target!(|input: &[u8]| {
    let files = files(&["a.npy"], input);
    read_volume(&files, "a.npy");
    read_volume(&files, "a.npy:a");
});
