//! What a frame drew and cost, as `render --stats` tells it.

use crate::columns;
use slabsplat::{Caps, Frame, FrameCost, FrameStats, StageTime};

/// One line for each number, aligned, without a line break at the end.
pub(crate) fn text(frame: &Frame, caps: &Caps) -> String {
    let Frame { stats, cost, .. } = frame;
    let mut rows = stage_rows(&cost.stages);
    rows.extend(count_rows(stats));
    rows.extend([("resident", resident(cost)), ("backend", executor(caps))]);
    let rows: Vec<[String; 2]> =
        rows.into_iter().map(|(key, value)| [key.to_owned(), value]).collect();
    columns::aligned(&rows).trim_end().to_owned()
}

/// What executed a frame: `ash on NVIDIA H100`.
pub(crate) fn executor(caps: &Caps) -> String {
    format!("{} on {}", caps.name, caps.device)
}

fn stage_rows(stages: &[StageTime]) -> Vec<(&'static str, String)> {
    if stages.is_empty() {
        return vec![("stages", "not timed: the device has no timestamps".to_owned())];
    }
    stages.iter().map(|stage| (stage.name, format!("{:10.3} ms", stage.ms))).collect()
}

fn count_rows(stats: &FrameStats) -> [(&'static str, String); 5] {
    let FrameStats { n_voxels, n_splats, n_culled, n_tiles, n_full_tiles } = *stats;
    [
        ("voxels", n_voxels),
        ("splatted", n_splats),
        ("culled", n_culled),
        ("tiles", n_tiles),
        ("full tiles", n_full_tiles),
    ]
    .map(|(key, count)| (key, format!("{count:>10}")))
}

fn resident(cost: &FrameCost) -> String {
    let exact = cost.resident_bytes;
    match columns::bytes(exact) {
        rounded if rounded.ends_with("bytes") => rounded,
        rounded => format!("{rounded} ({exact} bytes)"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat::Image;

    fn frame(stages: Vec<StageTime>) -> Frame {
        Frame {
            image: Image::filled(1, 1, [0.0; 4]),
            stats: FrameStats {
                n_voxels: 1,
                n_splats: 22,
                n_culled: 333,
                n_tiles: 4,
                n_full_tiles: 5,
            },
            cost: FrameCost { stages, resident_bytes: 3 << 20 },
        }
    }

    #[test]
    fn stats_are_aligned() {
        let caps = Caps { name: "ash", device: "Fake 3000".to_owned() };
        let stages =
            vec![StageTime { name: "project", ms: 0.25 }, StageTime { name: "splat", ms: 12.5 }];
        let expected = "\
project          0.250 ms
splat           12.500 ms
voxels               1
splatted            22
culled             333
tiles                4
full tiles           5
resident    3.0 MiB (3145728 bytes)
backend     ash on Fake 3000";
        assert_eq!(text(&frame(stages), &caps), expected);
        let untimed = text(&frame(Vec::new()), &caps);
        assert!(untimed.starts_with("stages      not timed: the device has no timestamps\n"));
    }
}
