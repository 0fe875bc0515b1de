//! `slabsplat render --distributed`: ranks that are processes, whole, failing, killed and stopped.
//!
//! They need the feature `mpi` and `mpirun`; without these a line says that they are skipped, and if
//! `SLABSPLAT_REQUIRE_MPI` is set they fail.

use crate::{answer, diagnostic, names_in, text};
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

/// A scene that leaves nothing open.
const SCENE: &str = "[volume]\npath = \"ball.nii\"\n[classify]\nopacity = [[20.0, 0.0], [200.0, 0.4]]\n\
    color = [[20.0, 1.0, 0.2, 0.1], [200.0, 0.3, 0.9, 1.0]]\n[camera]\nprojection = \"orthographic\"\n\
    eye = [200.0, 130.0, 160.0]\ntarget = [0.0, 0.0, 0.0]\nup = [0.0, 0.0, 1.0]\nview_height = 90.0\n\
    [image]\nwidth = 80\nheight = 60\nbackground = [0.1, 0.2, 0.3, 1.0]\n\
    [render]\ntolerance = 0.0\nopacity_cutoff = 1.0\n";

const REQUIRE_MPI: &str = "SLABSPLAT_REQUIRE_MPI";

/// Whether ranks can be started; if not, that is said.
fn has_ranks() -> bool {
    let why = if !cfg!(feature = "mpi") {
        "slabsplat was built without the feature mpi"
    } else if Command::new("mpirun").arg("--version").output().is_err() {
        "there is no mpirun"
    } else {
        return true;
    };
    assert!(std::env::var_os(REQUIRE_MPI).is_none(), "{REQUIRE_MPI} is set, but {why}");
    println!("skipped: {why}");
    false
}

fn write_scene(folder: &Path) {
    answer(folder, "convert builtin:sphere:64 ball.nii");
    std::fs::write(folder.join("scene.toml"), SCENE).expect("the folder can be written to");
}

/// `mpirun` with ranks of several kinds: how many, and which command of a shell each runs, in which
/// `$SLABSPLAT` is the program.
fn mpirun(folder: &Path, kinds: &[(usize, &str)]) -> Output {
    let mut command = Command::new("mpirun");
    command
        .current_dir(folder)
        .stdin(Stdio::null())
        .env("SLABSPLAT", env!("CARGO_BIN_EXE_slabsplat"))
        .env("OMPI_ALLOW_RUN_AS_ROOT", "1")
        .env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")
        .args(["--oversubscribe", "--bind-to", "none"]);
    for (idx, (n_ranks, line)) in kinds.iter().enumerate() {
        if 0 < idx {
            command.arg(":");
        }
        command.args(["-n", &n_ranks.to_string(), "sh", "-c", line]);
    }
    command.output().expect("mpirun starts")
}

/// Ranks that must succeed, all by the same arguments.
fn distributed(folder: &Path, n_ranks: usize, args: &str) -> String {
    let output = mpirun(folder, &[(n_ranks, &format!("exec $SLABSPLAT {args} --distributed"))]);
    assert!(output.status.success(), "{n_ranks} ranks, {args}: {}", text(&output.stderr));
    text(&output.stdout)
}

/// Ranks that must fail in time, without a picture; what they and `mpirun` say.
fn fail(folder: &Path, kinds: &[(usize, &str)]) -> String {
    let started = Instant::now();
    let output = mpirun(folder, kinds);
    let stderr = text(&output.stderr);
    assert!(!output.status.success(), "{kinds:?}: {stderr}");
    assert!(started.elapsed() < Duration::from_secs(60), "{kinds:?}: {:?}", started.elapsed());
    let names = names_in(folder);
    assert!(!names.iter().any(|name| name.contains("out.")), "no part of a picture: {names:?}");
    stderr
}

/// The one line that the program itself said.
fn said(stderr: &str) -> &str {
    let mut lines = stderr.lines().filter(|line| line.starts_with("error: "));
    let line = lines.next().unwrap_or_else(|| panic!("nothing was said: {stderr}"));
    assert_eq!(lines.next(), None, "one line: {stderr}");
    line
}

