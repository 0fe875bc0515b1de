//! What is measured: quantities that change one at a time, and pictures for which they do.

use std::ffi::OsString;
use std::path::PathBuf;
use std::thread;

/// A quantity that changes while all else stays.
pub(super) struct Sweep {
    /// The plot, in `docs/images/`.
    pub(super) file: &'static str,
    pub(super) title: &'static str,
    /// What is counted along the x axis.
    pub(super) unit: &'static str,
    /// Whether x is what the program counts, not what was asked for.
    pub(super) counts_voxels: bool,
    /// What stands at a tick of the x axis.
    pub(super) label: fn(f64) -> String,
    /// The power of x by which a frame grows if all of it grows, or shrinks, with x.
    pub(super) ideal_power: f64,
    pub(super) steps: Vec<Step>,
}

/// A point of a sweep.
#[derive(Default)]
pub(super) struct Step {
    pub(super) x: f64,
    pub(super) flags: Vec<String>,
    /// Voxels along the side of the built-in volume, where not the usual.
    pub(super) side: Option<usize>,
    /// Voxels that it makes relevant, where that may be too many.
    pub(super) n_relevant: Option<u64>,
    pub(super) n_threads: Option<usize>,
}

/// What is drawn.
pub(super) struct Picture {
    pub(super) name: &'static str,
    source: Source,
    pub(super) flags: &'static [&'static str],
}

enum Source {
    /// Of any size.
    Ball,
    Scene(PathBuf),
}

/// A ball of so many voxels along its volume's side has 1.7 million relevant ones, about as many as the
/// brain.
const BALL_SIDE: usize = 192;

/// The radius of a ball in sides of its volume, and how far its edge reaches beyond, in voxel steps.
const BALL_RADIUS: f64 = 0.375;
const BALL_EDGE: f64 = 1.9;

/// The relevant voxels of the balls that grow.
const N_RELEVANT: &[u64] =
    &[100_000, 300_000, MIN_MAX_VOXELS, 3_000_000, 10_000_000, 30_000_000, MAX_VOXELS];

/// As many as are ever drawn, and the fewest that still make a curve.
pub(super) const MAX_VOXELS: u64 = 100_000_000;
pub(super) const MIN_MAX_VOXELS: u64 = 1_000_000;

const OPAQUE: &[&str] = &["--opacity", "0:0,255:0.8"];
const HAZE: &[&str] = &["--opacity", "0:0,255:0.02"];

/// The balls, and the scenes whose volume is there.
pub(super) fn pictures() -> Vec<Picture> {
    let ball = |name, flags| Picture { name, source: Source::Ball, flags };
    let scene = |(name, scene)| {
        let path = slabsplat_testdata::scene(scene)?;
        Some(Picture { name, source: Source::Scene(path), flags: &[] })
    };
    let balls = [ball("ball, opaque", OPAQUE), ball("ball, haze", HAZE)];
    let scenes = [("brain, opaque", "brain"), ("brain, haze", "brain-haze")];
    balls.into_iter().chain(scenes.into_iter().filter_map(scene)).collect()
}

/// With at most so many relevant voxels.
pub(super) fn all(max_voxels: u64) -> Vec<Sweep> {
    vec![voxels(max_voxels), pixels(), slab_width(), threads()]
}

impl Picture {
    pub(super) fn input(&self, step: &Step) -> OsString {
        match &self.source {
            Source::Ball => format!("builtin:sphere:{}", step.side.unwrap_or(BALL_SIDE)).into(),
            Source::Scene(path) => path.into(),
        }
    }
}

impl Sweep {
    pub(super) fn takes(&self, picture: &Picture) -> bool {
        // A volume on disk has the voxels that it has.
        matches!(picture.source, Source::Ball) || self.steps.iter().all(|step| step.side.is_none())
    }

    /// Where x is asked for, a tick a step; where it is counted, powers of ten.
    pub(super) fn ticks(&self) -> Vec<f64> {
        let xs = self.steps.iter().map(|step| step.x);
        if !self.counts_voxels {
            return xs.collect();
        }
        xs.filter(|x| x.log10().fract().abs() < 1e-9).collect()
    }

    pub(super) fn last_x(&self) -> f64 {
        self.steps.last().map_or(1.0, |step| step.x)
    }
}

