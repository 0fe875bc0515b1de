//! How much memory a test took.

use std::fs;

/// Address space that the whole process may have taken: threads and their pools need some.
const MAX_PEAK_BYTES: u64 = 1 << 30;

/// The most address space that this process ever had, where the system reports it.
fn peak_bytes() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmPeak:"))?;
    line.trim().strip_suffix(" kB")?.trim().parse().ok().map(|kib: u64| kib * 1024)
}

pub(crate) fn check_peak(after: &str) {
    if let Some(peak) = peak_bytes() {
        assert!(peak < MAX_PEAK_BYTES, "{} MiB were taken, after {after}", peak >> 20);
    }
}
