//! Work that is odd: with nothing in it, with many small reads, polled once too often.

use super::{on_device, run, slice};
use slabsplat_gpu::{Device, Done, Slice, Work, WorkId, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};

#[test]
fn work_may_be_empty() {
    on_device(|device| {
        assert_eq!(run(device, &Work::default()), Done::default());
        let buffer = device.create_buffer("written only", 8).unwrap();
        let write = Write { buffer, offset: 4, bytes: vec![1; 4].into() };
        let done = run(device, &Work { writes: vec![write], ..Work::default() });
        assert_eq!(done, Done::default());
    });
}

#[test]
fn work_reads_in_order() {
    on_device(|device| {
        let buffer = device.create_buffer("numbers", 400).unwrap();
        let words: Vec<u32> = (0..100).map(|i| 7 * i).collect();
        let reads: Vec<Slice> =
            (0..50).map(|i| slice(buffer, 4 * ((7 * i) % 90), 4 * (1 + i % 9))).collect();
        let write = Write { buffer, offset: 0, bytes: bytemuck::cast_slice(&words).into() };
        let work = Work { writes: vec![write], reads: reads.clone(), ..Work::default() };
        let done = run(device, &work);
        assert_eq!(done.reads.len(), reads.len());
        for (read, slice) in done.reads.iter().zip(reads) {
            assert_eq!(read[..], words[slice.offset as usize / 4..][..slice.size as usize / 4]);
        }
    });
}

#[test]
fn work_is_taken_once() {
    on_device(|device| {
        let work = device.submit(&Work::default()).unwrap();
        super::wait(device, work);
        for unknown in [work, WorkId(1000)] {
            let polled = catch_unwind(AssertUnwindSafe(|| device.poll(unknown)));
            assert!(polled.is_err(), "{unknown:?}");
        }
    });
}
