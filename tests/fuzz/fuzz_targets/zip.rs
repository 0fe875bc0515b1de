//! Archives, in which a Zarr or arrays of NumPy may be.
#![no_main]

use libfuzzer_sys::fuzz_target;
use slabsplat_fuzz::{files, read_volume};

fuzz_target!(|input: &[u8]| {
    let files = files(&["a.zip"], input);
    read_volume(&files, "a.zip");
    read_volume(&files, "a.zip:0");
});
