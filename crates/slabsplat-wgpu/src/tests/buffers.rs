//! Buffers: what is in them, how large they may be, and writes of any length.

use super::{on_device, run, slice};
use crate::upload::PIECE_BYTES;
use slabsplat_gpu::{Device, DeviceError, Work, Write};

#[test]
fn buffer_begins_as_zeros() {
    on_device(|device| {
        // The second has, as likely as not, the memory of the first.
        for _ in 0..2 {
            let buffer = device.create_buffer("zeros", 10_000).unwrap();
            let ones = Write { buffer, offset: 5000, bytes: vec![1; 8].into() };
            let reads = vec![slice(buffer, 0, 10_000)];
            let done = run(device, &Work { writes: vec![ones], reads, ..Work::default() });
            let mut expected = vec![0; 2500];
            expected[1250..1252].fill(0x0101_0101);
            assert_eq!(done.reads, [expected]);
            device.destroy_buffer(buffer);
        }
    });
}

#[test]
fn buffer_takes_more_than_a_piece() {
    on_device(|device| {
        let n_bytes = 3 * PIECE_BYTES + 4096;
        let words: Vec<u32> = (0..n_bytes as u32 / 4).collect();
        let buffer = device.create_buffer("large", 8 + n_bytes as u64).unwrap();
        // The last of two writes to an offset is the one that counts, whatever their pieces.
        let writes = vec![
            Write { buffer, offset: 0, bytes: vec![9; 8 + PIECE_BYTES].into() },
            Write { buffer, offset: 8, bytes: bytemuck::cast_slice(&words).into() },
            Write { buffer, offset: 4, bytes: vec![7; 4].into() },
        ];
        let reads = vec![slice(buffer, 0, 8 + n_bytes as u64)];
        let done = run(device, &Work { writes, reads, ..Work::default() });
        assert_eq!(done.reads[0][..2], [0x0909_0909, 0x0707_0707]);
        assert!(done.reads[0][2..] == words, "some of {n_bytes} bytes are wrong");
    });
}

#[test]
fn buffer_too_large_is_out_of_memory() {
    on_device(|device| {
        for bytes in [device.info().max_buffer_bytes + 4, 1 << 60] {
            let error = device.create_buffer("too large", bytes).unwrap_err();
            assert_eq!(error, DeviceError::OutOfMemory { bytes });
        }
        let buffer = device.create_buffer("small", 4).unwrap();
        let write = Write { buffer, offset: 0, bytes: bytemuck::bytes_of(&1234).to_vec().into() };
        let reads = vec![slice(buffer, 0, 4)];
        let done = run(device, &Work { writes: vec![write], reads, ..Work::default() });
        assert_eq!(done.reads, [[1234]]);
    });
}
