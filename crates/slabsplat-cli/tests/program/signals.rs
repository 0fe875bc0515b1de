//! Interrupted: nothing half-written is left behind.

use crate::{answer, names_in, program};
use std::io::{BufRead, BufReader};
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};

const SIGHUP: i32 = 1;
const SIGINT: i32 = 2;
const SIGTERM: i32 = 15;

/// Starts to draw a picture that takes a while to be written.
fn start(directory: &Path) -> Child {
    let args = "render builtin:cube:8 -o large.png --width 3000 --height 3000 --backend cpu";
    let mut command = program(directory, args);
    command.stderr(Stdio::null()).spawn().expect("the program starts")
}

fn send(signal: i32, child: &Child) {
    let mut kill = Command::new("kill");
    kill.arg(format!("-{signal}")).arg(child.id().to_string());
    assert!(kill.status().expect("there is a kill").success());
}

/// Sends a signal once something is being written, unless all is written before that is noticed.
fn interrupted(signal: i32, directory: &Path) -> ExitStatus {
    let mut child = start(directory);
    loop {
        if let Some(status) = child.try_wait().expect("it is our child") {
            return status;
        }
        if names_in(directory).iter().any(|name| name.ends_with(".part")) {
            send(signal, &child);
            return child.wait().expect("it is our child");
        }
        std::thread::yield_now();
    }
}

/// Whether these tests, and so the programs that they start, are run by something that has a signal ignored,
/// as `nohup` has the first and a shell the second of what it runs in the background.
pub(crate) fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let ignored = ignored.and_then(|bits| u64::from_str_radix(bits.trim(), 16).ok());
    ignored.is_some_and(|bits| bits >> (signal - 1) & 1 == 1)
}

/// A file that may not become so large is an error, and what there was of it is gone.
#[test]
fn limit_of_files_leaves_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let program = env!("CARGO_BIN_EXE_slabsplat");
    let args = "render builtin:cube:8 -o a.exr --width 300 --height 300 --backend cpu";
    let mut command = Command::new("sh");
    command.arg("-c").arg(format!("ulimit -f 8; exec {program} {args}"));
    let output = command.current_dir(dir.path()).output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert!(stderr.contains("error: cannot write a.exr: File too large"), "{stderr}");
    assert_eq!((output.status.code(), names_in(dir.path())), (Some(1), Vec::new()));
}

#[test]
fn signal_while_writing_leaves_a_whole_picture() {
    for signal in [SIGHUP, SIGINT, SIGTERM].into_iter().filter(|signal| !is_ignored(*signal)) {
        let dir = tempfile::tempdir().unwrap();
        let status = (0..20).map(|_| interrupted(signal, dir.path())).find(|s| !s.success());
        assert_eq!(status.and_then(|status| status.signal()), Some(signal));
        assert_eq!(names_in(dir.path()), ["large.png"]);
        let bytes = std::fs::read(dir.path().join("large.png")).unwrap();
        assert!(bytes.starts_with(b"\x89PNG") && bytes.ends_with(b"IEND\xaeB\x60\x82"), "{signal}");
    }
}

/// A volume that is being unpacked is gone with the program, however that ends.
#[test]
fn signal_while_unpacking_leaves_no_scratch() {
    const SIGKILL: i32 = 9;
    let dir = tempfile::tempdir().unwrap();
    answer(dir.path(), "convert builtin:sphere:256 ball.nii.gz");
    std::fs::create_dir(dir.path().join("scratch")).unwrap();
    let args =
        "render ball.nii.gz -o a.png --memory 1GiB --scratch scratch --width 2000 --height 2000";
    for signal in [SIGINT, SIGTERM, SIGKILL].into_iter().filter(|signal| !is_ignored(*signal)) {
        let mut command = program(dir.path(), args);
        let mut child = command.stderr(Stdio::piped()).spawn().expect("the program starts");
        let mut stderr = BufReader::new(child.stderr.take().expect("it is piped"));
        let mut line = String::new();
        stderr.read_line(&mut line).unwrap();
        assert!(line.contains("is unpacked into scratch"), "{line}");
        send(signal, &child);
        assert_eq!(child.wait().unwrap().signal(), Some(signal));
        assert_eq!(names_in(&dir.path().join("scratch")), [""; 0]);
    }
    assert!(!names_in(dir.path()).contains(&"a.png".to_owned()));
}

#[test]
fn signal_before_writing_leaves_no_part() {
    let dir = tempfile::tempdir().unwrap();
    let mut child = start(dir.path());
    std::thread::sleep(std::time::Duration::from_millis(30));
    send(SIGTERM, &child);
    assert_eq!(child.wait().unwrap().signal(), Some(SIGTERM));
    assert!(names_in(dir.path()).iter().all(|name| !name.ends_with(".part")));
}
