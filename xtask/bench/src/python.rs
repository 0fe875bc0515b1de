//! A Python with VTK: one that is named, one in the home directory, or one that is made.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use xtask::process::{output, python, run};

const VARIABLE: &str = "SLABSPLAT_PEERS_PYTHON";

/// The Python that `SLABSPLAT_PEERS_PYTHON` names; else that of `~/peers`, where people have put one; else
/// one in a virtual environment in the target directory, into which VTK is installed.
pub(super) fn with_vtk(target: &Path) -> Result<PathBuf> {
    if let Some(named) = env::var_os(VARIABLE).filter(|named| !named.is_empty()) {
        let named = PathBuf::from(named);
        ensure!(has_vtk(&named), "{VARIABLE} is {}, which has no VTK", named.display());
        return Ok(named);
    }
    let of_home = env::home_dir().map(|home| home.join("peers"));
    let environments = of_home.into_iter().chain([target.join("peers")]);
    let mut pythons = environments.map(|environment| python_of(&environment));
    match pythons.find(|python| has_vtk(python)) {
        Some(python) => Ok(python),
        None => make(&target.join("peers")).with_context(|| {
            format!("VTK cannot be installed: set {VARIABLE} to a Python that has it (`pip install vtk`)")
        }),
    }
}

fn python_of(environment: &Path) -> PathBuf {
    environment.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" })
}

fn has_vtk(python: &Path) -> bool {
    output(Command::new(python).args(["-c", "import vtk"])).is_ok()
}

fn make(environment: &Path) -> Result<PathBuf> {
    run(python().args(["-m", "venv"]).arg(environment))?;
    let python = python_of(environment);
    run(Command::new(&python).args(["-m", "pip", "install", "--quiet", "vtk"]))?;
    ensure!(has_vtk(&python), "what was installed into {} is not found", environment.display());
    Ok(python)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn has_vtk_not_without_python() {
        assert!(!has_vtk(Path::new("/no/such/python")), "no such file");
    }
}
