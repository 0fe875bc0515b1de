//! Buffers that c-blosc made, by numcodecs 0.16: 300 items of 16 bits in blocks of 512 bytes.

use std::io::Read;

use super::blosc::Blosc;

/// How each was packed and shuffled, and its bytes.
const BUFFERS: &[(&str, &str)] = &[
    (
        "blosclz, bytes",
        "0201010258020000580200006800000014000000340000002900010203040506070809e0200909020406080a0c0e1012\
         00e01f09090306090c0f1215181b00e01f0902010203e0879501181b180000002300000000e05603010001e059000101\
         02e0570002020202",
    ),
    (
        "blosclz, bits",
        "020104025802000058020000ae0000001400000049000000330000010002000300040005000600070008000900e04913\
         1102000400060008000a000c000e0010001200e0481313010301060109010c010f011201150118011b0100e04413011b\
         0149000000330001010102010301040105010601070108010901e04813130202020402060208020a020c020e02100212\
         0200e04813110302060209020c020f021202150218021b02e04513011b02",
    ),
    (
        "lz4, bytes",
        "020121025802000058020000630000001400000032000000af000102030405060708090a00169f020406080a0c0e1012\
         0a00169f0306090c0f1215181b0a00160f96007d500f1215181b150000001f000100501f010100501f0201004b500202\
         020202",
    ),
    (
        "lz4, bits",
        "020124025802000058020000b6000000140000004d000000ff0500000100020003000400050006000700080009001400\
         3fff0202000400060008000a000c000e0010001214003fff04010301060109010c010f011201150118011b0114003850\
         0118011b014d000000ff05000101010201030104010501060107010801090114003eff040202020402060208020a020c\
         020e021002120214003fff020302060209020c020f021202150218021b140039500218021b02",
    ),
    (
        "zlib, bytes",
        "0201610258020000580200005c000000140000002e00000078da6360646266616563e7e0642096c5c4c2c6c1c5c32720\
         44348b998d93875f4854429a68d6a074150071a70a8d1200000078da6360a03d60a40360a2030000636a012d",
    ),
    (
        "zlib, bits",
        "02016402580200005802000095000000140000003d00000078daadc8d109803010c0d0a4d5d34a51290882fbef6987b8\
         bfe481142a0b2bc1c64e83742bf363f641e7e466e49bd5b0d9bd1c3ebe7e66db0f643a05793c00000078daadc8c10980\
         301000c1ec26c64444451004fbefd32be29e3305904a63a1b3329894ec539bdde1e6eee1e56dfed598193e438faf5ffa\
         fdd96a0641",
    ),
    (
        "zstd, bytes",
        "0201910258020000000200007d000000180000005c0000004000000028b52ffd600001b5010004020001020304050607\
         0809020406080a0c0e10120306090c0f1215181b0001020207000327029032f05231999702003a0074142a481d000000\
         28b52ffd2058a50000601215181b000306090c0f020202005d08d72948",
    ),
    (
        "zstd, bits",
        "020194025802000000020000c000000018000000970000007b00000028b52ffd6000018d03005404aa0200a0aa00a8cc\
         30c30c33cca8aa6aa699669a692633aa9af0c0030f3cf030430b2db4d0420b3cccd000030c30c000c3c08333ce38e38c\
         33c0f0e000030c00000300f0ff17a080ce51dc0e0039ed3ca3284462891321ad5497fd5868c3371b4bf23a42b760897b\
         306f8db308cf042500000028b52ffd2058e50000a81202150218021b0200020302060209020c020f02120100e1d0c904",
    ),
];

fn bytes_of(hex: &str) -> Vec<u8> {
    let digit = |at: usize| u8::from_str_radix(&hex[at..at + 2], 16).unwrap();
    (0..hex.len()).step_by(2).map(digit).collect()
}

fn items() -> Vec<u8> {
    let item = |i: u16| i % 10 * (i / 50 % 3 + 1) + i / 100 * 256;
    (0..300).flat_map(|i| item(i).to_le_bytes()).collect()
}

fn unpacked(packed: &[u8]) -> Result<Vec<u8>, std::io::Error> {
    let mut bytes = Vec::new();
    Blosc::open(packed.to_vec(), 600)?.read_to_end(&mut bytes)?;
    Ok(bytes)
}

#[test]
fn blosc_of_every_codec() {
    for (name, hex) in BUFFERS {
        assert_eq!(unpacked(&bytes_of(hex)).unwrap(), items(), "{name}");
    }
    let copied = [&[2, 1, 2, 2][..], &[88, 2, 0, 0, 0, 2, 0, 0, 104, 2, 0, 0], &items()].concat();
    assert_eq!(unpacked(&copied).unwrap(), items());
    assert_eq!(Blosc::open(copied, 601).err().unwrap().kind(), std::io::ErrorKind::InvalidData);
}

/// Whatever is in a buffer, it is unpacked to no more than it should be, or refused.
#[test]
fn blosc_survives_what_is_broken() {
    slabsplat_seeds::for_each_seed(30, |mut rng| {
        for (name, hex) in BUFFERS {
            let mut packed = bytes_of(hex);
            for _ in 0..rng.usize(1..4) {
                let at = rng.usize(0..packed.len());
                packed[at] = rng.u8(..);
            }
            packed.truncate(rng.usize(packed.len() / 2..packed.len() * 2));
            if let Ok(bytes) = unpacked(&packed) {
                assert!(bytes.len() <= 600, "{name}");
            }
        }
    });
}
