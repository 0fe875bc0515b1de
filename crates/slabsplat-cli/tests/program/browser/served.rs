//! Pages of `slabsplat serve`, whose pictures the server draws.

use super::{Used, site};
use crate::serve::Serving;
use crate::view::mean_difference;
use slabsplat_testbrowser::{Chromium, Graphics};
use std::fs;

/// A volume that is smaller in the page than it is here, and another.
const SCENE: &str = "image = { background = [0.1, 0.1, 0.12, 1.0] }\n\
                     [[layers]]\nvolume = { generate = \"neuron\", size = 96 }\n\
                     [[layers]]\nvolume = { generate = \"sphere\", size = 40 }\n";

#[test]
fn two_pages_look_at_one_scene_each_from_where_it_likes() {
    let Some(site) = site() else { return };
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("scene.toml"), SCENE).unwrap();
    let serve = format!("serve scene.toml --port 0 --backend cpu --site {}", site.display());
    let serving = Serving::start_in(dir.path(), &serve);
    let chromium = Chromium::start(Graphics::WebGl).expect("Chromium is installed");
    let [one, other] = [(); 2].map(|()| {
        let page = chromium.page([640, 480]);
        page.open(&serving.link());
        Used { page, folder: dir.path() }
    });
    one.has_picture();
    let first = one.saves_what_render_draws("first", 0);
    other.shows(&first);
    one.turn();
    let turned = one.saves_what_render_draws("turned", 0);
    assert!(1.0 < mean_difference(&turned, &first), "it was turned");
    other.add_opacity();
    let edited = other.saves_what_render_draws("edited", 0);
    assert!(1.0 < mean_difference(&edited, &first), "it is more opaque");
    one.shows(&turned);
    one.switch_last_layer_alone();
    let alone = one.saves_what_render_draws("alone", 0);
    assert!(1.0 < mean_difference(&alone, &turned), "the neuron is hidden");
    other.shows(&edited);
    one.switch_last_layer_alone();
    one.shows(&turned);

    let wrong = Used { page: chromium.page([640, 480]), folder: dir.path() };
    wrong.page.open(&serving.link().replace("token=", "token=wrong"));
    wrong.must_say("The link needs the token that slabsplat serve has printed.");
}
