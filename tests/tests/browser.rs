//! What a browser draws, by WebAssembly and by WebGPU, is what the CPU draws here. `cargo xtask web` builds
//! the pages and runs this.

#[path = "../outside/browser/src/scenes.rs"]
mod scenes;

use slabsplat::{Image, Scene};
use slabsplat_testbrowser::{Chromium, Graphics, Message, Server};
use slabsplat_tests::render::render;
use std::time::{Duration, Instant};

/// Names the folder with the pages.
const SITE: &str = "SLABSPLAT_SITE";

/// What a pixel may differ from that of the CPU backend (model §9).
const FROM_CPU: f32 = 1e-3;

/// Whose pictures are judged.
const BACKENDS: [&str; 2] = ["cpu", "wgpu"];

/// The longest that a browser may say nothing, and that it may take.
const SILENCE: Duration = Duration::from_secs(180);
const ALL_IN_ALL: Duration = Duration::from_secs(900);

#[test]
fn browser_draws_the_same() {
    let Some(site) = std::env::var_os(SITE) else {
        println!("skipped: `cargo xtask web` runs this in a browser");
        return;
    };
    let server = Server::start(vec![site.into()]).expect("the system has a port");
    let mut judge = Judge::new();
    let chromium = Chromium::start(Graphics::WebGpu).expect("Chromium is installed");
    chromium.page([800, 600]).open(&server.url("test.html"));
    let began = Instant::now();
    loop {
        let message = server.posted(SILENCE.min(ALL_IN_ALL.saturating_sub(began.elapsed())));
        let Ok(message) = message else {
            panic!("the browser says nothing any more. Its log:\n{}", chromium.last_words());
        };
        if message.path == "/done" {
            break;
        }
        judge.hear(&message);
    }
    drop(chromium);
    judge.sum_up();
}

/// Compares pictures with those of the CPU.
struct Judge {
    scenes: Vec<(&'static str, Scene)>,
    expected: Vec<Image>,
    /// By backend and scene, how far the picture is off.
    differences: [Vec<Option<f32>>; 2],
    failures: Vec<String>,
}

impl Judge {
    fn new() -> Self {
        let scenes = scenes::all();
        let expected = scenes.iter().map(|(_, scene)| render("cpu", scene)).collect();
        let differences = [(); 2].map(|()| vec![None; scenes.len()]);
        Self { scenes, expected, differences, failures: Vec::new() }
    }

    fn hear(&mut self, Message { path, body }: &Message) {
        let words = || String::from_utf8_lossy(body);
        match path.split('/').collect::<Vec<_>>()[..] {
            ["", "say"] => println!("{}", words()),
            ["", "fail"] => self.failures.push(words().into_owned()),
            ["", "picture", backend, scene, ms] => self.judge(backend, scene, ms, body),
            _ => self.failures.push(format!("the page posts to {path}")),
        }
    }

    fn judge(&mut self, backend: &str, scene: &str, ms: &str, pixels: &[u8]) {
        let idx = BACKENDS.iter().position(|known| *known == backend);
        let idx = idx.expect("it was asked for");
        let scene: usize = scene.parse().expect("scenes are numbered");
        let (name, expected) = (self.scenes[scene].0, &self.expected[scene]);
        let mut image = Image::filled(expected.width(), expected.height(), [f32::NAN; 4]);
        let floats = image.pixels_mut().as_flattened_mut();
        // As WebAssembly has them everywhere.
        let (sent, rest) = pixels.as_chunks::<4>();
        if floats.len() != sent.len() || !rest.is_empty() {
            self.failures.push(format!("{backend}, {name}: {} bytes of pixels", pixels.len()));
            return;
        }
        floats.iter_mut().zip(sent).for_each(|(float, bytes)| *float = f32::from_le_bytes(*bytes));
        let off = image.max_difference(expected);
        println!("{backend}, {name}: {off:.1e} off, {ms} ms");
        // What is not a number is not less.
        let is_good = off < FROM_CPU && image.pixels().as_flattened().iter().all(|c| c.is_finite());
        if !is_good {
            self.failures.push(format!("{backend}, {name}: {off} off"));
        }
        self.differences[idx][scene] = Some(off);
    }

    fn sum_up(self) {
        assert!(self.failures.is_empty(), "{}", self.failures.join("\n"));
        for (backend, differences) in BACKENDS.iter().zip(&self.differences) {
            let judged: Option<Vec<f32>> = differences.iter().copied().collect();
            let judged = judged.unwrap_or_else(|| panic!("{backend}: pictures are missing"));
            let most = judged.iter().copied().fold(0.0, f32::max);
            println!("{backend}: {} pictures, {most:.1e} off at most", judged.len());
        }
    }
}
