//! Tests on whatever device there is, with validation. A device that is missing is no failure, unless
//! `SLABSPLAT_REQUIRE_GPU` is set.

mod buffers;
mod caller;
mod faults;
mod messages;
mod scan;
mod targets;
mod work;

use crate::WgpuDevice;
use slabsplat_gpu::{BufferId, Device, Done, OpenOptions, Slice, Work, WorkId};
use std::task::Poll;
use std::time::{Duration, Instant};

/// Runs a test on a device of its own, on which validation must find nothing.
fn on_device(test: impl FnOnce(&mut WgpuDevice)) {
    if let Some(mut device) = open(messages::collect) {
        test(&mut device);
        drop(device);
        assert_eq!(messages::all(), Vec::<String>::new(), "messages of the validation");
    }
}

/// The device, or why there is none.
fn open(validation: fn(&str)) -> Option<WgpuDevice> {
    messages::install();
    match crate::open(&OpenOptions::default().validation(validation)) {
        Ok(device) => Some(device),
        Err(none) if std::env::var_os("SLABSPLAT_REQUIRE_GPU").is_some() => panic!("{none}"),
        Err(none) => {
            println!("skipped: {none}");
            None
        }
    }
}

/// Polls until work is done.
fn wait(device: &mut WgpuDevice, work: WorkId) -> Done {
    let begin = Instant::now();
    loop {
        if let Poll::Ready(done) = device.poll(work).unwrap() {
            return done;
        }
        assert!(begin.elapsed() < Duration::from_secs(60), "the device hangs");
        std::thread::sleep(Duration::from_micros(100));
    }
}

fn run(device: &mut WgpuDevice, work: &Work<'_>) -> Done {
    let id = device.submit(work).unwrap();
    wait(device, id)
}

fn slice(buffer: BufferId, offset: u64, size: u64) -> Slice {
    Slice { buffer, offset, size }
}

#[test]
fn devices_begin_with_the_one_that_opens() {
    on_device(|device| {
        let devices = crate::devices().unwrap();
        assert_eq!(&devices[0], device.info());
        assert!(devices.is_sorted_by_key(|info| info.kind), "{devices:?}");
    });
}

#[test]
fn device_has_sound_limits() {
    on_device(|device| {
        let info = device.info();
        println!("{info:?}");
        assert!(!info.name.is_empty());
        assert!(info.offset_alignment.is_power_of_two() && info.offset_alignment <= 256);
        assert!(info.max_binding_bytes.is_multiple_of(4));
        assert!((128 << 20) <= info.max_binding_bytes, "what WebGPU promises");
        assert!(info.max_binding_bytes <= info.max_buffer_bytes);
    });
}
