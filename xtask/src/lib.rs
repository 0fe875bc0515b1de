//! What the tools of this workspace have in common: starting programs, and asking cargo about the workspace.
//!
//! The commands are in the program, `main.rs`; `slabsplat-bench` is the other tool.
//! Nothing here is part of the renderer, and none of its crates may depend on it.

pub mod process;
pub mod test_build;
pub mod workspace;
