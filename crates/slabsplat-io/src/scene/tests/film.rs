//! `[film]`: what is read of it, and what is refused.

use slabsplat_core::Easing;

use crate::{FilmFile, IoError, parse_scene};

const CUBE: &str = "volume = { generate = \"cube\" }\n";

const TWO: &str = r#"
[[layers]]
name = "bone"
volume = { generate = "cube" }
[[layers]]
name = "implant"
mesh = { path = "a.stl" }
[[layers]]
name = "hidden"
visible = false
volume = { generate = "cube" }
[[layers]]
name = "skin"
volume = { generate = "sphere" }
"#;

fn film_of(text: &str) -> Result<FilmFile, IoError> {
    Ok(parse_scene(text, "a.toml")?.film.unwrap())
}

#[test]
fn film_keys_are_of_layers_by_name_or_number() {
    let film = film_of(&format!(
        "{TWO}[film]\nloop = true\neasing = \"ease-in\"\n[[film.keys]]\nat = 2\nlayers = [{{ layer = \"skin\", \
         opacity_scale = 0.5 }}, {{ layer = 0, classify = {{ preset = \"ct-bone\" }} }}, {{ layer = 2 }}]\n"
    ));
    let film = film.unwrap();
    assert_eq!((film.is_loop, film.easing, film.seconds), (true, Easing::EaseIn, None));
    let [key] = film.keys.as_slice() else { panic!("{film:?}") };
    let of =
        |layer: &crate::KeyLayerFile| (layer.layer_idx, layer.opacity_scale, layer.look.is_some());
    let layers: Vec<_> = key.layers.iter().map(of).collect();
    assert_eq!(layers, [(1, Some(0.5), false), (0, None, true)], "the hidden one is left out");
    let single = film_of(&format!("{CUBE}[[film.keys]]\nat = 0\nopacity_scale = 0\n")).unwrap();
    assert_eq!(single.keys[0].layers[0].layer_idx, 0);
    assert_eq!(parse_scene(CUBE, "a.toml").unwrap().film, None);
}

#[test]
fn film_diagnostics_name_key_and_line() {
    let check = |scene: &str, keys: &str, expected: &str| {
        let error = film_of(&format!("{scene}{keys}")).unwrap_err().to_string();
        assert_eq!(error, format!("a.toml:{expected}"));
    };
    check(CUBE, "[film]\nfps = 0\n", "3: fps must be a positive number, not 0");
    check(CUBE, "[film]\nlop = true\n", "3: unknown key \"lop\" in [film]; did you mean \"loop\"?");
    check(
        CUBE,
        "[[film.keys]]\nat = 1\neasing = \"bounce\"\n",
        "4: \"bounce\" is not a choice here: use one of linear, ease-in, ease-out, ease-in-out",
    );
    let order = "keys begin at 0, each is later than the one before";
    check(CUBE, "[[film.keys]]\nat = -1\n", &format!("3: key 0 of the film: at is -1: {order}"));
    let twice = "[[film.keys]]\nat = 1\n[[film.keys]]\nslab_width = 2\nat = 1\n";
    check(CUBE, twice, &format!("6: key 1 of the film: at is 1: {order}"));
    check(
        CUBE,
        "[[film.keys]]\nat = 1\n[[film.keys]]\nat = 2\n[film.keys.camera]\nview_height = 0\n",
        "7: key 1 of the film: view_height must be a positive number, not 0",
    );
    check(
        CUBE,
        "[[film.keys]]\nat = 1\n[film.keys.classify]\nboxes = []\n",
        "5: key 0 of the film: boxes does not change in a film: of [classify] a key takes opacity, color, preset, \
         colormap, window, percentile, opacity_scale, unit_distance and isosurfaces",
    );
    check(
        TWO,
        "[[film.keys]]\nat = 1\nopacity_scale = 0\n",
        "17: key 0 of the film: opacity_scale belongs below [[film.keys.layers]], with the layer that it is about",
    );
    for (layer, expected) in [
        ("9", "the scene has no layer 9"),
        ("\"skull\"", "the scene has no layer \"skull\""),
        ("\"implant\"", "that layer is a mesh, which does not change"),
    ] {
        let keys = format!("[[film.keys]]\nat = 1\n[[film.keys.layers]]\nlayer = {layer}\n");
        check(TWO, &keys, &format!("18: key 0 of the film: {expected}"));
    }
    let both = "layers = [{ layer = 0 }, { layer = \"bone\" }]";
    let error = film_of(&format!("{TWO}[[film.keys]]\nat = 1\n{both}\n")).unwrap_err().to_string();
    assert!(error.ends_with("two entries are about one layer"), "{error}");
}
