//! What a [`Scene`] is made of: [`Layer`]s, each a [`Volume`] on a [`Grid`] with a [`TransferFunction`] and
//! [`Shading`]; [`MeshLayer`]s, each an opaque [`Mesh`]; a [`Camera`] and [`RenderSettings`]; and what comes
//! out, an [`Image`].
//!
//! Everything here is checked where it is made. A [`Grid`] that exists can be inverted, a
//! [`TransferFunction`] has sorted and finite points, a [`Camera`] has three right-angled axes, so
//! that the crates above never ask again. Nothing here reads a file or draws.
//!
//! # Spaces
//!
//! - *index space*: voxel `(i, j, k)` sits at the point `(i, j, k)`; x runs fastest in memory.
//! - *world space*: what the camera and the lights are given in; `x = A·(i, j, k) + o`.
//! - *view space*: right, up, and *depth*, the distance along the viewing direction from the eye.
//!
//! A matrix is named `to_from_from`: `world_from_index` takes index space to world space.
//!
//! # Reading order
//!
//! `grid`, `sample`, `volume`; `camera`; `transfer`, `transfer_2d`, `transfer_image`, `isosurface`;
//! `compositing`, `unit_vector`, `light`, `shading`; `settings_table`, `interval`, `choices`, `easing`,
//! `turn_axis`, `settings`;
//! `mesh`; `region`, `labels`, `voxel_colors`, `layer`, `mesh_layer`, `scene`; `view`, `region_in_view`,
//! `part`, `part_tree`, `slabs`, `slices`;
//! `image`, `image_difference`; `finish`, `ticks`; `frame_handle`; `serialized`.
//!
//! What all of it means for a picture is the page [`model`]; "model §3" is its third section.
//!
//! ```
//! use slabsplat_core::{Grid, Samples, Scaling, Volume};
//!
//! let grid = Grid::with_spacing([2, 2, 1], [1.0, 1.0, 2.5])?;
//! let volume = Volume::new(grid, Samples::U8(vec![0, 10, 20, 30]), Scaling::IDENTITY)?;
//! assert_eq!(volume.value(3), 30.0);
//! assert_eq!(volume.grid().unit(), 1.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![cfg_attr(docsrs, feature(doc_cfg))]
#![deny(clippy::exhaustive_enums, clippy::exhaustive_structs)]

mod acquisition;
mod grid;
mod sample;
mod volume;

mod camera;
mod compositing;
mod isosurface;
mod light;
mod shading;
mod transfer;
mod transfer_2d;
mod transfer_changes;
mod transfer_image;
mod unit_vector;

mod choices;
mod easing;
mod interval;
mod settings;
mod settings_table;
mod turn_axis;

mod mesh;

mod labels;
mod layer;
mod mesh_layer;
mod region;
mod scene;
mod voxel_colors;

mod part;
mod part_tree;
mod region_in_view;
mod slabs;
mod slices;
mod view;

mod image;
mod image_difference;

mod finish;
mod ticks;

mod frame_handle;

#[cfg(feature = "serde")]
mod serialized;

pub mod model;

pub use acquisition::{Acquisition, Modality, Orientation};
pub use camera::{Camera, CameraError, Projection, ViewAxes};
pub use choices::{
    Compositing, Fit, KernelName, Lookup, Method, Mode, Normalization, NotAChoice, ProjectionKind,
    Statistic, Viewpoint,
};
pub use compositing::{MAX_OPACITY, extinction};
pub use easing::Easing;
pub use finish::{Annotations, Finish, FinishError};
pub use frame_handle::{Cancelled, FrameHandle, StageError};
pub use grid::{Grid, GridError};
pub use image::{Image, ImageDesc, ImageError, over};
pub use image_difference::ImageDifference;
pub use interval::{Interval, OutOfRange};
pub use isosurface::{Isosurface, IsosurfaceError};
pub use labels::{LabelError, LabelMap, LabelStyle, Labels};
pub use layer::Layer;
pub use light::{Light, LightDirection, LightError, LightInView, LightSource};
pub use mesh::{DroppedElements, Mesh, MeshError, MeshParts};
pub use mesh_layer::MeshLayer;
pub use part::{Part, PartInView};
pub use part_tree::{PartBox, PartSupport, PartTree};
pub use region::{Plane, Region, RegionError};
pub use region_in_view::{PlaneInView, RegionInView, ViewRay};
pub use sample::{Sample, SampleType, Samples};
pub use scene::Scene;
#[cfg(feature = "serde")]
pub use serialized::{deserialize_settings, exact_degrees, serialize_settings};
pub use settings::{RenderSettings, SettingsError};
pub use settings_table::{Access, Field, NotAValue, Setting, Settings};
pub use shading::{BlinnPhong, Phong, Shading};
pub use slabs::{SlabGrid, TooManySlabs};
pub use slices::SliceOrder;
pub use ticks::{number_text, round_number_to, round_ticks};
pub use transfer::{CurvePoint, IsoRange, PiecewiseLinear, TransferError, TransferFunction};
pub use transfer_2d::{Transfer2dError, TransferBox, TransferFunction2d};
pub use transfer_image::TransferImage;
pub use turn_axis::TurnAxis;
pub use view::{View, ViewError, ViewFromIndex};
pub use volume::{Scaling, Summary, Volume, VolumeError};
pub use voxel_colors::{ColorSamples, VoxelColors, WrongNumberOfColors};

/// The vectors and matrices of this crate. Types of two versions of glam are two types, so a newer glam is a
/// breaking release here. Who gives arrays, which are taken wherever vectors are, need not care.
pub use glam;
