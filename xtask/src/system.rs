//! What some tests need beside Rust, from the system's packages: for each command that installs, a list.
//!
//! Nothing is installed unless `--install` says so, and then by apt-get; otherwise a line says what is
//! missing.
//! No graphics card is needed: Mesa's lavapipe, a Vulkan driver that draws on the CPU, does.
//! Whether a driver finds a device is not asked here: the tests say so when they run, and fail for want of
//! one if `SLABSPLAT_REQUIRE_GPU` is set, and for want of MPI if `SLABSPLAT_REQUIRE_MPI` is.
//! Only Linux is looked after: elsewhere drivers come with the system, and the tests skip by themselves.

use std::env;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};
use xtask::process::{output, starts};
use xtask::test_build;

pub(crate) struct Need {
    name: &'static str,
    /// Of Debian and its descendants.
    packages: &'static [&'static str],
    is_there: fn() -> bool,
}

/// What `cargo xtask test` needs.
pub(crate) const TESTS: &[Need] = &[
    Need {
        name: "a Vulkan driver",
        packages: &["libvulkan1", "mesa-vulkan-drivers"],
        is_there: || has_loader() && has_driver(),
    },
    Need {
        // Not to run, but to notice what a driver forgives.
        name: "Vulkan's validation layer",
        packages: &["vulkan-validationlayers"],
        is_there: has_validation,
    },
    Need {
        // For what the shaders are translated to.
        name: "SPIR-V's validator",
        packages: &["spirv-tools"],
        is_there: || starts("spirv-val"),
    },
    Need { name: "valgrind", packages: &["valgrind"], is_there: has_valgrind },
    Need {
        name: "MPI",
        packages: &["openmpi-bin", "libopenmpi-dev", "gcc", "libc6-dev"],
        is_there: test_build::has_mpi,
    },
    Need {
        // For a window that nobody sees, and who uses it and looks at it.
        name: "a display in memory",
        packages: &[
            "xvfb",
            "xdotool",
            "imagemagick",
            "libxkbcommon-x11-0",
            "libxcursor1",
            "libxi6",
            "libxrandr2",
        ],
        is_there: || is_in_path("Xvfb") && is_in_path("xdotool") && is_in_path("import"),
    },
];

/// What `cargo xtask web` needs. It has a Vulkan driver of its own.
pub(crate) const BROWSER: &[Need] =
    &[Need { name: "Chromium", packages: &["chromium"], is_there: has_chromium }];

/// Where Vulkan's folders are, `icd.d` for drivers and `explicit_layer.d` for layers.
const VULKAN_FOLDERS: &[&str] =
    &["/usr/share/vulkan", "/etc/vulkan", "/usr/local/share/vulkan", "/usr/local/etc/vulkan"];

/// Installs what is missing for `cargo xtask COMMAND`, if `is_told_to`, and says what still is.
pub(crate) fn set_up(command: &str, needs: &'static [Need], is_told_to: bool) {
    if is_told_to
        && let missing = missing(needs)
        && !missing.is_empty()
        && let Err(error) = install(command, &missing)
    {
        eprintln!("{command}: {error:#}");
    }
    let missing = missing(needs);
    if !missing.is_empty() {
        eprintln!("{command}: {}", lack(command, &missing));
    }
}

/// Whether instructions can be counted.
pub(crate) fn has_valgrind() -> bool {
    starts("valgrind")
}

/// Whether there is a browser.
pub(crate) fn has_chromium() -> bool {
    starts("chromium")
}

/// Whether there is a program of that name; what some of them say of themselves opens displays.
fn is_in_path(program: &str) -> bool {
    let is_there = |folder: PathBuf| folder.join(program).is_file();
    env::var_os("PATH").is_some_and(|path| env::split_paths(&path).any(is_there))
}

