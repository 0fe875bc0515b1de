//! Without the feature a message. With it `crates/slabsplat-io/tests/hdf5.rs` has files that h5py wrote.

use crate::FilesInMemory;

#[test]
#[cfg(not(feature = "hdf5"))]
fn hdf5_is_left_out() {
    let block = [0; 4096];
    for start in [&[][..], &block[..512], &block[..1024], &block] {
        let bytes = [start, &super::MAGIC, &[0; 8]].concat();
        let files = FilesInMemory::from_iter([("a.h5", bytes.as_slice())]);
        let error = files.read_volume("a.h5:a/b").unwrap_err().to_string();
        assert!(error.contains("cargo install slabsplat-cli --features hdf5"), "{error}");
    }
    let files = FilesInMemory::from_iter([("a.nc", &b"CDF\x01"[..])]);
    let error = files.read_volume("a.nc").unwrap_err().to_string();
    assert!(error.contains("nccopy"), "{error}");
}

#[test]
#[cfg(feature = "hdf5")]
fn hdf5_that_is_cut_off() {
    let files = FilesInMemory::from_iter([("a.h5", &super::MAGIC[..])]);
    let error = files.read_volume("a.h5").unwrap_err().to_string();
    assert!(error.starts_with("a.h5: not a sound HDF5 file") && !error.contains('\n'), "{error}");
}

#[test]
fn hdf5_begins_behind_a_block_of_twice_512_bytes_and_so_on() {
    let block = [0; 4096];
    let refused = |start: &[u8]| {
        let bytes = [start, &super::MAGIC].concat();
        let files = FilesInMemory::from_iter([("a.h5", bytes.as_slice())]);
        files.read_volume("a.h5").unwrap_err().to_string()
    };
    for n_bytes in [512, 1024, 4096] {
        let error = refused(&block[..n_bytes]);
        assert!(!error.contains("does not begin as one"), "{n_bytes}: {error}");
    }
    for n_bytes in [511, 513, 1536, 3072] {
        let error = refused(&block[..n_bytes]);
        assert!(error.contains("does not begin as one"), "{n_bytes}: {error}");
    }
}
