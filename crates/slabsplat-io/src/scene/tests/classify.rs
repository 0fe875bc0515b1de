//! Which values are visible.

use super::*;

#[test]
fn scene_classify_by_preset_or_file() {
    let bone = read_layer(&format!("{SMALL}[classify]\npreset = \"ct-bone\""));
    assert_eq!(bone.transfer, Some(preset("ct-bone").unwrap().source.transfer));
    assert_eq!(
        (bone.fit.scale, bone.fit.preset.as_deref()),
        (ValueScale::Hounsfield, Some("ct-bone"))
    );
    let white = read_layer(&format!("{SMALL}[classify]\nopacity = [[0, 0.5]]"));
    assert_eq!(white.transfer.unwrap().color(3.0), [1.0; 3]);

    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("map.json"), r#"[{"RGBPoints": [0, 1, 0, 0]}]"#).unwrap();
    let path = dir.path().join("scene.toml");
    fs::write(&path, format!("{SMALL}[classify]\nfile = \"map.json\"")).unwrap();
    let transfer = read_scene(&path).unwrap().layers.remove(0).transfer.unwrap();
    assert_eq!(transfer.color(0.0), [1.0, 0.0, 0.0]);
    fs::remove_file(dir.path().join("map.json")).unwrap();
    let err = read_scene(&path).unwrap_err().to_string();
    assert!(err.contains("map.json"), "{err}");
}

#[test]
fn scene_classify_fits_a_volume() {
    let fit = |keys: &str| read_layer(&format!("{SMALL}[classify]\n{keys}")).fit;
    let keys = "colormap = \"viridis\"\nwindow = [-5, 10]\nopacity_scale = 0.5\nunit_distance = 2";
    let full = fit(keys);
    assert_eq!(full.colormap, colormap("viridis").ok());
    assert_eq!(full.stretch, Some(Stretch::Window([-5.0, 10.0])));
    assert_eq!((full.opacity_scale, full.unit_distance), (0.5, Some(2.0)));
    let percentiles = fit("preset = \"mr-t1\"\npercentile = [1, 99.5]");
    assert_eq!(percentiles.stretch, Some(Stretch::Percentiles([1.0, 99.5])));
    assert_eq!(percentiles.scale, ValueScale::Object { percentile: 99.0 });
    // Light of a preset counts where the scene has none of its own.
    let shading =
        |rest: &str| read_layer(&format!("{SMALL}[classify]\npreset = \"xray\"\n{rest}")).shading;
    assert_eq!(shading(""), Shading::None);
    assert_eq!(shading("[shading]\nambient = 0.1"), Shading::Phong(Phong::default()));
}

/// Typical mistakes about transfer functions, and the lines that they are in.
#[test]
fn scene_classify_says_what_does_not_fit() {
    let check = |keys: &str, expected: &str| {
        let error = read(&format!("{SMALL}[classify]\n{keys}")).unwrap_err();
        assert!(error.contains(expected), "{error} should contain {expected}");
    };
    for (keys, expected) in [
        ("colormap = \"jet\"", ":5: there is no colour map \"jet\": choose one of viridis"),
        ("window = [5, 5]", ":5: a window goes from a value to a greater one, not from 5 to 5"),
        ("percentile = [90, 10]", ":5: percentiles go from 0 to 100 and rise, not from 90 to 10"),
        ("percentile = [0, 101]", ":5: percentiles go from 0 to 100"),
        ("window = [0, 1]\npercentile = [1, 2]", ":6: window and percentile both"),
        ("opacity = [[0, 1]]\nwindow = [0, 1]", ":6: a window or percentiles move presets"),
        (
            "opacity = [[0, 1]]\ncolor = [[0, 1, 1, 1]]\ncolormap = \"hot\"",
            ":7: color and colormap",
        ),
        ("opacity_scale = -1", ":5: opacity is scaled by a number of at least 0, not by -1"),
        ("unit_distance = 0", ":5: the unit distance of opacity is a positive length, not 0"),
        ("boxes = []\nopacity_scale = 2", ":6: opacity_scale is for functions of the value alone"),
        ("colourmap = \"hot\"", "did you mean \"colormap\"?"),
    ] {
        check(keys, expected);
    }
}

#[test]
fn scene_has_two_dimensional_transfer_functions() {
    let boxes = "[classify]\nboxes = [{ values = [2, 4], gradients = [1, inf], opacity = 0.5 }, { values \
                 = [5, 9], color = [1, 0, 0], fade = [2, 0] }]";
    let layer = read_layer(&format!("{SMALL}{boxes}"));
    let transfer = layer.transfer_2d.unwrap();
    assert!(layer.transfer.is_none() && (transfer.opacity(3.0, 7.0) - 0.5).abs() < 1e-12);
    assert_eq!(transfer.opacity(3.0, 0.5), 0.0);
    assert_eq!(transfer.at(6.0, 0.0).1, [1.0, 0.0, 0.0]);
    assert!((transfer.opacity(6.0, 0.0) - 0.5).abs() < 1e-12);
    let image = "[classify]\nimage = { file = \"no.png\", values = [0, 1], gradients = [0, 1] }";
    let error = read(&format!("{SMALL}{image}")).unwrap_err();
    assert!(error.contains("cannot read no.png"), "{error}");
}
