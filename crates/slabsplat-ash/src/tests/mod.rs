//! What the device promises, on whatever Vulkan device there is, under the eyes of the validation layer.

mod errors;
mod lifetimes;
mod order;
mod scan;
mod sort;

use crate::device::AshDevice;
use slabsplat_gpu::{
    BufferId, Device, Done, OpenOptions, Pass, Slice, Unavailable, Work, WorkId, Write,
};
use std::sync::{Mutex, PoisonError};
use std::task::Poll;

/// What the validation layer has said in any test.
static MESSAGES: Mutex<Vec<String>> = Mutex::new(Vec::new());

fn note_message(text: &str) {
    MESSAGES.lock().unwrap().push(text.to_owned());
}

/// Runs a test on a device, if there is one, and sees to it that the layer has nothing to say, up to
/// the device's end. One test at a time: NVIDIA's driver 580.159 has been seen to hang where sixteen threads
/// open, use and close devices of their own.
fn on_device(test: impl FnOnce(&mut AshDevice)) {
    static ONE: Mutex<()> = Mutex::new(());
    let _alone = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    let options = OpenOptions::default().validation(note_message);
    let Some(mut device) = or_skip(crate::open(&options)) else { return };
    if !device.context.instance.is_validated() {
        println!("without the validation layer, which is not installed");
    }
    test(&mut device);
    drop(device);
    // Not asserted under the lock, which the other tests need.
    let messages = MESSAGES.lock().unwrap().clone();
    assert_eq!(messages, [""; 0], "the layer says");
}

/// What was opened. Without a device the test is skipped, where that is allowed.
fn or_skip<T>(opened: Result<T, Unavailable>) -> Option<T> {
    match opened {
        Ok(device) => Some(device),
        Err(unavailable) if std::env::var_os("SLABSPLAT_REQUIRE_GPU").is_some() => {
            panic!("a device is required: {unavailable}")
        }
        Err(unavailable) => {
            println!("skipped: {unavailable}");
            None
        }
    }
}

/// Polls until work is done.
fn wait(device: &mut AshDevice, work: WorkId) -> Done {
    loop {
        if let Poll::Ready(done) = device.poll(work).unwrap() {
            return done;
        }
        std::thread::yield_now();
    }
}

fn slice(buffer: BufferId, offset: u64, size: u64) -> Slice {
    Slice { buffer, offset, size }
}

fn write(buffer: BufferId, offset: u64, words: &[u32]) -> Write<'_> {
    Write { buffer, offset, bytes: bytemuck::cast_slice(words).into() }
}

/// Begins work that only reads, and waits for it.
fn read_now(device: &mut AshDevice, reads: &[Slice]) -> Vec<Vec<u32>> {
    let work = device.submit(&Work { reads: reads.to_vec(), ..Work::default() }).unwrap();
    wait(device, work).reads
}

#[test]
fn device_can_go_to_another_thread() {
    fn assert_send<T: Send>() {}
    assert_send::<AshDevice>();
}

#[test]
fn devices_are_sorted_and_within_the_contract() {
    let Some(devices) = or_skip(crate::devices()) else { return };
    assert!(devices.is_sorted_by_key(|info| info.kind));
    for info in &devices {
        println!("{info:?}");
        assert!(info.max_binding_bytes.is_multiple_of(4) && 128 << 20 <= info.max_binding_bytes);
        assert!(info.max_buffer_bytes.is_multiple_of(4) && 128 << 20 <= info.max_buffer_bytes);
        assert!(info.offset_alignment.is_power_of_two() && info.offset_alignment <= 256);
        assert!(!info.name.is_empty() && !info.driver.is_empty());
    }
    let opened = crate::open(&OpenOptions::default()).unwrap();
    assert_eq!(opened.info(), &devices[0]);
}
