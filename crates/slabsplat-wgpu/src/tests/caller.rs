//! Devices of a caller's: what the caller has set stays, and what goes wrong is an error of whose it is.

use super::{run, slice, wait};
use crate::{WgpuDevice, ready};
use slabsplat_gpu::{Device, DeviceError, Work, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A device, its queue, and how many errors have come to the handler that the caller has set.
pub(super) struct Caller {
    adapter: wgpu::Adapter,
    pub(super) device: wgpu::Device,
    pub(super) queue: wgpu::Queue,
    n_errors: Arc<AtomicUsize>,
    n_losses: Arc<AtomicUsize>,
}

impl Caller {
    /// A caller who has asked for `limits` alone, or, without any, for what frames need.
    pub(super) fn new(limits: Option<wgpu::Limits>) -> Option<Self> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let found = ready::at_once(instance.request_adapter(&Default::default())).unwrap();
        let adapter = match found {
            Ok(adapter) => adapter,
            Err(none) if std::env::var_os("SLABSPLAT_REQUIRE_GPU").is_some() => panic!("{none}"),
            Err(none) => {
                println!("skipped: {none}");
                return None;
            }
        };
        Some(Self::on(adapter, limits))
    }

    /// The same on another device of the same adapter.
    pub(super) fn beside(&self) -> Self {
        Self::on(self.adapter.clone(), None)
    }

    fn on(adapter: wgpu::Adapter, limits: Option<wgpu::Limits>) -> Self {
        let descriptor = match limits {
            Some(required_limits) => {
                wgpu::DeviceDescriptor { required_limits, ..Default::default() }
            }
            None => crate::device_descriptor(&adapter, wgpu::DeviceDescriptor::default()),
        };
        let opened = ready::at_once(adapter.request_device(&descriptor)).unwrap();
        let (device, queue) = opened.unwrap();
        let [n_errors, n_losses] = [(); 2].map(|()| Arc::new(AtomicUsize::new(0)));
        let count = n_errors.clone();
        device.on_uncaptured_error(Arc::new(move |_| {
            count.fetch_add(1, Ordering::Relaxed);
        }));
        let count = n_losses.clone();
        device.set_device_lost_callback(move |_, _| {
            count.fetch_add(1, Ordering::Relaxed);
        });
        Self { adapter, device, queue, n_errors, n_losses }
    }

    pub(super) fn opened(&self) -> WgpuDevice {
        crate::on(self.device.clone(), self.queue.clone()).unwrap()
    }

    /// What no validation accepts.
    fn blunder(&self) {
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::MAP_WRITE;
        let descriptor =
            wgpu::BufferDescriptor { label: None, size: 16, usage, mapped_at_creation: false };
        drop(self.device.create_buffer(&descriptor));
    }

    pub(super) fn n_errors(&self) -> usize {
        self.n_errors.load(Ordering::Relaxed)
    }
}

/// Writes and reads back.
pub(super) fn check_works(device: &mut WgpuDevice) {
    let buffer = device.create_buffer("numbers", 16).unwrap();
    let write = Write { buffer, offset: 4, bytes: vec![1, 2, 3, 4].into() };
    let work = Work { writes: vec![write], reads: vec![slice(buffer, 0, 8)], ..Work::default() };
    assert_eq!(run(device, &work).reads, [[0, u32::from_ne_bytes([1, 2, 3, 4])]]);
    device.destroy_buffer(buffer);
}

/// Work that wgpu refuses.
fn nonsense(device: &mut WgpuDevice) -> DeviceError {
    let buffer = device.create_buffer("short", 16).unwrap();
    let beyond = Write { buffer, offset: 8, bytes: vec![1; 16].into() };
    device.submit(&Work { writes: vec![beyond], ..Work::default() }).unwrap_err()
}

#[test]
fn errors_are_of_whose_they_are() {
    let Some(caller) = Caller::new(None) else { return };
    let mut device = caller.opened();
    check_works(&mut device);
    caller.blunder();
    assert_eq!(caller.n_errors(), 1, "the caller's handler is still there");
    check_works(&mut device);
    let mut other = caller.opened();
    assert!(matches!(nonsense(&mut device), DeviceError::Lost { .. }));
    assert_eq!(caller.n_errors(), 1, "the caller need not hear of it");
    check_works(&mut other);
}

