//! HDF5: a file, and one of its data sets.
#![no_main]

use libfuzzer_sys::fuzz_target;
use slabsplat_fuzz::{files, read_volume};

fuzz_target!(|input: &[u8]| {
    let files = files(&["a.h5"], input);
    read_volume(&files, "a.h5");
    read_volume(&files, "a.h5:packed/a");
});
