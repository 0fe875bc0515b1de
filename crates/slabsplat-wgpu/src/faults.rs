//! What went wrong, noted where wgpu reports it.
//!
//! wgpu's calls return no errors: it hands them to a handler, which panics unless another is set. Ours notes
//! them, and the call that caused them, or the next, returns them. Outside of browsers the handler is called
//! before the call returns; in a browser later.
//!
//! A device of a caller's has the caller's handlers, which are left alone. There, calls are made within error
//! scopes, which are of one thread and hear of errors before any handler. In a browser they report later,
//! too: whoever calls next asks them. That such a device is lost shows when nothing comes back from it.

use slabsplat_gpu::DeviceError;
use std::fmt;
use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, Waker};

/// The faults of a device, shared with wgpu's handlers if they are ours.
#[derive(Debug, Default)]
pub(crate) struct Faults {
    noted: Mutex<Noted>,
    late: Mutex<Vec<Report>>,
}

/// What an error scope reports, as soon as it does.
struct Report(Pin<Box<dyn Future<Output = Option<wgpu::Error>> + Send>>);

#[derive(Debug, Default)]
struct Noted {
    /// Why the device is lost, if it is.
    lost: Option<String>,
    /// Whether there was no memory for something, since that was asked last.
    out_of_memory: bool,
}

impl Faults {
    /// Listens to the device. `on_message` is called with its errors.
    pub(crate) fn of(device: &wgpu::Device, on_message: Option<fn(&str)>) -> Arc<Self> {
        let faults = Arc::new(Self::default());
        let noting = Arc::clone(&faults);
        device.on_uncaptured_error(Arc::new(move |error| noting.note(&error, on_message)));
        let noting = Arc::clone(&faults);
        device.set_device_lost_callback(move |reason, message| {
            noting.lose(&format!("{reason:?} {message}"));
        });
        faults
    }

    /// Calls wgpu, and returns the errors that it reports at once of that, and hands to no handler.
    pub(crate) fn scoped<T>(
        &self,
        device: &wgpu::Device,
        calls: impl FnOnce() -> T,
    ) -> (T, Vec<wgpu::Error>) {
        let scopes = [
            wgpu::ErrorFilter::Validation,
            wgpu::ErrorFilter::Internal,
            wgpu::ErrorFilter::OutOfMemory,
        ]
        .map(|filter| device.push_error_scope(filter));
        let value = calls();
        let mut errors = Vec::new();
        // The last one first, as scopes are nested.
        for scope in scopes.into_iter().rev() {
            let mut report = Report(Box::pin(scope.pop()));
            match report.poll() {
                Poll::Ready(error) => errors.extend(error),
                Poll::Pending => locked(&self.late).push(report),
            }
        }
        (value, errors)
    }

    /// Notes what scopes had not reported at once.
    pub(crate) fn note_late(&self) {
        let mut errors = Vec::new();
        locked(&self.late).retain_mut(|report| match report.poll() {
            Poll::Ready(error) => {
                errors.extend(error);
                false
            }
            Poll::Pending => true,
        });
        errors.iter().for_each(|error| self.note(error, None));
    }

    /// Notes an error. `on_message` is called with it, unless it follows from another.
    pub(crate) fn note(&self, error: &wgpu::Error, on_message: Option<fn(&str)>) {
        if let wgpu::Error::OutOfMemory { .. } = error {
            self.noted().out_of_memory = true;
            return;
        }
        // A mistake of ours, or of the driver. Work that wgpu refused is missing from now on, so nothing that
        // comes later could be trusted.
        let message = error.to_string();
        let is_first = self.check().is_ok();
        self.lose(&message);
        // What wgpu says of a device that is lost already only follows from it.
        if let (Some(on_message), true) = (on_message, is_first) {
            on_message(&message);
        }
    }

    /// Gives the device up. The first reason is the one that counts.
    pub(crate) fn lose(&self, reason: &str) -> DeviceError {
        let mut noted = self.noted();
        let first = noted.lost.get_or_insert_with(|| reason.trim().to_owned());
        DeviceError::Lost { reason: first.clone() }
    }

    /// Whether the device can still be used.
    pub(crate) fn check(&self) -> Result<(), DeviceError> {
        match &self.noted().lost {
            None => Ok(()),
            Some(reason) => Err(DeviceError::Lost { reason: reason.clone() }),
        }
    }

    /// Whether what was just made, of so many bytes, is there.
    pub(crate) fn check_made(&self, bytes: u64) -> Result<(), DeviceError> {
        let out_of_memory = std::mem::take(&mut self.noted().out_of_memory);
        self.check()?;
        if out_of_memory { Err(DeviceError::OutOfMemory { bytes }) } else { Ok(()) }
    }

    fn noted(&self) -> MutexGuard<'_, Noted> {
        locked(&self.noted)
    }
}

impl Report {
    fn poll(&mut self) -> Poll<Option<wgpu::Error>> {
        self.0.as_mut().poll(&mut Context::from_waker(Waker::noop()))
    }
}

impl fmt::Debug for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Report")
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_keep_the_first_reason() {
        let faults = Faults::default();
        assert_eq!(faults.check(), Ok(()));
        faults.lose("first ");
        faults.lose("second");
        assert_eq!(faults.check(), Err(DeviceError::Lost { reason: "first".to_owned() }));
    }

    #[test]
    fn faults_of_memory_are_told_once() {
        let faults = Faults::default();
        let error = wgpu::Error::OutOfMemory { source: "no memory".into() };
        faults.note(&error, None);
        assert_eq!(faults.check(), Ok(()));
        assert_eq!(faults.check_made(12), Err(DeviceError::OutOfMemory { bytes: 12 }));
        assert_eq!(faults.check_made(12), Ok(()));
    }
}
