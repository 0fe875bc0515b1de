//! Packages that the tests can use, installed where that can be done without asking anyone.
//!
//! That is on a Debian of some kind whose root we are; elsewhere there is a sentence that tells people what to do.

use std::env;
use std::process::Command;

use anyhow::Result;

use crate::process::output;

/// Whether what is missing can be installed.
#[derive(Debug, PartialEq)]
pub(crate) enum Installer {
    /// This is a Debian of some kind, and we are its root.
    Apt,
    None,
    /// It has been tried already, with this complaint, if any.
    Tried(Option<String>),
}

impl Installer {
    /// That of this machine.
    pub(crate) fn of_machine() -> Self {
        let path = env::var_os("PATH").unwrap_or_default();
        let has_apt = env::split_paths(&path).any(|folder| folder.join("apt-get").is_file());
        if has_apt && is_root() { Self::Apt } else { Self::None }
    }

    /// What helps if nothing is installed any more.
    pub(crate) fn remedy(&self, packages: &[&str]) -> String {
        match self {
            Self::Apt | Self::None => {
                let packages = packages.join(" ");
                format!(
                    "on Debian or Ubuntu `apt-get install --no-install-recommends {packages}` helps"
                )
            }
            Self::Tried(Some(complaint)) => complaint.clone(),
            Self::Tried(None) => "what was installed is not found".to_owned(),
        }
    }
}

/// Tries. Prints nothing: what apt-get says is in the complaint, if there is one.
pub(crate) fn install(packages: &[&str]) -> Installer {
    Installer::Tried(try_to_install(packages).err().map(|error| on_one_line(&error)))
}

fn try_to_install(packages: &[&str]) -> Result<()> {
    let updated = output(apt_get().arg("update"));
    let install = ["install", "-y", "--no-install-recommends"];
    let installed = output(apt_get().args(install).args(packages));
    // Lists may be old or partly out of reach and still good enough; if not, that is why.
    if installed.is_err() {
        updated?;
    }
    installed.map(drop)
}

fn apt_get() -> Command {
    let mut command = Command::new("apt-get");
    command.env("DEBIAN_FRONTEND", "noninteractive");
    command
}

fn is_root() -> bool {
    output(Command::new("id").arg("-u")).is_ok_and(|uid| uid.trim() == "0")
}

/// What apt-get complains of takes many lines.
fn on_one_line(error: &anyhow::Error) -> String {
    format!("{error:#}").split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn on_one_line_joins() {
        let error = anyhow::anyhow!("E: a\n   E: b\n").context("`apt-get` failed");
        assert_eq!(on_one_line(&error), "`apt-get` failed: E: a E: b", "lines and their indents");
    }

    #[test]
    fn remedy_names_packages_or_the_complaint() {
        let remedy = Installer::None.remedy(&["a", "b"]);
        assert!(remedy.contains("install --no-install-recommends a b`"), "{remedy}");
        assert_eq!(Installer::Tried(Some("E: no".to_owned())).remedy(&["a"]), "E: no");
    }
}
