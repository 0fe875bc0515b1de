//! Transfer functions of ParaView and of 3D Slicer. The first byte says what the name is.
#![no_main]

use libfuzzer_sys::fuzz_target;
use slabsplat_fuzz::check_message;
use slabsplat_io::parse_transfer;

fuzz_target!(|input: &[u8]| {
    let Some((first, bytes)) = input.split_first() else { return };
    let name = ["a.json", "a.vp"][usize::from(*first) % 2];
    drop(parse_transfer(&String::from_utf8_lossy(bytes), name).inspect_err(check_message));
});
