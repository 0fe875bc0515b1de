//! Whether a volume is likely to fit: a machine that swaps measures its disk, and one without swap ends the
//! program.

use std::fs;

use anyhow::{Result, ensure};

/// What a relevant voxel takes at most, in bytes: the volume around it, its record, and its share of a range
/// of depth. The haze of the largest balls, 100 to 240 million relevant voxels, takes 18.
const BYTES_PER_RELEVANT: u64 = 20;

/// An error if so many relevant voxels are not likely to fit. Where nothing is known of memory, they are
/// tried.
pub(super) fn check(n_relevant: u64) -> Result<()> {
    let needed = n_relevant * BYTES_PER_RELEVANT;
    let Some(available) = available() else { return Ok(()) };
    ensure!(
        needed <= available,
        "it may take {} GiB of memory, and {} are free",
        needed.div_ceil(1 << 30),
        available >> 30
    );
    Ok(())
}

/// As Linux reports.
fn available() -> Option<u64> {
    available_in(&fs::read_to_string("/proc/meminfo").ok()?)
}

fn available_in(meminfo: &str) -> Option<u64> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib << 10)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn available_of_linux() {
        let meminfo = "MemTotal:       24652672 kB\nMemAvailable:   23119048 kB\n";
        assert_eq!(available_in(meminfo), Some(23_119_048 << 10));
        assert_eq!(available_in("MemFree: 1 kB\n"), None, "an old kernel");
    }

    #[test]
    fn check_nothing_fits() {
        assert!(check(0).is_ok());
    }
}
