//! `slabsplat backends`.

use crate::{answer, json};

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
