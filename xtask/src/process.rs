//! Starting other programs: shown before they run, and an error if they fail.

use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, ensure};

/// How programs must be built whose instructions are counted: incremental builds part a crate into other
/// units, which other functions are inlined across, and that alone moves counts by up to 9 %.
pub const REPEATABLE: (&str, &str) = ("CARGO_INCREMENTAL", "0");

/// The cargo that runs us, in `root`.
#[must_use]
pub fn cargo(root: &Path) -> Command {
    let program = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(program);
    command.current_dir(root);
    command
}

/// The system's Python.
#[must_use]
pub fn python() -> Command {
    Command::new(if cfg!(windows) { "python" } else { "python3" })
}

/// Runs the command, and shows it first.
///
/// # Errors
/// If it fails.
pub fn run(command: &mut Command) -> Result<()> {
    let line = shown(command);
    eprintln!("$ {line}");
    let status = command.status().with_context(|| format!("cannot start `{line}`"))?;
    ensure!(status.success(), "`{line}` failed, {status}");
    Ok(())
}

/// What the command prints, as text.
///
/// # Errors
/// If it fails, with what it complained of.
pub fn output(command: &mut Command) -> Result<String> {
    let line = shown(command);
    let output = command.output().with_context(|| format!("cannot start `{line}`"))?;
    let message = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.success(), "`{line}` failed, {}: {}", output.status, message.trim());
    String::from_utf8(output.stdout).with_context(|| format!("`{line}` printed no UTF-8"))
}

/// Whether there is a program that says its version.
#[must_use]
pub fn starts(program: &str) -> bool {
    output(Command::new(program).arg("--version")).is_ok()
}

/// Whether cargo has the subcommand `name`, which may be a program of others.
#[must_use]
pub fn has_subcommand(name: &str) -> bool {
    output(cargo(Path::new(".")).args([name, "--version"])).is_ok()
}

fn shown(command: &Command) -> String {
    // A full path to the toolchain's cargo says nothing that its name does not.
    let program = Path::new(command.get_program());
    let program = program.file_stem().unwrap_or(program.as_os_str());
    let words = std::iter::once(program).chain(command.get_args());
    words.map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shown_without_path() {
        let mut command = Command::new("/opt/toolchain/bin/cargo");
        command.args(["test", "--workspace"]);
        assert_eq!(shown(&command), "cargo test --workspace", "the path is left out");
    }

    #[test]
    fn has_subcommand_that_is_there() {
        assert!(has_subcommand("fmt"));
        assert!(!has_subcommand("no-such-command"));
    }

    #[test]
    fn output_failure_names_command() {
        let error = output(cargo(Path::new(".")).arg("no-such-command")).unwrap_err().to_string();
        assert!(error.starts_with("`cargo no-such-command` failed"), "message: {error}");
    }
}
