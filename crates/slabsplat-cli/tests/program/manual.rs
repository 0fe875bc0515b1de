//! `slabsplat completions` and `slabsplat manual`.

use crate::{answer, names_in};
use std::path::Path;

#[test]
fn completions_know_commands_and_choices() {
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = answer(Path::new("."), &format!("completions {shell}"));
        for expected in
            ["batch", "--slab-width", "post-classified"].map(|word| word.trim_start_matches('-'))
        {
            assert!(script.contains(expected), "{shell}: {expected}");
        }
    }
}

#[test]
fn manual_has_a_page_for_each_command() {
    let dir = tempfile::tempdir().unwrap();
    answer(dir.path(), "manual out");
    let pages = names_in(&dir.path().join("out/man1"));
    for expected in ["slabsplat.1", "slabsplat-render.1", "slabsplat-batch.1"] {
        assert!(pages.iter().any(|page| page == expected), "{expected}: {pages:?}");
    }
    assert!(pages.iter().all(|page| !page.contains("manual")), "a hidden command: {pages:?}");
    let page = std::fs::read_to_string(dir.path().join("out/man1/slabsplat-render.1")).unwrap();
    assert!(page.contains("slabsplat render head.nii.gz"), "the examples: {page}");
    assert_eq!(names_in(&dir.path().join("out/completions")).len(), 5);
}
