//! `cargo xtask bench peers`: slabsplat against VTK's ray caster, and another renderer that is at hand, on
//! the same scenes on the same machine.
//!
//! VTK is what a user without a GPU would pick instead. All turn the camera by a degree a frame and time
//! twelve frames or so; here they take turns, so that a machine that grows warm or busy slows all, and each
//! pair of neighbours is a ratio of its own. VTK is run by `xtask/bench/peers/vtk_raycast.py`. OSPRay, the
//! fastest that we know, takes a quarter of an hour to build: whoever has done so names a command in
//! `SLABSPLAT_PEERS_OSPRAY` that takes a scene and `--frames N`, as that script does, and whose last line of
//! output is JSON with `median_ms`, too.

use std::env;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use serde_json::Value;
use slabsplat_testdata::{LARGE_SCENES, SCENES};

use super::options::parse_counts;
use super::program::{Program, Run};
use super::python;
use super::table::{markdown, median, rounded};
use xtask::process::output;
use xtask::workspace::Workspace;

/// How much is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Options {
    pub(super) n_frames: usize,
    pub(super) n_pairs: usize,
    /// Pixels along a side, if not as many as scenes say.
    pub(super) side: Option<usize>,
}

impl Options {
    /// What all contenders are told.
    fn flags(&self) -> Vec<String> {
        let side = self.side.map(|side| side.to_string());
        let flags = ["--width", "--height"].into_iter().zip(side.iter().cycle());
        flags.flat_map(|(flag, side)| [flag.to_owned(), side.clone()]).collect()
    }
}

/// A way in which slabsplat draws the scenes.
struct Contender {
    name: &'static str,
    flags: &'static [&'static str],
}

/// A command that draws them otherwise.
struct Peer {
    name: &'static str,
    program: PathBuf,
    args: Vec<&'static str>,
}

const OSPRAY_VARIABLE: &str = "SLABSPLAT_PEERS_OSPRAY";

const OURS: &[Contender] = &[
    Contender { name: "slabsplat", flags: &[] },
    Contender { name: "slabsplat, exact", flags: &["--tolerance", "0", "--opacity-cutoff", "1"] },
    Contender { name: "slabsplat, slab width 2", flags: &["--slab-width", "2"] },
    Contender { name: "slabsplat, densities", flags: &["--method", "post-classified"] },
];

/// The peer knows no scene without `[classify]`: it leaves this one out.
const NO_SCENE_OF_PEERS: &str = "embryo-perspective";

const SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/peers/vtk_raycast.py");

pub(super) fn parse(args: &[OsString]) -> Result<Options, String> {
    let (mut n_frames, mut n_pairs, mut side) = (12, 5, 0);
    let counts =
        &mut [("--frames", &mut n_frames), ("--pairs", &mut n_pairs), ("--side", &mut side)];
    parse_counts(args, counts)?;
    Ok(Options { n_frames, n_pairs, side: (side != 0).then_some(side) })
}

pub(super) fn run(options: &Options) -> Result<()> {
    let names = SCENES.iter().chain(LARGE_SCENES).filter(|name| **name != NO_SCENE_OF_PEERS);
    let found = |name: &&'static str| Some((*name, slabsplat_testdata::scene(name)?));
    let scenes: Vec<(&str, PathBuf)> = names.filter_map(found).collect();
    ensure!(!scenes.is_empty(), "there is no scene on which to compare");
    let arena = Arena { peers: peers()?, program: Program::built()?, options: *options };
    for (name, path) in scenes {
        println!("\n## {name}\n\n{}", arena.measure(&path)?);
    }
    println!("A ratio is the peer's median over ours: above 1, slabsplat is faster.");
    Ok(())
}

/// VTK, and OSPRay if there is a command that runs it.
fn peers() -> Result<Vec<Peer>> {
    let python = python::with_vtk(&Workspace::read()?.target_directory)?;
    let vtk = [("VTK, sample a voxel", "1.0"), ("VTK, two samples a voxel", "0.5")];
    let vtk = vtk.map(|(name, sample)| {
        let args = vec![SCRIPT, "--sample", sample];
        Peer { name, program: python.clone(), args }
    });
    let named = env::var_os(OSPRAY_VARIABLE).filter(|named| !named.is_empty());
    let ospray =
        named.map(|named| Peer { name: "OSPRay", program: named.into(), args: Vec::new() });
    Ok(vtk.into_iter().chain(ospray).collect())
}

/// What all contenders are run with.
struct Arena {
    peers: Vec<Peer>,
    program: Program,
    options: Options,
}

impl Arena {
    /// The table of a scene.
    fn measure(&self, scene: &Path) -> Result<String> {
        let mut ms = vec![Vec::new(); self.peers.len() + OURS.len()];
        for pair in 0..self.options.n_pairs {
            for nth in turns(pair, self.peers.len()) {
                let (name, median_ms) = self.run(nth, scene)?;
                eprintln!("bench: pair {}: {name}: {median_ms:.1} ms", pair + 1);
                ms[nth].push(median_ms);
            }
        }
        let names: Vec<&str> = self.peers.iter().map(|peer| peer.name).collect();
        Ok(table(&names, &ms))
    }

