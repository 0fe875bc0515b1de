//! What a rank had to do, collected on rank 0.

use crate::Traffic;
use slabsplat::{FrameStats, ShareCost};

/// What a rank had to do for a picture.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct RankReport {
    /// The name of its computer.
    pub node: String,
    /// Threads that it worked on.
    pub n_threads: u64,
    /// Voxels of its box of the largest volume.
    pub n_voxels_in_box: u64,
    /// Relevant voxels that it drew, those around its box included.
    pub n_voxels: u64,
    /// Splats, one a section.
    pub n_splats: u64,
    /// Boxes that it drew one by one.
    pub n_boxes: u64,
    /// Voxels that it read, those around boxes included.
    pub n_voxels_read: u64,
    /// Their bytes.
    pub n_bytes_read: u64,
    /// Messages that it sent.
    pub n_messages_sent: u64,
    /// Their bytes.
    pub n_bytes_sent: u64,
    /// Pixels of its picture that are not empty.
    pub n_pixels: u64,
    /// The most memory that it had, in bytes; 0 where the system does not tell.
    pub peak_bytes: u64,
    /// What it may have, as it counts.
    pub memory_bytes: u64,
    /// Seconds of reading its boxes.
    pub reading_secs: f64,
    /// Seconds of reading and drawing them.
    pub drawing_secs: f64,
    /// Seconds of waiting for the slowest rank after that.
    pub waiting_secs: f64,
    /// Seconds of compositing.
    pub compositing_secs: f64,
}

/// Numbers of a report, in the order of its fields.
const N_NUMBERS: usize = 16;

impl RankReport {
    pub(crate) fn add_drawn(&mut self, stats: &FrameStats, cost: &ShareCost) {
        self.n_voxels = stats.n_voxels;
        self.n_splats = stats.n_splats;
        self.n_boxes = cost.n_boxes[0] as u64;
        self.n_voxels_read = cost.n_voxels_read;
        self.n_bytes_read = cost.n_bytes_read;
        self.reading_secs = cost.reading_secs;
    }

    pub(crate) fn add_sent(&mut self, sent: Traffic) {
        self.n_messages_sent = sent.n_messages;
        self.n_bytes_sent = sent.n_bytes;
        self.peak_bytes = peak_bytes().unwrap_or(0);
    }

    /// Counts up to 2⁵³ are exact.
    pub(crate) fn to_bytes(&self) -> Vec<u8> {
        let counts = [
            self.n_threads,
            self.n_voxels_in_box,
            self.n_voxels,
            self.n_splats,
            self.n_boxes,
            self.n_voxels_read,
            self.n_bytes_read,
            self.n_messages_sent,
            self.n_bytes_sent,
            self.n_pixels,
            self.peak_bytes,
            self.memory_bytes,
        ];
        let secs = [self.reading_secs, self.drawing_secs, self.waiting_secs, self.compositing_secs];
        let numbers = counts.into_iter().map(|count| count as f64).chain(secs);
        let mut bytes: Vec<u8> = numbers.flat_map(f64::to_le_bytes).collect();
        bytes.extend(self.node.as_bytes());
        bytes
    }

    pub(crate) fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let (numbers, node) = bytes.split_at_checked(8 * N_NUMBERS)?;
        let numbers: Vec<f64> =
            numbers.as_chunks().0.iter().map(|number| f64::from_le_bytes(*number)).collect();
        let count = |idx: usize| numbers[idx] as u64;
        Some(Self {
            node: String::from_utf8_lossy(node).into_owned(),
            n_threads: count(0),
            n_voxels_in_box: count(1),
            n_voxels: count(2),
            n_splats: count(3),
            n_boxes: count(4),
            n_voxels_read: count(5),
            n_bytes_read: count(6),
            n_messages_sent: count(7),
            n_bytes_sent: count(8),
            n_pixels: count(9),
            peak_bytes: count(10),
            memory_bytes: count(11),
            reading_secs: numbers[12],
            drawing_secs: numbers[13],
            waiting_secs: numbers[14],
            compositing_secs: numbers[15],
        })
    }
}

/// The most memory that this process has had so far, where the system tells.
fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let (_, peak) = status.split_once("VmHWM:")?;
    let kib: u64 = peak.split_whitespace().next()?.parse().ok()?;
    Some(kib << 10)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn report_is_what_it_was() {
        let mut report = RankReport { node: "n7".to_owned(), ..RankReport::default() };
        report.n_voxels = 1 << 40;
        report.memory_bytes = 12;
        report.reading_secs = 0.25;
        report.compositing_secs = 1e-9;
        assert_eq!(RankReport::from_bytes(&report.to_bytes()), Some(report));
        assert_eq!(RankReport::from_bytes(&[0; 127]), None);
    }
}
