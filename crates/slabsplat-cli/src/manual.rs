//! `slabsplat completions` and `slabsplat manual`: what shells and `man` know of the program, made of the
//! same definitions as its help.

use crate::terminal;
use anyhow::{Context, Result};
use clap::{Args, Command};
use clap_complete::Shell;
use std::path::{Path, PathBuf};

/// The program, as it is typed.
const NAME: &str = "slabsplat";

/// Print what makes a shell complete commands, flags and their values
#[derive(Args)]
pub(crate) struct CompletionsArgs {
    /// For which shell
    shell: Shell,
}

pub(crate) fn print_completions(args: &CompletionsArgs, mut command: Command) -> Result<()> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut command, NAME, &mut script);
    terminal::answer(&String::from_utf8_lossy(&script))
}

/// Write man pages and completions for all shells, as packages of systems have them
#[derive(Args)]
pub(crate) struct ManualArgs {
    /// The folder for them; it is made if it is not there
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
}

pub(crate) fn write(args: &ManualArgs, mut command: Command) -> Result<()> {
    let pages = folder(&args.folder.join("man1"))?;
    let completions = folder(&args.folder.join("completions"))?;
    for shell in [Shell::Bash, Shell::Elvish, Shell::Fish, Shell::PowerShell, Shell::Zsh] {
        clap_complete::generate_to(shell, &mut command, NAME, &completions)
            .with_context(|| cannot_write(&completions))?;
    }
    clap_mangen::generate_to(command, &pages).with_context(|| cannot_write(&pages))?;
    terminal::say(format_args!(
        "man pages in {}, completions in {}",
        pages.display(),
        completions.display()
    ));
    Ok(())
}

fn folder(path: &Path) -> Result<PathBuf> {
    std::fs::create_dir_all(path)
        .with_context(|| format!("cannot make the folder {}", path.display()))?;
    Ok(path.to_owned())
}

fn cannot_write(folder: &Path) -> String {
    format!("cannot write to the folder {}", folder.display())
}