fn missing(needs: &'static [Need]) -> Vec<&'static Need> {
    if cfg!(target_os = "linux") {
        needs.iter().filter(|need| !(need.is_there)()).collect()
    } else {
        Vec::new()
    }
}

fn install(command: &str, missing: &[&Need]) -> Result<()> {
    let packages = packages(missing);
    eprintln!("{command}: installing {}", packages.join(", "));
    let apt_get = |args: &[&str]| {
        output(Command::new("apt-get").args(args).env("DEBIAN_FRONTEND", "noninteractive"))
    };
    // Lists may be old or partly out of reach and still good enough; if not, that is why.
    let updated = apt_get(&["update"]);
    apt_get(&[&["install", "-y", "--no-install-recommends"], &packages[..]].concat())
        .or_else(|error| updated.and(Err(error)))
        .context("packages are only installed by apt-get, and by root")?;
    Ok(())
}

/// One line: what is missing, what that means, what helps.
fn lack(command: &str, missing: &[&Need]) -> String {
    let names: Vec<&str> = missing.iter().map(|need| need.name).collect();
    format!(
        "missing: {}; what needs it is skipped. `cargo xtask {command} --install`, as root on Debian or \
         Ubuntu, installs {}",
        names.join(", "),
        packages(missing).join(", ")
    )
}

fn packages(missing: &[&Need]) -> Vec<&'static str> {
    missing.iter().flat_map(|need| need.packages).copied().collect()
}

fn has_loader() -> bool {
    let library = "libvulkan.so.1";
    // Users other than root need not have ldconfig in their path.
    let knows = |ldconfig| {
        output(Command::new(ldconfig).arg("-p")).is_ok_and(|cache| cache.contains(library))
    };
    listed_in("LD_LIBRARY_PATH").any(|folder| folder.join(library).exists())
        || ["ldconfig", "/sbin/ldconfig"].into_iter().any(knows)
}

fn has_driver() -> bool {
    // Where one of these is set, somebody knows better than we do; the second is the first's old name.
    let named = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"].into_iter().flat_map(listed_in);
    named.count() != 0 || vulkan_folders().any(|folder| has_json(&folder.join("icd.d")))
}

fn has_validation() -> bool {
    let folders = vulkan_folders().map(|folder| folder.join("explicit_layer.d"));
    let mut folders = folders.chain(listed_in("VK_LAYER_PATH"));
    folders.any(|folder| folder.join("VkLayer_khronos_validation.json").exists())
}

fn vulkan_folders() -> impl Iterator<Item = PathBuf> {
    let of_session = listed_in("XDG_DATA_DIRS").map(|folder| folder.join("vulkan"));
    VULKAN_FOLDERS.iter().map(PathBuf::from).chain(of_session)
}

fn has_json(folder: &Path) -> bool {
    fs::read_dir(folder).is_ok_and(|mut entries| {
        entries.any(|e| e.is_ok_and(|e| e.path().extension() == Some(OsStr::new("json"))))
    })
}

fn listed_in(variable: &str) -> impl Iterator<Item = PathBuf> + use<> {
    let value = env::var_os(variable).unwrap_or_default();
    let paths: Vec<PathBuf> = env::split_paths(&value).collect();
    paths.into_iter().filter(|path| !path.as_os_str().is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lack_is_one_line_with_a_remedy() {
        let text = lack("test", &TESTS.iter().collect::<Vec<_>>());
        assert!(!text.contains('\n'), "{text}");
        let parts =
            ["a Vulkan driver, Vulkan's", "`cargo xtask test --install`", "libvulkan1, mesa"];
        for part in parts {
            assert!(text.contains(part), "{text:?} contains {part:?}");
        }
    }

    #[test]
    fn what_is_not_there() {
        let root = xtask::workspace::root();
        assert!(!has_json(&root.join("xtask")), "a folder without");
        assert!(!has_json(&root.join("no-such-folder")), "no folder");
        assert!(!starts("no-such-program"), "no program");
        assert_eq!(listed_in("SLABSPLAT_NO_SUCH_VARIABLE").count(), 0, "not set");
    }
}
