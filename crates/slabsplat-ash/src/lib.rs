//! Executes GPU frames on raw Vulkan.
//!
//! The other backend, on wgpu, runs everywhere. This one needs Vulkan 1.2, and in return knows what
//! wgpu must find out anew in every frame: that all buffers stay where they are, and that the passes
//! are those of the last frame. It decides nothing about what is drawn; that is `slabsplat-gpu`'s.
//!
//! # How work is executed
//!
//! 1. What earlier work has brought is collected, and the buffers that it used last are dropped.
//! 2. If eight submissions are in flight, the oldest is waited for.
//! 3. The passes are looked for among the recorded lists; if they are not there, or the device has that list
//!    at the moment, they are recorded: a barrier before each, a timestamp after each stage.
//! 4. New buffers are filled with zeros, and the bytes to be written are packed into one staging buffer,
//!    from where the device copies them. More than 64 MiB go in several submissions, of which two are on
//!    their way at a time.
//! 5. The slices to be read are copied into one buffer that the processor sees.
//! 6. All of it goes to the queue at once. A timeline semaphore says when it is done; asking it never waits.
//!
//! # Reading order
//!
//! `device`, `submit`, `in_flight`; `recordings`, `timing`; `uploads`, `readback`, `buffers`; `commands`,
//! `timeline`, `pipelines`, `sets`, `pool`, `memory`; `context`, `choose`, `instance`, `validation`;
//! `check`, `error`; `compiled`, which runs nothing.
//!
//! ```
//! use slabsplat_gpu::{Device, OpenOptions};
//!
//! match slabsplat_ash::open(&OpenOptions::default()) {
//!     Ok(device) => println!("{}", device.info().name),
//!     Err(unavailable) => println!("no Vulkan here: {unavailable}"),
//! }
//! ```

mod compiled;
mod device;
mod in_flight;
mod submit;

mod recordings;
mod timing;

mod buffers;
mod readback;
mod uploads;

mod commands;
mod timeline;

mod pipelines;
mod sets;

mod memory;
mod pool;

mod choose;
mod context;
mod instance;
mod validation;

mod check;
mod error;

#[cfg(test)]
mod tests;

pub use compiled::{CompiledShader, compiled};
pub use device::AshDevice;

use slabsplat_gpu::{DeviceInfo, OpenOptions, Unavailable};

/// Opens the best device: the first of [`devices`].
///
/// # Errors
/// If there is no Vulkan on this machine, or no device that can do the work.
pub fn open(options: &OpenOptions) -> Result<AshDevice, Unavailable> {
    AshDevice::open(options)
}

/// All devices that can do the work, best first: graphics cards before parts of the processor before
/// programs, and among them the one with most memory.
///
/// # Errors
/// If there is no Vulkan on this machine, or no such device.
pub fn devices() -> Result<Vec<DeviceInfo>, Unavailable> {
    let instance = instance::Instance::new(None)?;
    let candidates = choose::candidates(&instance)?;
    Ok(candidates.into_iter().map(|candidate| candidate.info).collect())
}
