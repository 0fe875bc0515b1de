//! `slabsplat demo`.

use crate::{answer, names_in};

#[test]
fn demo_writes_what_it_says() {
    let dir = tempfile::tempdir().unwrap();
    let text = answer(dir.path(), "demo made/here");
    let names = names_in(&dir.path().join("made/here"));
    assert_eq!(names.len(), 20, "five volumes by four methods: {names:?}");
    for name in &names {
        assert!(text.lines().any(|line| line.starts_with(&format!("{name} "))), "{name} in {text}");
    }
    let ratio = |method: &str| {
        let is_row = |line: &&str| line.starts_with(method) && line.ends_with("degrees");
        let row = text.lines().find(is_row).unwrap_or_else(|| panic!("{method} in {text}"));
        row.split_whitespace().nth(1).unwrap().parse::<f64>().unwrap()
    };
    assert!(ratio("image-aligned") < 1.5, "the paper's method does not pop: {text}");
    assert!(ratio("post-classified") < 1.5, "nor does what classifies later: {text}");
    assert!(10.0 < ratio("axis-aligned"), "the traditional one does: {text}");
}
