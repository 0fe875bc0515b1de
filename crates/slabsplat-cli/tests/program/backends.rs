//! `slabsplat backends`.

use crate::{answer, json, names_in, program, text};

#[test]
fn backends_text_lists_the_cpu() {
    let dir = tempfile::tempdir().unwrap();
    let text = answer(dir.path(), "backends");
    assert!(text.starts_with("backend  device"), "{text}");
    let cpu =
        text.lines().find(|line| line.starts_with("cpu ")).unwrap_or_else(|| panic!("{text}"));
    assert!(cpu.contains("CPU threads"), "{cpu}");
    assert!(text.lines().last().unwrap().starts_with("auto takes "), "{text}");
}

#[test]
fn backends_json_says_of_each_what_it_has_or_why_not() {
    let dir = tempfile::tempdir().unwrap();
    let answer = json(dir.path(), "backends --json");
    let backends = answer["backends"].as_array().unwrap();
    for backend in backends {
        let n_devices = backend["devices"].as_array().unwrap().len();
        assert_eq!(n_devices == 0, backend["unavailable"].is_string(), "{backend}");
    }
    let names: Vec<_> = backends.iter().map(|backend| backend["name"].as_str().unwrap()).collect();
    assert_eq!(names.last(), Some(&"cpu"), "in the order in which auto tries them");
    assert!(names.contains(&answer["auto"]["backend"].as_str().unwrap()), "{answer}");
}

/// Mesa's drivers, as wgpu opens them, complain of a variable that containers lack.
#[test]
fn backends_that_work_say_nothing_else() {
    let dir = tempfile::tempdir().unwrap();
    for args in ["backends", "render builtin:cube:9 -o a.png --width 16 --height 16 --backend wgpu"]
    {
        let output = program(dir.path(), args).output().unwrap();
        let stderr = text(&output.stderr);
        assert!(!stderr.contains("XDG_RUNTIME_DIR"), "{args}: {stderr}");
        if args != "backends" {
            let lines: Vec<&str> = stderr.lines().collect();
            let is_both = |lines: &[&str]| matches!(lines, [shown, picture] if shown.starts_with("shown as ") && picture.starts_with("a.png: "));
            assert!(is_both(&lines), "{args}: {stderr}");
        }
    }
}

/// As on a machine that has no graphics driver: what asks for one fails in one line, and `auto` draws.
#[test]
fn backends_without_a_driver() {
    let dir = tempfile::tempdir().unwrap();
    let run = |args: &str| {
        let mut command = program(dir.path(), args);
        command.env("VK_DRIVER_FILES", "/nowhere.json").env("VK_ICD_FILENAMES", "/nowhere.json");
        command.output().unwrap()
    };
    let listed = text(&run("backends").stdout);
    for name in ["ash", "wgpu"] {
        assert!(listed.contains(&format!("{name} is not available: ")), "{listed}");
        let output = run(&format!("render builtin:cube:9 -o {name}.png --backend {name}"));
        let stderr = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{stderr}");
        let expected = format!("error: the backend \"{name}\" is not available: ");
        assert!(stderr.starts_with(&expected) && stderr.lines().count() == 1, "{stderr}");
        assert!(stderr.contains("; --backend auto draws by what there is"), "{stderr}");
    }
    assert!(run("render builtin:cube:9 -o auto.png --backend auto").status.success());
    assert_eq!(names_in(dir.path()), ["auto.png"]);
}