#[test]
fn error_scopes_of_the_caller_stay_empty() {
    let Some(caller) = Caller::new(None) else { return };
    let mut device = caller.opened();
    let filters = [
        wgpu::ErrorFilter::Validation,
        wgpu::ErrorFilter::Internal,
        wgpu::ErrorFilter::OutOfMemory,
    ];
    let scopes = filters.map(|filter| caller.device.push_error_scope(filter));
    nonsense(&mut device);
    check_works(&mut caller.opened());
    for scope in scopes.into_iter().rev() {
        assert!(ready::at_once(scope.pop()).unwrap().is_none());
    }
    let scope = caller.device.push_error_scope(wgpu::ErrorFilter::Validation);
    check_works(&mut caller.opened());
    caller.blunder();
    assert!(ready::at_once(scope.pop()).unwrap().is_some(), "it is the caller's");
    assert_eq!(caller.n_errors(), 0);
}

/// Each blunders, and works, while the other does.
#[test]
fn caller_goes_on_on_another_thread() {
    let Some(caller) = Caller::new(None) else { return };
    let mut device = caller.opened();
    std::thread::scope(|threads| {
        threads.spawn(|| {
            for _ in 0..50 {
                caller.blunder();
                caller.queue.submit([]);
                caller.device.poll(wgpu::PollType::Poll).unwrap();
            }
        });
        for _ in 0..50 {
            check_works(&mut device);
        }
    });
    assert_eq!(caller.n_errors(), 50);
}

#[test]
fn what_the_device_lacks_is_named() {
    let few = wgpu::Limits { max_storage_buffers_per_shader_stage: 4, ..Default::default() };
    let Some(caller) = Caller::new(Some(few)) else { return };
    let error = crate::on(caller.device, caller.queue).unwrap_err().to_string();
    assert!(error.contains("needs") || error.contains("need"), "{error}");
    assert!(error.contains("8 storage buffers in a shader stage (it has 4)"), "{error}");
    assert!(error.contains("`device_descriptor`"), "{error}");
}

#[test]
fn default_limits_of_webgpu_are_enough() {
    let Some(caller) = Caller::new(Some(wgpu::Limits::default())) else { return };
    let mut device = caller.opened();
    assert_eq!(device.info().max_binding_bytes, 128 << 20);
    assert!(!device.info().has_timestamps);
    check_works(&mut device);
}

#[test]
fn device_that_its_caller_destroys_is_lost() {
    let Some(caller) = Caller::new(None) else { return };
    let mut device = caller.opened();
    check_works(&mut device);
    let buffer = device.create_buffer("before", 16).unwrap();
    caller.device.destroy();
    let reads = vec![slice(buffer, 0, 16)];
    let submitted = device.submit(&Work { reads, ..Work::default() });
    let error = submitted.and_then(|work| {
        loop {
            if device.poll(work)?.is_ready() {
                return Ok(());
            }
        }
    });
    assert!(matches!(error, Err(DeviceError::Lost { .. })), "{error:?}");
    assert!(matches!(device.create_buffer("after", 16), Err(DeviceError::Lost { .. })));
    device.destroy_buffer(buffer);
    drop(device);
    caller.device.poll(wgpu::PollType::Poll).unwrap();
    assert_eq!(caller.n_losses.load(Ordering::Relaxed), 1, "the caller's callback is still there");
    assert_eq!(caller.n_errors(), 0);
}

/// It comes to light where it was called from, and nothing else is lost.
#[test]
fn callback_of_the_caller_may_panic() {
    let Some(caller) = Caller::new(None) else { return };
    let mut device = caller.opened();
    let work = device.submit(&Work::default()).unwrap();
    // On the submission of the work itself: one of its own could end after the work was taken.
    caller.queue.on_submitted_work_done(|| panic!("the caller's"));
    let waited = catch_unwind(AssertUnwindSafe(|| wait(&mut device, work)));
    let message = *waited.unwrap_err().downcast::<&str>().unwrap();
    assert_eq!(message, "the caller's");
    check_works(&mut device);
}