    /// The median of the `nth` contender, peers first.
    fn run(&self, nth: usize, scene: &Path) -> Result<(&'static str, f64)> {
        if let Some(peer) = self.peers.get(nth) {
            return Ok((peer.name, self.run_peer(peer, scene)?));
        }
        let ours = &OURS[nth - self.peers.len()];
        let run = Run {
            input: scene.into(),
            flags: ours.flags.iter().map(ToString::to_string).chain(self.options.flags()).collect(),
            n_frames: self.options.n_frames,
            n_threads: None,
        };
        Ok((ours.name, self.program.bench(&run)?.median_ms))
    }

    fn run_peer(&self, peer: &Peer, scene: &Path) -> Result<f64> {
        let mut command = Command::new(&peer.program);
        command.args(&peer.args).arg(scene);
        command.args(["--frames", &self.options.n_frames.to_string()]);
        command.args(self.options.flags());
        peer_median_ms(&output(&mut command)?)
    }
}

/// The contenders in the order of a pair: a peer next to one of ours, and every other pair backwards, so that
/// nobody is always the first.
fn turns(pair: usize, n_peers: usize) -> Vec<usize> {
    let n = n_peers.max(OURS.len());
    let mut turns: Vec<usize> = (0..n)
        .flat_map(|idx| {
            let peer = (idx < n_peers).then_some(idx);
            let ours = (idx < OURS.len()).then_some(n_peers + idx);
            peer.into_iter().chain(ours)
        })
        .collect();
    if pair % 2 == 1 {
        turns.reverse();
    }
    turns
}

/// A peer's last line is JSON; what it says before is not.
fn peer_median_ms(answer: &str) -> Result<f64> {
    let line = answer.lines().last().context("the peer answers nothing")?;
    let answer: Value =
        serde_json::from_str(line).with_context(|| format!("the peer answers {line:?}"))?;
    answer["median_ms"].as_f64().context("the peer reports no `median_ms`")
}

/// Milliseconds and then ratios, pair by pair and their medians; `ms` is of each contender, peers first.
fn table(peers: &[&str], ms: &[Vec<f64>]) -> String {
    let n_pairs = ms.first().map_or(0, Vec::len);
    let pairs = (1..=n_pairs).map(|pair| format!("pair {pair}"));
    let head: Vec<String> =
        [String::new()].into_iter().chain(pairs).chain(["median".to_owned()]).collect();
    let (of_peers, of_ours) = ms.split_at(peers.len());
    let names = peers.iter().copied().chain(OURS.iter().map(|ours| ours.name));
    let mut rows: Vec<Vec<String>> =
        names.zip(ms).map(|(name, ms)| row(format!("{name}, ms"), ms)).collect();
    for (peer, peer_ms) in peers.iter().zip(of_peers) {
        for (ours, our_ms) in OURS.iter().zip(of_ours) {
            let ratios: Vec<f64> = peer_ms.iter().zip(our_ms).map(|(a, b)| a / b).collect();
            rows.push(row(format!("{peer} : {}", ours.name), &ratios));
        }
    }
    markdown(&head, &rows)
}

fn row(name: String, numbers: &[f64]) -> Vec<String> {
    let cells = numbers.iter().chain([&median(numbers)]).map(|&number| rounded(number)).collect();
    [vec![name], cells].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_are_of_all_and_alternate() {
        assert_eq!(turns(0, 2), [0, 2, 1, 3, 4, 5], "peer, ours, peer, ours, ours, ours");
        assert_eq!(turns(1, 2), [5, 4, 3, 1, 2, 0], "backwards");
        assert_eq!(turns(2, 2), turns(0, 2));
        assert_eq!(turns(0, 3), [0, 3, 1, 4, 2, 5, 6], "with another peer");
    }

    #[test]
    fn peer_answer_is_its_last_line() {
        let answer = "Generic Warning: In vtk.cxx\n{\"median_ms\": 141.5, \"threads\": 2}\n";
        assert_eq!(peer_median_ms(answer).unwrap(), 141.5);
        for wrong in ["", "no JSON\n", "{}\n"] {
            assert!(peer_median_ms(wrong).is_err(), "{wrong:?}");
        }
    }

    #[test]
    fn table_has_medians_and_ratios() {
        let peers = [[100.0, 300.0], [200.0, 600.0]];
        let ours = [[50.0, 100.0], [80.0, 80.0], [20.0, 60.0], [90.0, 90.0]];
        let ms = [peers.as_slice(), &ours].concat();
        let names = ["VTK, sample a voxel", "VTK, two samples a voxel"];
        let text = table(&names, &ms.iter().map(|ms| ms.to_vec()).collect::<Vec<_>>());
        assert_eq!(text.lines().count(), 2 + 6 + 8, "{text}");
        for line in [
            "|  | pair 1 | pair 2 | median |",
            "| VTK, sample a voxel, ms | 100 | 300 | 200 |",
            "| slabsplat, slab width 2, ms | 20.0 | 60.0 | 40.0 |",
            "| VTK, sample a voxel : slabsplat | 2.00 | 3.00 | 2.50 |",
            "| VTK, two samples a voxel : slabsplat, slab width 2 | 10.0 | 10.0 | 10.0 |",
        ] {
            assert!(text.lines().any(|found| found == line), "{line} in\n{text}");
        }
    }
}
