//! Zarr in a folder: metadata of the image and of one level, and two chunks.
#![no_main]

use libfuzzer_sys::fuzz_target;
use slabsplat_fuzz::{files, read_volume};

const NAMES: &[&str] = &["a.zarr/.zattrs", "a.zarr/0/.zarray", "a.zarr/0/0.0.0", "a.zarr/0/0.0.1"];

const NAMES_3: &[&str] =
    &["a.zarr/zarr.json", "a.zarr/0/zarr.json", "a.zarr/0/c/0/0/0", "a.zarr/0/c/0/0/1"];

fuzz_target!(|input: &[u8]| {
    let is_3 = input.first() == Some(&b'3');
    let names = if is_3 { NAMES_3 } else { NAMES };
    read_volume(&files(names, input.get(1..).unwrap_or_default()), "a.zarr");
});
