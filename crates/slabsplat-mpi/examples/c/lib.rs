//! The library for programs in C, `libslabsplat_c.a`: what `include/slabsplat_mpi.h` declares.
//!
//! ```sh
//! cargo build --release -p slabsplat-mpi --features mpi --example slabsplat_c
//! mpicc heat.c -I crates/slabsplat-mpi/include target/release/examples/libslabsplat_c.a -lm -lpthread -ldl
//! ```

pub use slabsplat_mpi::c::*;
