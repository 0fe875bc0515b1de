//! A simulation in C, `examples/c/heat.c`, compiled by `mpicc` with the header and the library that it would
//! have, and run by `mpirun`.

#![cfg(feature = "mpi")]
#![expect(clippy::unwrap_used, reason = "functions of tests are tests, too")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const REQUIRE_MPI: &str = "SLABSPLAT_REQUIRE_MPI";

/// Whether there is an MPI; if not, that is said.
fn has_mpi() -> bool {
    let starts = |program: &str| Command::new(program).arg("--version").output().is_ok();
    let is_there = starts("mpicc") && starts("mpirun");
    if !is_there {
        let is_required = std::env::var_os(REQUIRE_MPI).is_some();
        assert!(!is_required, "{REQUIRE_MPI} is set, but there is no mpicc or no mpirun");
        println!("skipped: there is no mpicc or no mpirun");
    }
    is_there
}

/// The folder of examples, beside that of this test.
fn examples() -> PathBuf {
    let test = std::env::current_exe().unwrap();
    test.parent().and_then(Path::parent).unwrap().join("examples")
}

fn compiled(folder: &Path) -> Option<PathBuf> {
    let library = examples().join("libslabsplat_c.a");
    if !library.is_file() {
        // Who names this test alone builds no examples.
        println!("skipped: {} is not built", library.display());
        return None;
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let program = folder.join("heat");
    let output = Command::new("mpicc")
        .args(["-std=c11", "-O2", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-o"])
        .arg(&program)
        .arg(root.join("examples/c/heat.c"))
        .arg("-I")
        .arg(root.join("include"))
        .arg(&library)
        .args(["-lm", "-lpthread", "-ldl"])
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    Some(program)
}

fn ranks(n_ranks: usize, program: &Path, frames: &Path) -> Output {
    Command::new("mpirun")
        .env("OMPI_ALLOW_RUN_AS_ROOT", "1")
        .env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")
        .args(["--oversubscribe", "--bind-to", "none", "-n", &n_ranks.to_string()])
        .arg(program)
        .arg("24")
        .arg(frames)
        .output()
        .unwrap()
}

#[test]
fn heat_in_c_is_seen_by_any_number_of_ranks() {
    if !has_mpi() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let Some(program) = compiled(folder.path()) else { return };
    let frame = |n_ranks: usize| {
        let frames = folder.path().join(n_ranks.to_string());
        std::fs::create_dir(&frames).unwrap();
        let output = ranks(n_ranks, &program, &frames);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        image::open(frames.join("0003.png")).unwrap().to_rgba8()
    };
    let (one, three) = (frame(1), frame(3));
    // In steps of 8 bits: rounding decides one at most.
    let off = one.iter().zip(three.iter()).map(|(a, b)| a.abs_diff(*b)).max();
    assert!(off <= Some(1), "{off:?}");
    assert!(one.pixels().any(|pixel| 100 < pixel.0[0]), "something is hot");
    // What rank 0 alone cannot do fails on all, in one line.
    let output = ranks(2, &program, &folder.path().join("none"));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let lines = said.lines().filter(|line| line.starts_with("error: "));
    assert!(!output.status.success() && lines.count() == 1, "{said}");
}
