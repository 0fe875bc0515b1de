//! The paper's figures and tables: their scenes, what is read off their pictures, and what is printed.
//!
//! The paper is Mueller and Crawfis, "Eliminating Popping Artifacts in Sheet Buffer-Based Splatting", IEEE
//! Visualization '98. `slabsplat reproduce` makes a page of what is here, and tests hold every backend to it.
//!
//! ```
//! use slabsplat::{Method, Renderer, paper};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let settings = paper::settings().method(Method::AxisAligned);
//! let view = paper::CubeView { angle_degrees: 44.9, opacity: 1.0, ambient: 0.0, settings };
//! let image = Renderer::open("cpu", |_| ())?.render(&paper::cube(&view))?.image;
//! let [left, right] = paper::face_means(|x, y| image.pixel(x, y)[0].into());
//! assert!(2.0 * right < left, "figure 2: one face is much brighter than the other");
//! # Ok(())
//! # }
//! ```

mod scenes;

mod faces;
mod printed;
pub mod table_1;

pub use faces::{column_means, face_means, face_profile, stripes, sum_over_picture};
pub use printed::{PRINTED_TIMES, PrintedTimes};
pub use scenes::{
    CUBE_EXTENT, CUBE_GRID, CUBE_IMAGE_SIDE, CUBE_PIXELS_PER_VOXEL, CubeView, FACE_PIXELS,
    VOXEL_PIXELS_PER_VOXEL, cube, settings, single_voxel,
};
