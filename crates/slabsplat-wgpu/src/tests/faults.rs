//! Devices that fail, and callers that make mistakes.

use super::{messages, on_device, open, slice};
use crate::WgpuDevice;
use slabsplat_gpu::{Device, DeviceError, Work, Write};
use std::sync::Mutex;

/// Every call reports that the device is lost, now and ever after.
fn check_lost(device: &mut WgpuDevice, work: slabsplat_gpu::WorkId) -> String {
    let mut reasons = Vec::new();
    for _ in 0..2 {
        let errors = [
            device.create_buffer("after", 16).map(drop),
            device.submit(&Work::default()).map(drop),
            device.poll(work).map(drop),
        ];
        for error in errors {
            let Err(DeviceError::Lost { reason }) = error else { panic!("{error:?}") };
            reasons.push(reason);
        }
    }
    reasons.dedup();
    assert_eq!(reasons.len(), 1, "{reasons:?}");
    reasons.remove(0)
}

#[test]
fn device_destroyed_is_lost() {
    on_device(|device| {
        let buffer = device.create_buffer("before", 16).unwrap();
        let reads = vec![slice(buffer, 0, 16)];
        let work = device.submit(&Work { reads, ..Work::default() }).unwrap();
        device.gpu.device.destroy();
        // It is lost when its last work is done.
        while device.poll(work).is_ok_and(|poll| poll.is_pending()) {}
        let reason = check_lost(device, work);
        assert!(reason.contains("Destroyed"), "{reason}");
        device.destroy_buffer(buffer);
    });
}

/// wgpu lets work that runs go on, but takes no more.
#[test]
fn device_destroyed_with_work_in_flight_is_lost() {
    // It may complain about what it cannot do any more.
    let Some(mut device) = open(|_| ()) else { return };
    let buffer = device.create_buffer("before", 64 << 20).unwrap();
    let writes = vec![Write { buffer, offset: 0, bytes: vec![1; 64 << 20].into() }];
    let reads = vec![slice(buffer, 0, 64 << 20)];
    let work = Work { writes, reads, ..Work::default() };
    let before = device.submit(&work).unwrap();
    device.gpu.device.destroy();
    let after = device.submit(&work);
    for work in std::iter::once(before).chain(after) {
        while device.poll(work).is_ok_and(|poll| poll.is_pending()) {}
    }
    check_lost(&mut device, before);
}

/// The messages of `device_told_nonsense_is_lost`, which are no diagnostics.
static EXPECTED: Mutex<Vec<String>> = Mutex::new(Vec::new());

#[test]
fn device_told_nonsense_is_lost() {
    let expect = |message: &str| EXPECTED.lock().unwrap().push(message.to_owned());
    let Some(mut device) = open(expect) else { return };
    let buffer = device.create_buffer("short", 16).unwrap();
    let good = device.submit(&Work::default()).unwrap();
    let beyond = Write { buffer, offset: 8, bytes: vec![1; 16].into() };
    let error = device.submit(&Work { writes: vec![beyond], ..Work::default() }).unwrap_err();
    assert!(matches!(error, DeviceError::Lost { .. }), "{error:?}");
    check_lost(&mut device, good);
    assert_eq!(EXPECTED.lock().unwrap().len(), 1);
    assert_eq!(messages::all(), Vec::<String>::new(), "messages of the validation");
}
