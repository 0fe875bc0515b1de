//! Finds MPI by `mpicc`, if the feature `mpi` asks for it, and has that compile the few functions of C that
//! are called of it (`src/world/mpi.c`). An MPI's types differ from one to the next; that file has none in
//! its interface, so that nothing has to read headers.
//!
//! Where there is no `mpicc` the crate builds without MPI, and says so when it runs: `--all-features` builds
//! everywhere.

use std::env;
use std::path::Path;
use std::process::Command;

const SOURCE: &str = "src/world/mpi.c";

fn main() {
    println!("cargo::rustc-check-cfg=cfg(has_mpi)");
    println!("cargo::rerun-if-changed={SOURCE}");
    for variable in ["MPICC", "PATH"] {
        println!("cargo::rerun-if-env-changed={variable}");
    }
    if env::var_os("CARGO_FEATURE_MPI").is_none() {
        return;
    }
    let mpicc = env::var("MPICC").unwrap_or_else(|_| "mpicc".to_owned());
    match compile(&mpicc) {
        Ok(()) => println!("cargo::rustc-cfg=has_mpi"),
        Err(why) => println!("cargo::warning=built without MPI: {why}"),
    }
}

/// Compiles the functions, and tells cargo what to link them with.
fn compile(mpicc: &str) -> Result<(), String> {
    let out = env::var("OUT_DIR").map_err(|error| error.to_string())?;
    let object = Path::new(&out).join("slabsplat_mpi.o");
    let library = Path::new(&out).join("libslabsplat_mpi_c.a");
    let mut compiler = Command::new(mpicc);
    compiler.args(["-O2", "-fPIC", "-Wall", "-Wextra", "-c", SOURCE, "-o"]).arg(&object);
    run(&mut compiler)?;
    run(Command::new("ar").arg("crs").arg(&library).arg(&object))?;
    println!("cargo::rustc-link-search=native={out}");
    println!("cargo::rustc-link-lib=static=slabsplat_mpi_c");
    // Open MPI, MPICH and what is made of them all know this flag, and answer with a command line.
    let line = run(Command::new(mpicc).args(["-show", "main.c"]))?;
    for word in line.split_whitespace() {
        if let Some(folder) = word.strip_prefix("-L") {
            println!("cargo::rustc-link-search=native={folder}");
        } else if let Some(name) = word.strip_prefix("-l") {
            println!("cargo::rustc-link-lib={name}");
        }
    }
    Ok(())
}

fn run(command: &mut Command) -> Result<String, String> {
    let name = command.get_program().to_string_lossy().into_owned();
    let output = command.output().map_err(|error| format!("{name} does not start: {error}"))?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        return Err(format!("{name} failed: {}", said.lines().next().unwrap_or_default()));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}