fn superscript(digit: u32) -> char {
    ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'].get(digit as usize).copied().unwrap_or('ⁿ')
}

fn voxels(max_voxels: u64) -> Sweep {
    let step = |n_relevant: u64| Step {
        x: n_relevant as f64,
        side: Some(ball_side(n_relevant)),
        n_relevant: Some(n_relevant),
        ..Step::default()
    };
    let counts = N_RELEVANT.iter().copied().filter(|&n_relevant| n_relevant <= max_voxels);
    Sweep {
        file: "scaling-voxels.svg",
        title: "Time against relevant voxels, 512² pixels",
        unit: "relevant voxels",
        counts_voxels: true,
        label: |x| format!("10{}", superscript(x.log10().round() as u32)),
        ideal_power: 1.0,
        steps: counts.map(step).collect(),
    }
}

/// The side of the ball that has about so many voxels with a value.
fn ball_side(n_relevant: u64) -> usize {
    let radius = (0.75 / std::f64::consts::PI * n_relevant as f64).cbrt();
    ((radius - BALL_EDGE) / BALL_RADIUS).round() as usize
}

fn pixels() -> Sweep {
    let step = |side: u32| {
        let flags = ["--width", &side.to_string(), "--height", &side.to_string()];
        Step {
            x: f64::from(side).powi(2),
            flags: flags.map(str::to_owned).to_vec(),
            ..Step::default()
        }
    };
    Sweep {
        file: "scaling-pixels.svg",
        title: "Time against pixels",
        unit: "pixels",
        counts_voxels: false,
        label: |x| format!("{}²", x.sqrt()),
        ideal_power: 1.0,
        steps: [256, 512, 1024, 2048].map(step).into(),
    }
}

fn slab_width() -> Sweep {
    let step = |width: f64| Step {
        x: width,
        flags: ["--slab-width", &width.to_string()].map(str::to_owned).to_vec(),
        ..Step::default()
    };
    Sweep {
        file: "scaling-slab-width.svg",
        title: "Time against slab width, 512² pixels",
        unit: "slab width in voxel steps",
        counts_voxels: false,
        label: |x| x.to_string(),
        ideal_power: -1.0,
        steps: [0.5, 1.0, 2.0, 4.0].map(step).into(),
    }
}

/// Powers of two, and all that there are.
fn threads() -> Sweep {
    let n_cores = thread::available_parallelism().map_or(2, usize::from);
    let mut counts: Vec<usize> =
        (0..).map(|power| 1 << power).take_while(|&n| n < n_cores).collect();
    counts.push(n_cores.max(2));
    let step = |n: usize| Step { x: n as f64, n_threads: Some(n), ..Step::default() };
    Sweep {
        file: "scaling-threads.svg",
        title: "Time against threads, 512² pixels",
        unit: "threads",
        counts_voxels: false,
        label: |x| x.to_string(),
        ideal_power: -1.0,
        steps: counts.into_iter().map(step).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sweeps_rise() {
        for sweep in all(MAX_VOXELS) {
            assert!(2 <= sweep.steps.len(), "{}", sweep.file);
            assert!(sweep.steps.is_sorted_by(|a, b| a.x < b.x), "{}", sweep.file);
        }
    }

    #[test]
    fn sweeps_of_fewer_voxels_end_earlier() {
        assert_eq!(all(MAX_VOXELS)[0].last_x(), 1e8);
        assert_eq!(all(29_999_999)[0].last_x(), 1e7);
        assert_eq!(all(MIN_MAX_VOXELS)[0].ticks(), [1e5, 1e6]);
    }

    #[test]
    fn sweeps_of_voxels_are_of_balls_only() {
        let of_disk = Picture { name: "", source: Source::Scene("a.toml".into()), flags: &[] };
        let taken: Vec<&str> = all(MAX_VOXELS)
            .iter()
            .filter(|sweep| sweep.takes(&of_disk))
            .map(|sweep| sweep.file)
            .collect();
        assert!(!taken.contains(&"scaling-voxels.svg") && taken.len() == 3, "{taken:?}");
    }

    #[test]
    fn pictures_begin_with_balls() {
        let step = Step { side: Some(9), ..Step::default() };
        let inputs: Vec<OsString> = pictures().iter().take(2).map(|p| p.input(&step)).collect();
        assert_eq!(inputs, ["builtin:sphere:9", "builtin:sphere:9"]);
    }
}
