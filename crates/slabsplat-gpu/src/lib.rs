//! A frame on a GPU, as data: which buffers, which shaders, in which order, how many workgroups. It is
//! written down once, here, and executed by whatever implements [`Device`]; with a device, [`GpuBackend`] is
//! a backend like any other.
//!
//! # How a frame is made
//!
//! 1. *Classify*, each layer whose volume or transfer function changed: the device finds the relevant voxels
//!    among the samples that it holds, with their normals and colours. A new transfer function sends its
//!    points (32 bytes each), a new volume its samples. Where more than a voxel's value decides how it looks,
//!    the host lists the relevant voxels instead and sends a record of each, 32 bytes, if anything changed.
//!    So it does where pixels are larger than voxels, and cells of these may be drawn (model §16): a list for
//!    each level, which is a layer from there on.
//! 2. *Project*: every relevant voxel is shaded and projected, into one list for all layers; those beyond
//!    their layer's region, or the part that is drawn (model §17), are tossed nowhere, and so are those that
//!    were hidden in the frame before. A new camera sends 112 bytes, 240 a layer, 32 for each plane of a
//!    region and of the part, and 52 for each pass that it changes.
//! 3. *Sort* the voxels by the sheet in which they begin (by depth for `every-sample`).
//! 4. *Toss* them onto tiles of 8² pixels (paper §7): count, prefix sum, scatter; a stable sort by tile then
//!    keeps the order from front to back within each.
//! 5. *Splat*: a workgroup renders a tile, sheet by sheet, in registers, and stops when all pixels are
//!    saturated. Sums of a slab are cut by the region of what they are of, and by the part that is drawn;
//!    what lies in front of a part is laid over its picture once that was read back. Where there are opaque
//!    meshes, rays end at surfaces, which the host has found and sends when they change, 16 bytes each.
//!
//! Densities (model §§8, 12) go the same way: all voxels are listed, with their values, and what splats them
//! shows what lies between sheets, of a layer that is alone, or of up to four and beside meshes.
//!
//! Sorts and sums are stable and take no part in races, so a frame gives the same bits every time.
//! Classification compares samples as the integers that they are, and positions of the transfer function
//! have 48 bits; everything after that is in 32-bit floats, in `unit`s of the grid.
//!
//! # Where a picture goes
//!
//! It is read back, as any [`Backend`](slabsplat_backend::Backend) delivers it; or, by
//! [`GpuBackend::submit_into`], a [`Destination`] takes it on the device, in the order of all work there, and
//! the counts alone come back.
//!
//! # What a third device would have to write
//!
//! The five functions of [`Device`]: make and destroy buffers, begin work, hand bytes back. Shaders come as
//! WGSL and as SPIR-V (`slabsplat-shaders`), passes as a list of shader, buffer slices and workgroup counts.
//!
//! # Reading order
//!
//! `device`, `destination`; `listing`, which says who lists a layer's voxels, `listings`, `host_list`,
//! `detail_lists`, `cells_to_list` and `known_volume`; `voxel_lists`, `voxel_list`, `classifier`,
//! `volumes`, `uploads`, `frame_passes`, `frame_memory` and `tables`, which are the frame, with
//! `pass_list`, `sums`, `chunks` and `memory` below them; `backend` and `job`; `params`, `frame_params`,
//! `layer_params`, `densities`, `density_elements`, `cell_record`, `regions`, `depth_params`,
//! `classification`, `number`, `samples`, `section_table`, `drawn_by`, `surfaces` and `surface_elements`,
//! which say a plan in the shaders' terms. The stages themselves are in `shaders/`.

#![deny(clippy::exhaustive_enums, clippy::exhaustive_structs)]

mod destination;
mod device;

mod cell_record;
mod classification;
mod densities;
mod density_elements;
mod depth_params;
mod drawn_by;
mod frame_params;
mod layer_params;
mod number;
mod params;
mod regions;
mod samples;
mod section_table;
mod segments;
mod splits;
mod surface_elements;
mod surfaces;

mod chunks;
mod memory;
mod pass_list;
mod sums;

mod cells_to_list;
mod detail_lists;
mod host_list;
mod known_volume;
mod listing;
mod listings;

mod classifier;
mod frame_memory;
mod frame_passes;
mod hidden;
mod job;
mod tables;
mod uploads;
mod volumes;
mod voxel_list;
mod voxel_lists;

mod backend;

pub use backend::GpuBackend;
pub use destination::{Destination, Picture, PictureBand};
pub use device::{
    BufferId, Device, DeviceError, DeviceInfo, DeviceKind, Done, OpenOptions, Pass, Slice,
    Unavailable, Work, WorkId, Write,
};
