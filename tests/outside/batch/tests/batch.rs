//! Two scenes, of which one cannot be read: the other is rendered all the same.

use std::fs;
use std::process::Command;

const BALL: &str = r#"
[volume]
generate = "sphere"
size = 16

[image]
width = 32
height = 24
"#;

#[test]
fn goes_on_past_a_broken_scene() {
    let folder = tempfile::tempdir().unwrap();
    let [broken, ball] = ["broken.toml", "ball.toml"].map(|name| folder.path().join(name));
    fs::write(&broken, "[volume]\ngenerate = \"no such thing\"\n").unwrap();
    fs::write(&ball, BALL).unwrap();

    let run = Command::new(env!("CARGO_BIN_EXE_batch")).args([&broken, &ball]).output().unwrap();
    let told = String::from_utf8(run.stderr).unwrap();
    assert!(!run.status.success(), "one scene failed");
    assert!(told.contains("no such thing"), "{told}");
    assert!(told.contains("1 of 2 scenes rendered"), "{told}");

    let png = fs::read(ball.with_extension("png")).unwrap();
    assert!(png.starts_with(b"\x89PNG"), "a picture");
    // Width and height, big-endian, stand at a fixed offset in every PNG.
    assert_eq!(&png[16..24], [0, 0, 0, 32, 0, 0, 0, 24]);
}
