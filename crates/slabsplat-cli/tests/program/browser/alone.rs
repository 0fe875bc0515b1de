//! The page alone: it reads and draws in the browser, and nothing is sent anywhere.

use super::{Used, first_picture, site};
use crate::view::mean_difference;
use image::codecs::{gif::GifDecoder, png::PngDecoder};
use image::{AnimationDecoder, RgbaImage};
use slabsplat_testbrowser::{Chromium, Graphics, Server};
use std::fs;
use std::io::Cursor;

/// By how much numbers of 8 bits may differ whose colours are 10⁻³ apart at most (model §9): by which of two
/// neighbours they are rounded to.
const ROUNDING: u8 = 1;

/// A real volume.
const BRAIN: &str = "mni152_t1_1mm_uint8.nii.gz";

#[test]
fn a_page_shows_a_real_volume_by_the_cpu_in_a_window_of_webgl() {
    let Some(site) = site() else { return };
    let Some(brain) = slabsplat_testdata::volume(&format!("nifti/{BRAIN}")) else { return };
    let dir = tempfile::tempdir().unwrap();
    fs::copy(brain, dir.path().join(BRAIN)).unwrap();
    let server = Server::start(vec![site, dir.path().to_owned()]).unwrap();
    let chromium = Chromium::start(Graphics::WebGl).expect("Chromium is installed");
    let page = chromium.page([800, 560]);
    let used = Used { page, folder: dir.path() };
    first_picture(&used, "a built-in volume, WebGL", &server.url("index.html"));
    first_picture(&used, BRAIN, &server.url(&format!("index.html?url={BRAIN}")));
    use_it(&used);
}

/// A program that plays a graphics card takes minutes for a brain. Only without a tolerance do it and the CPU
/// draw the same sections.
const SMALL: &str = "volume = { generate = \"neuron\", size = 20 }\n\
                     image = { background = [0.1, 0.1, 0.12, 1.0] }\n\
                     render = { slab_width = 2.0, tolerance = 0.0 }\n";

#[test]
fn a_page_draws_by_webgpu_what_the_cpu_draws() {
    let Some(site) = site() else { return };
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("small.toml"), SMALL).unwrap();
    let server = Server::start(vec![site, dir.path().to_owned()]).unwrap();
    let chromium = Chromium::start(Graphics::WebGpu).expect("Chromium is installed");
    let page = chromium.page([520, 380]);
    let used = Used { page, folder: dir.path() };
    first_picture(&used, "a built-in volume, WebGPU", &server.url("index.html"));
    let small = "index.html?scene=small.toml&backend=wgpu";
    first_picture(&used, "a small volume by WebGPU", &server.url(small));
    use_it(&used);
}

/// A finger turns, two zoom.
#[test]
fn a_page_is_touched() {
    with_small_volume([520, 380], touch);
}

fn touch(used: &Used<'_>) {
    let first = used.saves_what_render_draws("before-touch", ROUNDING);
    used.page.touch([[60, 200]], [[150, 230]]);
    let turned = used.saves_what_render_draws("turned-by-touch", ROUNDING);
    assert!(1.0 < mean_difference(&turned, &first), "it was turned");
    used.page.touch([[90, 200], [100, 220]], [[60, 150], [130, 270]]);
    let zoomed = used.saves_what_render_draws("zoomed-by-touch", ROUNDING);
    let [before, after] =
        ["turned", "zoomed"].map(|name| used.view_height(&format!("{name}-by-touch")));
    let spread = f64::hypot(70.0, 120.0) / f64::hypot(10.0, 20.0);
    assert!((before / after / spread - 1.0).abs() < 0.1, "{before} to {after}, not by {spread}");
    assert!(1.0 < mean_difference(&zoomed, &turned), "it was zoomed");
}

/// Turns of six seconds, in the forms that a page makes, begin with what is shown.
#[test]
fn a_page_films_a_turn() {
    with_small_volume([420, 300], film);
}

fn film(used: &Used<'_>) {
    let shown = used.saved("filmed");
    let gif = used.film("turn.gif");
    let frames = GifDecoder::new(Cursor::new(gif)).expect("it is a GIF").into_frames();
    let apng = PngDecoder::new(Cursor::new(used.film("turn.apng"))).expect("it is a PNG");
    for (what, frames) in [("gif", frames), ("apng", apng.apng().expect("it moves").into_frames())]
    {
        let frames: Vec<RgbaImage> =
            frames.map(|frame| frame.expect("it is whole").into_buffer()).collect();
        assert_eq!(frames.len(), 180, "{what}");
        // A palette has 256 colours.
        assert!(mean_difference(&frames[0], &shown) < 2.0, "{what}");
        assert!(1.0 < mean_difference(&frames[45], &shown), "{what} turns");
    }
}