fn off(folder: &Path, [a, b]: [&str; 2]) -> f32 {
    let pixels = |name: &str| {
        let image = image::open(folder.join(name)).expect("a picture was written");
        image.to_rgba32f().into_raw()
    };
    let (a, b) = (pixels(a), pixels(b));
    assert_eq!(a.len(), b.len());
    a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn distributed_changes_no_picture() {
    if !has_ranks() {
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    write_scene(dir.path());
    answer(dir.path(), "render scene.toml --backend cpu -o whole.exr");
    answer(dir.path(), "render scene.toml --memory 1GiB -o parts.exr");
    for n_ranks in [1, 2, 3, 4, 5, 8] {
        let done = distributed(dir.path(), n_ranks, "render scene.toml --json -o ranks.exr");
        let done: serde_json::Value = serde_json::from_str(&done).unwrap();
        let ranks = done["ranks"].as_array().unwrap();
        assert_eq!(ranks.len(), n_ranks, "{done}");
        for rank in ranks {
            let of = |name: &str| rank[name].as_u64().unwrap();
            assert!(0 < of("n_splats") && of("n_voxels_read") < 64 * 64 * 64 || n_ranks == 1);
            assert!(of("peak_bytes") <= of("memory_bytes"), "{rank}");
        }
        let worst = off(dir.path(), ["whole.exr", "ranks.exr"]);
        assert!(worst < 1e-5, "{n_ranks} ranks: {worst}");
        if n_ranks == 1 {
            assert_eq!(off(dir.path(), ["parts.exr", "ranks.exr"]), 0.0, "the same sums");
        }
    }
    // What a scene file leaves open is found of the same overview on all ranks.
    distributed(dir.path(), 3, "render ball.nii --width 50 --height 50 -o found.png --stats");
    assert!(dir.path().join("found.png").is_file());
}

/// The brain, where it is: packed, so that one of the ranks unpacks it for all of this computer.
#[test]
fn distributed_brain() {
    const PACKED: &str = "nifti/mni152_t1_1mm_uint8.nii.gz";
    if !has_ranks() {
        return;
    }
    let Some(volume) = slabsplat_testdata::volume(PACKED) else { return };
    let dir = tempfile::tempdir().unwrap();
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/scenes");
    let scene = std::fs::read_to_string(scenes.join("brain.toml")).unwrap();
    let found = scene.replace(&format!("../data/{PACKED}"), &volume.display().to_string());
    assert_ne!(found, scene, "the scene is of that volume");
    std::fs::write(dir.path().join("brain.toml"), found).unwrap();
    let args = "render brain.toml --tolerance 0 --opacity-cutoff 1 --width 300 --height 300";
    answer(dir.path(), &format!("{args} --backend cpu -o whole.exr"));
    for n_ranks in [2, 5] {
        distributed(dir.path(), n_ranks, &format!("{args} -o ranks.exr --scratch ."));
        let worst = off(dir.path(), ["whole.exr", "ranks.exr"]);
        assert!(worst < 1e-5, "{n_ranks} ranks: {worst}");
        assert_eq!(names_in(dir.path()), ["brain.toml", "ranks.exr", "whole.exr"], "no scratch");
    }
}

/// What all know before they read, and what one alone cannot read.
#[test]
fn distributed_failures_are_said_once() {
    if !has_ranks() {
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    write_scene(dir.path());
    let run = |args: &str| format!("exec $SLABSPLAT render {args} --distributed");
    let scene = run("scene.toml -o out.exr");
    answer(dir.path(), "convert ball.nii ball.nii.gz");
    for (args, expected) in [
        ("none.toml -o out.exr", "none.toml"),
        ("scene.toml -o none/out.exr", "none"),
        ("scene.toml -o out.exr --mode maximum", "not the mode maximum"),
        ("scene.toml -o out.exr --memory 1MiB", "too few"),
        ("ball.nii.gz -o out.exr --scratch nowhere", "nowhere"),
    ] {
        let stderr = fail(dir.path(), &[(3, &run(args))]);
        let line = said(&stderr);
        assert!(line.contains(expected), "{args}: {line}");
        // Only rank 0 looks where the picture goes, and unpacks.
        let is_of_rank_0 = args.contains("none/") || args.contains("nowhere");
        assert_eq!(line.contains("rank 0"), is_of_rank_0, "{args}: {line}");
    }
    // A disk that is full before the volume is unpacked.
    let full = format!("ulimit -f 8; {}", run("ball.nii.gz -o out.exr --scratch ."));
    let stderr = fail(dir.path(), &[(1, &full), (2, &run("ball.nii.gz -o out.exr --scratch ."))]);
    assert!(
        said(&stderr).contains("rank 0") && said(&stderr).contains("File too large"),
        "{stderr}"
    );
    // Another computer, as it were, on which the volume is not.
    std::fs::create_dir(dir.path().join("elsewhere")).unwrap();
    std::fs::write(dir.path().join("elsewhere/scene.toml"), SCENE).unwrap();
    let elsewhere = format!("cd elsewhere; {scene}");
    let stderr = fail(dir.path(), &[(2, &scene), (1, &elsewhere), (1, &scene)]);
    assert!(said(&stderr).contains("rank 2") && said(&stderr).contains("ball.nii"), "{stderr}");
    // One on which it is another.
    answer(&dir.path().join("elsewhere"), "convert builtin:sphere:48 ball.nii");
    let stderr = fail(dir.path(), &[(2, &scene), (1, &elsewhere)]);
    assert!(said(&stderr).contains("same volume"), "{stderr}");
}

/// Ranks that end by a signal while all draw, that hang, and that may have no more memory.
#[test]
fn distributed_ranks_die() {
    if !has_ranks() {
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    write_scene(dir.path());
    let scene = "exec $SLABSPLAT render scene.toml -o out.exr --width 2400 --height 2400 --distributed \
                 --patience 3";
    // As the shell becomes the program, this is its number.
    let after = |signal: &str| format!("(sleep 0.7; kill -{signal} $$) & {scene}");
    let stderr = fail(dir.path(), &[(1, scene), (1, &after("KILL")), (1, scene)]);
    assert!(stderr.contains("rank 1") && stderr.contains("signal 9"), "{stderr}");
    let stderr = fail(dir.path(), &[(1, &after("KILL")), (2, scene)]);
    assert!(stderr.contains("rank 0"), "{stderr}");
    let stderr = fail(dir.path(), &[(2, scene), (1, &after("STOP"))]);
    assert!(said(&stderr).contains("rank 2 has been silent"), "{stderr}");
    let stderr = fail(dir.path(), &[(1, &after("STOP")), (2, scene)]);
    assert!(said(&stderr).contains("rank 0 has been silent"), "{stderr}");
    let little = format!("ulimit -v 450000; {scene}");
    let stderr = fail(dir.path(), &[(2, scene), (1, &little)]);
    assert!(stderr.contains("memory"), "{stderr}");
}

/// Frames come from all ranks, and are those of one process; what one cannot draw ends all.
#[test]
fn distributed_films_are_those_of_one_process() {
    if !has_ranks() {
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    let args = "turntable builtin:sphere:24 --frames 7 --width 40 --height 40 --backend cpu";
    answer(dir.path(), &format!("{args} -o one.png-sequence --no-metadata"));
    distributed(dir.path(), 3, &format!("{args} -o ranks.png-sequence --no-metadata"));
    let names = names_in(&dir.path().join("one.png-sequence"));
    assert_eq!(names, names_in(&dir.path().join("ranks.png-sequence")));
    for name in names.iter().filter(|name| name.ends_with(".png")) {
        let frame = |film: &str| std::fs::read(dir.path().join(film).join(name)).unwrap();
        assert!(frame("one.png-sequence") == frame("ranks.png-sequence"), "{name}");
    }
    let bad = "exec $SLABSPLAT turntable none.nii -o out.gif --distributed";
    let stderr = fail(dir.path(), &[(3, bad)]);
    assert!(said(&stderr).contains("none.nii"), "{stderr}");
}

#[test]
fn distributed_needs_its_feature() {
    if cfg!(feature = "mpi") {
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    write_scene(dir.path());
    let said = diagnostic(dir.path(), "render scene.toml --distributed -o out.exr");
    assert!(said.contains("--features mpi"), "{said}");
}
