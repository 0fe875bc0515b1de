//! What can go wrong inside, and which of it a caller can do something about.

use ash::vk;
use gpu_allocator::AllocationError;
use slabsplat_gpu::DeviceError;

/// Why a call of the driver failed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Fault {
    /// There is no memory; nothing was changed.
    OutOfMemory,
    /// Anything else, after which the device is not used again.
    Driver(String),
}

impl Fault {
    /// The same for somebody who asked for that many bytes.
    pub(crate) fn asking_for(self, bytes: u64) -> DeviceError {
        match self {
            Self::OutOfMemory => DeviceError::OutOfMemory { bytes },
            Self::Driver(reason) => DeviceError::Lost { reason },
        }
    }

    /// For work of which a part has begun already, so that a want of memory cannot be undone.
    pub(crate) fn halfway(self) -> Self {
        match self {
            Self::OutOfMemory => {
                Self::Driver("memory ran out halfway through an upload".to_owned())
            }
            driver @ Self::Driver(_) => driver,
        }
    }
}

/// Turns what a Vulkan function returned into a fault that names the function.
pub(crate) fn during(function: &'static str) -> impl Fn(vk::Result) -> Fault {
    move |result| match result {
        vk::Result::ERROR_OUT_OF_HOST_MEMORY | vk::Result::ERROR_OUT_OF_DEVICE_MEMORY => {
            Fault::OutOfMemory
        }
        other => Fault::Driver(format!("{function}: {other}")),
    }
}

impl From<AllocationError> for Fault {
    fn from(error: AllocationError) -> Self {
        match error {
            // What fails to map finds no room in the address space.
            AllocationError::OutOfMemory | AllocationError::FailedToMap(_) => Self::OutOfMemory,
            AllocationError::Internal(text) if is_want_of_memory(&text) => Self::OutOfMemory,
            other => Self::Driver(format!("allocating memory: {other}")),
        }
    }
}

/// The allocator has a variant for the device's memory only; the others it prints.
fn is_want_of_memory(text: &str) -> bool {
    text.contains("OUT_OF_HOST_MEMORY") || text.contains("TOO_MANY_OBJECTS")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_want_of_memory_is_told_apart() {
        let of = during("vkAllocateMemory");
        assert_eq!(of(vk::Result::ERROR_OUT_OF_HOST_MEMORY), Fault::OutOfMemory);
        assert_eq!(of(vk::Result::ERROR_OUT_OF_DEVICE_MEMORY), Fault::OutOfMemory);
        let lost = of(vk::Result::ERROR_DEVICE_LOST).asking_for(4);
        assert!(matches!(lost, DeviceError::Lost { reason } if reason.starts_with("vkAllocate")));
        let on_host = "Unexpected error in vkAllocateMemory: ERROR_OUT_OF_HOST_MEMORY";
        assert_eq!(Fault::from(AllocationError::Internal(on_host.into())), Fault::OutOfMemory);
        assert!(matches!(Fault::OutOfMemory.halfway(), Fault::Driver(_)));
    }
}
