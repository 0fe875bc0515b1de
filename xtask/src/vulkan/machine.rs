//! What this machine has of Vulkan.
//!
//! Files are looked for where the loader itself looks, as far as distributions and the usual variables go.
//! A program is started only if a file is not found: a machine that has all of them pays for a few look-ups.

use std::env;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::Need;
use crate::process::output;

const LOADER: &str = "libvulkan.so.1";
const VALIDATION: &str = "VkLayer_khronos_validation.json";

/// Where Vulkan's folders are, `icd.d` for drivers and `explicit_layer.d` for layers.
const FOLDERS: &[&str] =
    &["/usr/share/vulkan", "/etc/vulkan", "/usr/local/share/vulkan", "/usr/local/etc/vulkan"];

pub(super) fn missing() -> Vec<Need> {
    let found = [
        (Need::Loader, has_loader()),
        (Need::Driver, has_driver()),
        (Need::Validation, has_validation()),
    ];
    found.into_iter().filter(|(_, is_found)| !is_found).map(|(need, _)| need).collect()
}

fn has_loader() -> bool {
    let arch = env::consts::ARCH;
    let usual = ["/lib", "/lib64", "/usr/lib", "/usr/lib64", "/usr/local/lib"].map(PathBuf::from);
    let debian = PathBuf::from(format!("/usr/lib/{arch}-linux-gnu"));
    let mut folders = usual.into_iter().chain([debian]).chain(listed_in("LD_LIBRARY_PATH"));
    folders.any(|folder| folder.join(LOADER).exists()) || cache_has(LOADER)
}

/// Whether the linker knows the library, wherever that is.
fn cache_has(library: &str) -> bool {
    // Users other than root need not have it in their path.
    ["ldconfig", "/sbin/ldconfig"].into_iter().any(|ldconfig| {
        output(Command::new(ldconfig).arg("-p")).is_ok_and(|cache| cache.contains(library))
    })
}

fn has_driver() -> bool {
    // The loader looks nowhere else if one of these is set; the second is the first's old name.
    for variable in ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"] {
        if env::var_os(variable).is_some_and(|value| !value.is_empty()) {
            return listed_in(variable).any(|path| path.is_file() || has_json(&path));
        }
    }
    vulkan_folders().any(|folder| has_json(&folder.join("icd.d")))
        || listed_in("VK_ADD_DRIVER_FILES").any(|path| path.is_file() || has_json(&path))
}

fn has_validation() -> bool {
    let folders = vulkan_folders().map(|folder| folder.join("explicit_layer.d"));
    let more = listed_in("VK_LAYER_PATH").chain(listed_in("VK_ADD_LAYER_PATH"));
    folders.chain(more).any(|folder| folder.join(VALIDATION).exists())
}

fn vulkan_folders() -> impl Iterator<Item = PathBuf> {
    let of_user = env::home_dir().map(|home| home.join(".local/share/vulkan"));
    let of_session = listed_in("XDG_DATA_DIRS").map(|folder| folder.join("vulkan"));
    FOLDERS.iter().map(PathBuf::from).chain(of_user).chain(of_session)
}

fn has_json(folder: &Path) -> bool {
    fs::read_dir(folder).is_ok_and(|entries| {
        let mut names = entries.flatten().map(|entry| entry.path());
        names.any(|path| path.extension() == Some(OsStr::new("json")))
    })
}

fn listed_in(variable: &str) -> impl Iterator<Item = PathBuf> + use<> {
    let value = env::var_os(variable).unwrap_or_default();
    env::split_paths(&value)
        .filter(|path| !path.as_os_str().is_empty())
        .collect::<Vec<_>>()
        .into_iter()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn has_json_only_there() {
        let root = crate::workspace::root();
        assert!(!has_json(&root.join("xtask")), "a folder without");
        assert!(!has_json(&root.join("no-such-folder")), "no folder");
    }

    #[test]
    fn cache_has_no_such_library() {
        assert!(!cache_has("libno-such-library.so.1"), "not in any cache");
    }

    #[test]
    fn listed_in_nothing() {
        assert_eq!(listed_in("SLABSPLAT_NO_SUCH_VARIABLE").count(), 0, "not set");
    }
}
