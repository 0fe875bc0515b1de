//! What happens when there is no memory, no device any more, or a mistake.

use super::scan::{Scan, assert_sums};
use super::*;
use crate::error::Fault;
use crate::memory::BufferDesc;
use crate::submit::PIECE_BYTES;
use crate::timeline::ForcedAnswer;
use ash::vk;
use slabsplat_gpu::DeviceError;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Duration;

#[test]
fn memory_runs_out_for_too_large_a_buffer() {
    on_device(|device| {
        let scan = Scan::new(device, 100);
        let bytes = device.info().max_buffer_bytes + 4;
        let refused = device.create_buffer("too large", bytes);
        assert_eq!(refused, Err(DeviceError::OutOfMemory { bytes }));
        let work = device.submit(&scan.work(&[7; 100])).unwrap();
        assert_sums(&wait(device, work), &[7; 100]);
    });
}

/// Lets the driver fail once.
fn force(device: &AshDevice, function: &'static str, n_calls_before: u32, result: vk::Result) {
    device.timeline.forced.set(Some(ForcedAnswer { function, n_calls_before, result }));
}

#[test]
fn memory_runs_out_and_comes_back() {
    on_device(|device| {
        let scan = Scan::new(device, 100);
        for function in ["vkGetSemaphoreCounterValue", "vkQueueSubmit"] {
            // Memory is made free, and the work begins after all.
            force(device, function, 0, vk::Result::ERROR_OUT_OF_DEVICE_MEMORY);
            let work = device.submit(&scan.work(&[7; 100])).unwrap();
            assert_sums(&wait(device, work), &[7; 100]);
            assert!(device.timeline.forced.get().is_none(), "{function} was called");
        }
        let work = device.submit(&Work::default()).unwrap();
        force(device, "vkGetSemaphoreCounterValue", 0, vk::Result::ERROR_OUT_OF_HOST_MEMORY);
        let refused = device.poll(work);
        assert!(matches!(refused, Err(DeviceError::OutOfMemory { .. })), "{refused:?}");
        assert_eq!(wait(device, work), Done::default());
    });
}

/// What has begun cannot be undone, so the device cannot be what it was before.
#[test]
fn memory_runs_out_halfway() {
    on_device(|device| {
        let long = vec![1; PIECE_BYTES as usize / 4 + 1];
        let buffer = device.create_buffer("long", PIECE_BYTES + 4).unwrap();
        let work = Work { writes: vec![write(buffer, 0, &long)], ..Work::default() };
        force(device, "vkQueueSubmit", 1, vk::Result::ERROR_OUT_OF_DEVICE_MEMORY);
        assert!(is_lost(&device.submit(&work)));
        assert!(is_lost(&device.submit(&Work::default())), "and again");
    });
}

fn is_lost<T>(result: &Result<T, DeviceError>) -> bool {
    matches!(result, Err(DeviceError::Lost { .. }))
}

#[test]
fn lost_device_stays_lost() {
    on_device(|device| {
        let scan = Scan::new(device, 100);
        let work = device.submit(&scan.work(&[7; 100])).unwrap();
        force(device, "vkGetSemaphoreCounterValue", 0, vk::Result::ERROR_DEVICE_LOST);
        assert!(is_lost(&device.poll(work)));
        assert!(is_lost(&device.poll(work)), "and again");
        assert!(is_lost(&device.submit(&scan.work(&[8; 100]))));
        assert!(is_lost(&device.create_buffer("late", 4)));
        device.destroy_buffer(scan.elements.buffer);
    });
}

#[test]
fn lost_device_is_noticed_by_submit() {
    for function in ["vkQueueSubmit", "vkWaitSemaphores"] {
        on_device(|device| {
            let scan = Scan::new(device, 100);
            force(device, function, 0, vk::Result::ERROR_DEVICE_LOST);
            // Enough to have to wait, unless the device is fast.
            let lost = (0..1000).find_map(|_| device.submit(&scan.work(&[7; 100])).err());
            let reason = lost.map(|lost| lost.to_string()).unwrap_or_default();
            assert!(
                reason.starts_with(&format!("the device was lost: {function}"))
                    || device.timeline.forced.get().is_some(),
                "{reason}"
            );
        });
    }
}

#[test]
fn mistakes_of_the_caller_panic() {
    on_device(|device| {
        let scan = Scan::new(device, 100);
        let buffer = device.create_buffer("small", 16).unwrap();
        let gone = device.create_buffer("gone", 16).unwrap();
        device.destroy_buffer(gone);
        let mut misbound = scan.passes.clone();
        misbound[0].bindings[1].size += 4;
        let mut unbound = scan.passes.clone();
        unbound[1].bindings.pop();
        let mut empty = scan.passes.clone();
        empty[0].groups[1] = 0;
        let mistakes = [
            Work { writes: vec![write(buffer, 12, &[1, 2])], ..Work::default() },
            Work { reads: vec![slice(buffer, 0, 20)], ..Work::default() },
            Work { reads: vec![slice(buffer, 2, 4)], ..Work::default() },
            Work { reads: vec![slice(gone, 0, 4)], ..Work::default() },
            Work { passes: misbound.into(), ..Work::default() },
            Work { passes: unbound.into(), ..Work::default() },
            Work { passes: empty.into(), ..Work::default() },
        ];
        for mistake in &mistakes {
            let panic = catch_unwind(AssertUnwindSafe(|| device.submit(mistake))).unwrap_err();
            let text = panic.downcast_ref::<String>().expect("a formatted message");
            assert!(text.starts_with("usage: "), "{text}");
        }
        let work = device.submit(&scan.work(&[7; 100])).unwrap();
        assert_sums(&wait(device, work), &[7; 100]);
    });
}

/// That the layer says nothing in the other tests means something only if it is heard.
#[test]
fn validation_is_heard() {
    static HEARD: Mutex<Vec<String>> = Mutex::new(Vec::new());
    fn hear(text: &str) {
        HEARD.lock().unwrap().push(text.to_owned());
    }
    let opened = crate::open(&OpenOptions::default().validation(hear));
    let Some(device) = or_skip(opened) else { return };
    if !device.context.instance.is_validated() {
        println!("skipped: the validation layer is not installed");
        return;
    }
    let memory = crate::memory::Memory::new(&device.context).unwrap();
    // Buffers of no size are forbidden.
    let location = gpu_allocator::MemoryLocation::GpuOnly;
    let usage = vk::BufferUsageFlags::STORAGE_BUFFER;
    let _ = memory.buffer(BufferDesc { label: "empty", size: 0, usage, location });
    let heard = HEARD.lock().unwrap();
    assert!(heard.iter().any(|text| text.contains("VUID-VkBufferCreateInfo-size")), "{heard:?}");
}

/// A driver that never answers is not waited for without end.
#[test]
fn silent_driver_is_given_up() {
    on_device(|device| {
        let work = device.submit(&Work::default()).unwrap();
        let number = device.timeline.last();
        force(device, "vkWaitSemaphores", 0, vk::Result::TIMEOUT);
        assert_eq!(device.timeline.wait_at_most(number, Duration::ZERO), Ok(()), "it only looks");
        force(device, "vkWaitSemaphores", 0, vk::Result::TIMEOUT);
        let given_up = device.timeline.wait(number);
        let expected = "vkWaitSemaphores: no answer within 10 minutes".to_owned();
        assert_eq!(given_up, Err(Fault::Driver(expected)));
        assert_eq!(device.timeline.wait(number), Ok(()));
        wait(device, work);
    });
}
