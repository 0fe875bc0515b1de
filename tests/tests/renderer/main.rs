//! The renderer as a whole: its pictures by every backend against the float64 reference, against what is
//! known without one, and against each other.
//!
//! One program, as each links all of slabsplat, and its devices keep their pipelines from test to test. What
//! counts a heap or instructions, or waits for a browser, is a program of its own.

mod cancel;
mod colors;
mod conformance;
mod density_layers;
mod detail_levels;
mod detail_levels_of_patterns;
mod determinism;
mod extremes;
mod gpu;
mod gpu_densities;
mod gpu_density_layers;
mod gpu_hidden;
mod gpu_meshes;
mod gpu_samples;
mod gpu_transfers;
mod images;
mod in_situ;
mod isosurfaces;
mod labels;
mod layers;
mod lights;
mod meshes;
mod modes;
mod own_kernel;
mod paper_figures;
mod parity;
mod parts;
mod post_classified;
mod real_scenes;
mod reference;
mod reference_layers;
mod scene_files;
mod sharpness;
mod table_1;
mod tables;
mod textures;
mod thin_lines;
mod tolerance;
