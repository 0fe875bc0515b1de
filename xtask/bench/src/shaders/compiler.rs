//! Mesa's Vulkan driver for AMD, told that it has a GPU.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};

use super::assembly::innermost_loop;
use super::record::{Counts, Record};
use xtask::process::output;
use xtask::test_build;

/// Where Linux distributions list Vulkan's drivers, and how this one's list begins.
const DRIVERS: &str = "/usr/share/vulkan/icd.d";
const DRIVER: &str = "radeon_icd";

/// The GPU that is compiled for: a Radeon RX 6800.
const GPU: &str = "navi21";

/// The driver, if it is installed.
pub(super) fn driver() -> Option<PathBuf> {
    let files = std::fs::read_dir(DRIVERS).ok()?.filter_map(Result::ok);
    let mut found: Vec<PathBuf> = files
        .filter(|file| file.file_name().to_string_lossy().starts_with(DRIVER))
        .map(|file| file.path())
        .collect();
    found.sort();
    found.into_iter().next()
}

/// What it makes of all shaders, by a program of `slabsplat-ash`, as only that crate speaks to Vulkan.
pub(super) fn count(root: &Path, driver: &Path) -> Result<Record> {
    let mut program = Command::new(test_build::example(root, "compiled")?);
    program
        .env("VK_DRIVER_FILES", driver)
        .env("VK_ICD_FILENAMES", driver)
        .env("RADV_FORCE_FAMILY", GPU)
        .env("NODEVICE_SELECT", "1");
    read(&output(&mut program)?)
}

/// What the program prints.
fn read(text: &str) -> Result<Record> {
    let mut parts = text.split("\nshader ");
    let device = parts.next().and_then(|line| line.strip_prefix("device "));
    let device = device.context("no device is named")?.trim().to_owned();
    let shader = |part: &str| {
        let (name, rest) = part.split_once('\n').context("a shader has no lines")?;
        Ok((name.to_owned(), counts(rest).with_context(|| name.to_owned())?))
    };
    let shaders = parts.map(shader).collect::<Result<_>>()?;
    Ok(Record { device, shaders })
}

fn counts(lines: &str) -> Result<Counts> {
    let count = |name: &str| {
        let named =
            |line: &str| line.strip_prefix("count ")?.strip_suffix(name)?.trim().parse().ok();
        lines.lines().find_map(named).with_context(|| format!("the driver does not tell: {name}"))
    };
    let code = lines.lines().filter_map(|line| line.strip_prefix("code "));
    Ok(Counts {
        innermost_loop: innermost_loop(code),
        instructions: count(" Instructions")?,
        registers: count(" VGPRs")?,
        workgroup_bytes: count(" LDS size")?,
        subgroups: count(" Subgroups per SIMD")?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn read_what_is_printed() {
        let text = "device a GPU, a driver\nshader splat\ncount 128 SGPRs\ncount 80 VGPRs\ncount 9 LDS size\n\
                    count 12 Subgroups per SIMD\ncount 7 Instructions\ncount 71 Pre-Sched VGPRs\n\
                    code BB0:\ncode \tds_read_b32 v0\ncode \ts_branch BB0\n";
        let record = read(text).unwrap();
        assert_eq!(record.device, "a GPU, a driver");
        let expected = Counts {
            innermost_loop: 2,
            instructions: 7,
            registers: 80,
            workgroup_bytes: 9,
            subgroups: 12,
        };
        assert_eq!(record.shaders["splat"], expected);
        assert!(read("nothing").is_err() && read("device a\nshader b\ncount 1 VGPRs").is_err());
    }
}
