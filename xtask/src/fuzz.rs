//! `cargo xtask fuzz`: gives the readers of files hostile ones, which libFuzzer makes from small valid ones.
//!
//! The targets are in `tests/fuzz`, and need a nightly compiler and cargo-fuzz. What libFuzzer learns stays
//! in `target/fuzz/corpus`, so that the next run continues from there; an input that breaks a reader is left
//! in the folder `artifacts` beside the targets, and ends the run.

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::Command;

use anyhow::{Result, ensure};

use xtask::process::{output, run as run_command};
use xtask::workspace;

/// What is fuzzed, and for how long.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Fuzz {
    /// All targets if none is named.
    pub(crate) target: Option<String>,
    /// Of each target.
    pub(crate) n_seconds: u32,
}

const N_SECONDS: u32 = 60;

/// What an input may cost, and how long it may be.
const LIMITS: &[&str] = &["-rss_limit_mb=1024", "-timeout=10", "-max_len=65536"];

pub(crate) fn parse(args: &[OsString]) -> Result<Fuzz, String> {
    let mut fuzz = Fuzz { target: None, n_seconds: N_SECONDS };
    for arg in args {
        let text = arg.to_str().unwrap_or_default();
        match text.parse() {
            Ok(n_seconds) if 0 < n_seconds => fuzz.n_seconds = n_seconds,
            Err(_) if fuzz.target.is_none() && !text.is_empty() => {
                fuzz.target = Some(text.to_owned());
            }
            _ => {
                return Err(format!(
                    "`fuzz` takes a target and seconds, found `{}`",
                    arg.display()
                ));
            }
        }
    }
    Ok(fuzz)
}

pub(crate) fn run(fuzz: &Fuzz) -> Result<()> {
    let tool = output(Command::new("cargo").args(["+nightly", "fuzz", "--version"]));
    let wanted = "`cargo install cargo-fuzz --locked`, `rustup toolchain install nightly`";
    ensure!(tool.is_ok(), "cargo-fuzz or a nightly compiler is missing: {wanted}");
    let corpus = workspace::root().join("target").join("fuzz").join("corpus");
    run_command(cargo(&["run", "--quiet", "--example", "seeds", "--"]).arg(&corpus))?;
    let targets = output(&mut cargo(&["fuzz", "list", "--fuzz-dir", "."]))?;
    let targets: Vec<&str> = targets.lines().collect();
    let is_asked = |target: &&str| fuzz.target.as_deref().is_none_or(|asked| asked == *target);
    let asked: Vec<&str> = targets.iter().copied().filter(is_asked).collect();
    ensure!(!asked.is_empty(), "there is no such target, but {}", targets.join(", "));
    for target in asked {
        let mut command = cargo(&["fuzz", "run", "--fuzz-dir", ".", target]);
        command.arg(corpus.join(target)).arg("--").args(LIMITS);
        run_command(command.arg(format!("-max_total_time={}", fuzz.n_seconds)))?;
    }
    Ok(())
}

/// The nightly cargo among the targets, which builds where all else is built.
fn cargo(args: &[&str]) -> Command {
    let mut command = Command::new("cargo");
    command.arg("+nightly").args(args).current_dir(folder());
    command.env("CARGO_TARGET_DIR", workspace::root().join("target").join("fuzz"));
    // The compiler that builds xtask is not the one that builds targets.
    command.env_remove("RUSTUP_TOOLCHAIN").env_remove("CARGO").env_remove("RUSTC");
    command
}

fn folder() -> PathBuf {
    workspace::root().join("tests").join("fuzz")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parse_target_and_seconds() {
        let check = |args: &[&str], target: Option<&str>, n_seconds| {
            let args: Vec<OsString> = args.iter().map(OsString::from).collect();
            let expected = Fuzz { target: target.map(str::to_owned), n_seconds };
            assert_eq!(parse(&args), Ok(expected), "{args:?}");
        };
        check(&[], None, 60);
        check(&["600"], None, 600);
        check(&["nrrd"], Some("nrrd"), 60);
        check(&["nrrd", "5"], Some("nrrd"), 5);
        for bad in [&["nrrd", "npy"][..], &["0"], &["-1", "x"], &[""]] {
            let args: Vec<OsString> = bad.iter().map(OsString::from).collect();
            assert!(parse(&args).is_err(), "{bad:?}");
        }
    }

    /// What the workspace leaves out cargo does not miss.
    #[test]
    fn targets_are_there() {
        let manifest = std::fs::read_to_string(folder().join("Cargo.toml")).unwrap();
        let paths = manifest.lines().filter_map(|line| line.strip_prefix("path = \"fuzz_targets/"));
        let mut named: Vec<&str> = paths.map(|path| path.trim_end_matches('"')).collect();
        named.sort_unstable();
        let entries = std::fs::read_dir(folder().join("fuzz_targets")).unwrap();
        let mut files: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        files.sort_unstable();
        assert_eq!(named, files);
    }
}
