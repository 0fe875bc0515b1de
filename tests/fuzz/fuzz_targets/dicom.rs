//! DICOM: a file, and a folder of up to four.
#![no_main]

use libfuzzer_sys::fuzz_target;
use slabsplat_fuzz::{files, read_volume};

fuzz_target!(|input: &[u8]| {
    let files = files(&["a/1.dcm", "a/2.dcm", "a/3.dcm", "a/4.dcm"], input);
    read_volume(&files, "a/1.dcm");
    read_volume(&files, "a");
});
