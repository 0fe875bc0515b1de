//! What a frame drew and cost, as `render --stats` and `bench` tell it.

use crate::columns;
use slabsplat::{Caps, Frame, FrameCost, FrameStats};

/// What a number is, and the number.
type Row = (&'static str, String);

/// One line for each number, aligned, without a line break at the end.
pub(crate) fn text(frame: &Frame, caps: &Caps) -> String {
    let Frame { stats, cost, .. } = frame;
    let mut rows = stage_rows(cost.stages.iter().map(|stage| (stage.name, stage.ms)));
    rows.extend(splat_rows(stats));
    rows.extend([count("tiles", stats.n_tiles), count("saturated tiles", stats.n_saturated_tiles)]);
    rows.extend([("resident", resident(cost)), ("backend", executor(caps))]);
    columns::pairs(rows).trim_end().to_owned()
}

/// What executed a frame: `ash on NVIDIA H100`.
pub(crate) fn executor(caps: &Caps) -> String {
    format!("{} on {}", caps.name, caps.device)
}

/// A row for each stage and its milliseconds, or one that says why there are none.
pub(crate) fn stage_rows(stages: impl Iterator<Item = (&'static str, f64)>) -> Vec<Row> {
    let rows: Vec<Row> = stages.map(|(name, ms)| (name, milliseconds(ms))).collect();
    if rows.is_empty() {
        return vec![("stages", "not timed: the device has no timestamps".to_owned())];
    }
    rows
}

/// Rows of what was splatted.
pub(crate) fn splat_rows(stats: &FrameStats) -> [Row; 4] {
    [
        count("voxels", stats.n_voxels),
        count("occluded", stats.n_occluded),
        count("splatted", stats.n_splats),
        count("culled", stats.n_culled),
    ]
}

fn count(key: &'static str, count: u64) -> Row {
    (key, format!("{count:>10}"))
}

/// A time, aligned with counts.
pub(crate) fn milliseconds(ms: f64) -> String {
    format!("{ms:10.3} ms")
}

/// The bytes that the backend keeps.
pub(crate) fn resident(cost: &FrameCost) -> String {
    let exact = cost.resident_bytes;
    match columns::bytes(exact) {
        rounded if rounded.ends_with("bytes") => rounded,
        rounded => format!("{rounded} ({exact} bytes)"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat::{Image, Method, StageTime};

    fn frame(stages: Vec<StageTime>) -> Frame {
        let mut stats = FrameStats::default();
        (stats.n_voxels, stats.n_splats, stats.n_culled) = (1, 22, 333);
        (stats.n_tiles, stats.n_saturated_tiles) = (4, 5);
        Frame::new(Image::filled(1, 1, [0.0; 4]), stats, FrameCost::new(stages, 3 << 20))
    }

    #[test]
    fn stats_are_aligned() {
        let caps = Caps::new("ash", "Fake 3000", Method::ALL);
        let stages = vec![StageTime::new("project", 0.25), StageTime::new("splat", 12.5)];
        let expected = "\
project               0.250 ms
splat                12.500 ms
voxels                    1
occluded                  0
splatted                 22
culled                  333
tiles                     4
saturated tiles           5
resident         3.0 MiB (3145728 bytes)
backend          ash on Fake 3000";
        assert_eq!(text(&frame(stages), &caps), expected);
        let untimed = text(&frame(Vec::new()), &caps);
        assert!(untimed.starts_with("stages           not timed: the device has no timestamps\n"));
    }
}