/// Has a page used that shows a small volume, drawn by the CPU.
fn with_small_volume(size: [u32; 2], use_it: impl FnOnce(&Used<'_>)) {
    let Some(site) = site() else { return };
    let dir = tempfile::tempdir().expect("there is room");
    fs::write(dir.path().join("small.toml"), SMALL).expect("there is room");
    let server = Server::start(vec![site, dir.path().to_owned()]).expect("a port is free");
    let chromium = Chromium::start(Graphics::WebGl).expect("Chromium is installed");
    let used = Used { page: chromium.page(size), folder: dir.path() };
    first_picture(&used, "a small volume", &server.url("index.html?scene=small.toml"));
    use_it(&used);
}

/// What a page hands to its worker: colours of voxels, samples of other types, grids that are neither cubic
/// nor rectangular, several layers; and what of a scene is not the page's: a backend that no browser has. A
/// file that no worker can read is named.
#[test]
fn a_page_hands_all_of_a_scene_to_its_worker() {
    let Some(site) = site() else { return };
    let dir = tempfile::tempdir().unwrap();
    let volumes = [("colors", colors as fn([i32; 3]) -> Vec<u8>, COLORS), ("shell", shell, SHELL)];
    for (name, bytes_of, header) in volumes {
        let at =
            |idx: i32| [idx % SIDE, idx / SIDE % SIDE, idx / SIDE / SIDE].map(|i| 2 * i - SIDE);
        let bytes = (0..SIDE.pow(3)).flat_map(|idx| bytes_of(at(idx)));
        let file = header.bytes().chain(*b"\n\n").chain(bytes).collect::<Vec<u8>>();
        fs::write(dir.path().join(format!("{name}.nrrd")), file).unwrap();
    }
    fs::write(dir.path().join("two.toml"), TWO).unwrap();
    let server = Server::start(vec![site, dir.path().to_owned()]).unwrap();
    let chromium = Chromium::start(Graphics::WebGl).expect("Chromium is installed");
    let used = Used { page: chromium.page([520, 480]), folder: dir.path() };
    first_picture(&used, "colours and a shell", &server.url("index.html?scene=two.toml"));
    used.must_say("the browser draws as it can");
    let first = used.saves_what_render_draws("layers", ROUNDING);
    used.turn();
    let turned = used.saves_what_render_draws("layers-turned", ROUNDING);
    assert!(1.0 < mean_difference(&turned, &first), "it was turned");
    let whole = fs::read(dir.path().join("shell.nrrd")).unwrap();
    fs::write(dir.path().join("cut.nrrd"), &whole[..whole.len() / 2]).unwrap();
    used.page.open(&server.url("index.html?url=cut.nrrd"));
    used.must_say("cut.nrrd");
}

const TWO: &str = "render = { backend = \"ash\" }\n\
                   camera = { projection = \"perspective\" }\n\
                   image = { background = [0.1, 0.1, 0.12, 1.0] }\n\
                   layers = [{ volume = { path = \"colors.nrrd\" } }, { volume = { path = \"shell.nrrd\" } }]\n";

/// Voxels along each side.
const SIDE: i32 = 24;

const COLORS: &str = "NRRD0004\ntype: uint16\ndimension: 4\nsizes: 3 24 24 24\n\
                      space: right-anterior-superior\n\
                      space directions: none (1,0.2,0) (0,1.3,0) (0,0.3,2)\n\
                      space origin: (-12,-12,-12)\nkinds: RGB-color domain domain domain\n\
                      endian: little\nencoding: raw";

const SHELL: &str = "NRRD0004\ntype: int16\ndimension: 3\nsizes: 24 24 24\n\
                     space: right-anterior-superior\n\
                     space directions: (1.5,0,0) (0.4,1,0) (0,0,2.5)\n\
                     space origin: (-20,-12,-30)\nendian: little\nencoding: raw";

/// A ball whose colours say where they are.
fn colors(at: [i32; 3]) -> Vec<u8> {
    let is_inside = at.iter().map(|x| x * x).sum::<i32>() < SIDE * SIDE / 3;
    let color = at.map(|x| if is_inside { (1200 * (x + SIDE)) as u16 } else { 0 });
    color.into_iter().flat_map(u16::to_le_bytes).collect()
}

/// A sphere that can be seen through.
fn shell(at: [i32; 3]) -> Vec<u8> {
    let distance = at.iter().map(|x| x * x).sum::<i32>() - SIDE * SIDE / 2;
    ((1000 - 20 * distance.abs()).max(-1000) as i16).to_le_bytes().to_vec()
}

/// Turns, edits, and has all of it be what `render` draws.
fn use_it(used: &Used<'_>) {
    let first = used.saves_what_render_draws("first", ROUNDING);
    used.turn();
    let turned = used.saves_what_render_draws("turned", ROUNDING);
    assert!(1.0 < mean_difference(&turned, &first), "it was turned");
    used.add_opacity();
    let edited = used.saves_what_render_draws("edited", ROUNDING);
    assert!(1.0 < mean_difference(&edited, &turned), "it is more opaque");
}
