//! The program `slabsplat`, built for release, and what its `bench` says of a scene.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};
use serde::Deserialize;

use xtask::process::{cargo, output, run};
use xtask::workspace::{self, Workspace};

/// The program, ready to run.
pub(super) struct Program {
    path: PathBuf,
}

/// What is to be measured.
#[derive(Clone, Debug, Default)]
pub(super) struct Run {
    /// A scene file, a volume file or `builtin:NAME:SIZE`.
    pub(super) input: OsString,
    pub(super) flags: Vec<String>,
    pub(super) n_frames: usize,
    /// As many as rayon takes by itself if there is none.
    pub(super) n_threads: Option<usize>,
}

/// What was measured, as far as anyone here asks.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub(super) struct Measure {
    pub(super) median_ms: f64,
    pub(super) n_voxels: u64,
}

impl Program {
    pub(super) fn built() -> Result<Self> {
        run(cargo(workspace::root()).args(["build", "--release", "--package", "slabsplat-cli"]))?;
        let name = format!("slabsplat{}", std::env::consts::EXE_SUFFIX);
        Ok(Self { path: Workspace::read()?.target_directory.join("release").join(name) })
    }

    /// Writes a volume in another format.
    pub(super) fn convert(&self, volume: &Path, to: &Path) -> Result<()> {
        run(Command::new(&self.path).arg("convert").arg(volume).arg(to))
    }

    /// What shows a volume by a page that lies in `site`, and prints the link to it.
    pub(super) fn serve(&self, volume: &Path, site: &Path) -> Command {
        let mut command = Command::new(&self.path);
        command.arg("serve").arg(volume).arg("--site").arg(site);
        command.args(["--backend", "cpu", "--port", "0"]);
        command
    }

    /// Frames on the CPU, whatever the scene says.
    pub(super) fn bench(&self, run: &Run) -> Result<Measure> {
        let mut command = Command::new(&self.path);
        command.arg("bench").arg(&run.input).args(&run.flags);
        command.args(["--backend", "cpu", "--json", "--frames", &run.n_frames.to_string()]);
        if let Some(n_threads) = run.n_threads {
            command.env("RAYON_NUM_THREADS", n_threads.to_string());
        }
        serde_json::from_str(&output(&mut command)?)
            .context("`slabsplat bench --json` answers something else")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parse_what_is_asked_for() {
        let answer = r#"{ "median_ms": 12.5, "n_voxels": 7, "threads": 2, "scene": "a" }"#;
        let expected = Measure { median_ms: 12.5, n_voxels: 7 };
        assert_eq!(serde_json::from_str::<Measure>(answer).unwrap(), expected);
        let error = serde_json::from_str::<Measure>("{}").unwrap_err().to_string();
        assert!(error.contains("median_ms"), "{error}");
    }
}
