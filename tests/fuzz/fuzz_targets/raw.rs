//! Raw samples, described by JSON beside them or by their own name.
#![no_main]

use libfuzzer_sys::fuzz_target;
use slabsplat_fuzz::{files, parts, read_volume};
use slabsplat_io::FilesInMemory;

fuzz_target!(|input: &[u8]| {
    read_volume(&files(&["a.json", "a.raw"], input), "a.json");
    let mut parts = parts(input);
    if let (Some(name), Some(samples)) = (parts.next(), parts.next()) {
        let name = String::from_utf8_lossy(name);
        read_volume(&FilesInMemory::from_iter([(&*name, samples)]), &name);
    }
});
