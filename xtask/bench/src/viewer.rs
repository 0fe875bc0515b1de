//! `cargo xtask bench viewer`: how soon a page of the viewer shows a volume, and how fast its frames follow a
//! mouse that turns it.
//!
//! It is measured from outside: what a page shows has to be sent to its graphics, and a line of JavaScript
//! writes down when and how large. The browser has no graphics card here, so that its own drawing takes a
//! processor, too. The window on the desktop is measured by `slabsplat-viewer`'s example `pace`.

use std::ffi::OsString;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use slabsplat_testbrowser::{Chromium, Graphics, Page, Server};

use super::options::parse_counts;
use super::program::Program;
use super::table::{markdown, median};
use xtask::workspace::Workspace;

/// How it is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Options {
    /// For which the volume is turned.
    pub(super) seconds: usize,
    /// Of the page, in pixels.
    pub(super) size: [usize; 2],
}

const VOLUME: &str = "nifti/mni152_t1_1mm_uint8.nii.gz";

/// Writes down what is sent to the graphics, in `sent`: when, in milliseconds, and the size in pixels; and in
/// `held` for how many milliseconds the page's thread did one thing, where that was over 50.
const HOOK: &str = "
    globalThis.sent = [];
    globalThis.held = [];
    new PerformanceObserver((list) => held.push(...list.getEntries().map((it) => it.duration)))
        .observe({ type: 'longtask', buffered: true });
    const note = (width, height) => globalThis.sent.push([performance.now(), width, height]);
    const gl = WebGL2RenderingContext.prototype, { texImage2D, texSubImage2D } = gl;
    gl.texImage2D = function (...args) {
        note(args[3], args[4]);
        return texImage2D.apply(this, args);
    };
    gl.texSubImage2D = function (...args) {
        note(args[4], args[5]);
        return texSubImage2D.apply(this, args);
    };
    if (globalThis.GPUQueue) {
        const queue = GPUQueue.prototype, { writeTexture } = queue;
        queue.writeTexture = function (...args) {
            const size = args[3];
            note(size.width ?? size[0], size.height ?? size[1]);
            return writeTexture.apply(this, args);
        };
    }
";

const COLUMNS: [&str; 5] = [
    "page",
    "first picture",
    "held up at most, until it is whole",
    "from one frame to the next; 95 of 100 within",
    "pixels of those",
];

/// Fewer pixels along an edge has a line of text, or an icon.
const MIN_SIDE: f64 = 80.0;

/// The longest that a first picture may take.
const PATIENCE: Duration = Duration::from_secs(180);

pub(super) fn parse(args: &[OsString]) -> Result<Options, String> {
    let (mut seconds, mut width, mut height) = (8, 1280, 800);
    let counts =
        &mut [("--seconds", &mut seconds), ("--width", &mut width), ("--height", &mut height)];
    parse_counts(args, counts)?;
    Ok(Options { seconds, size: [width, height] })
}

pub(super) fn run(options: &Options) -> Result<()> {
    let volume = slabsplat_testdata::volume(VOLUME).context("there is no volume to show")?;
    let site = Workspace::read()?.target_directory.join("web").join("viewer");
    ensure!(site.is_dir(), "there is no page: build it by `cargo xtask web`");
    let program = Program::built()?;
    let head = COLUMNS.map(str::to_owned);
    let rows = [alone(options, &site, &volume)?, served(options, &program, &site, &volume)?];
    println!("{}", markdown(&head, &rows));
    Ok(())
}

fn alone(options: &Options, site: &Path, volume: &Path) -> Result<Vec<String>> {
    let folder = tempfile::tempdir()?;
    fs::copy(volume, folder.path().join("volume.nii.gz"))?;
    let server = Server::start(vec![site.to_owned(), folder.path().to_owned()])?;
    measured(options, "alone, CPU", &server.url("index.html?url=volume.nii.gz&backend=cpu"))
}

fn served(options: &Options, program: &Program, site: &Path, volume: &Path) -> Result<Vec<String>> {
    let serving = Serving::start(program, site, volume)?;
    measured(options, "`slabsplat serve`, CPU", &serving.link)
}

/// Opens a page, turns what it shows, and tells how that went.
fn measured(options: &Options, name: &str, url: &str) -> Result<Vec<String>> {
    let chromium = Chromium::start(Graphics::WebGl).context("there is no Chromium")?;
    let size = options.size.map(|side| side as u32);
    let page = chromium.page(size);
    page.run_first(HOOK);
    let opened = Instant::now();
    page.open(url);
    while sent(&page, options).is_empty() {
        ensure!(opened.elapsed() < PATIENCE, "{name}: there is no picture");
        page.next_frames();
    }
    let first_s = sent(&page, options)[0].ms / 1e3;
    // Until it is whole, and nothing else is done.
    std::thread::sleep(Duration::from_secs(5));
    let held_ms = page.evaluate("Math.max(0, ...held)").as_f64().unwrap_or_default();
    page.evaluate("sent.length = 0");
    let around = size.map(|side| side as i32 / 3);
    page.shake(around, around[0] / 2, Duration::from_secs(options.seconds as u64));
    let frames = sent(&page, options);
    ensure!(2 < frames.len(), "{name}: nothing moves");
    Ok(row(name, [first_s, held_ms / 1e3], &frames))
}

/// A picture as it is sent to the graphics.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Sent {
    ms: f64,
    size: [f64; 2],
}

/// Those of the view, and not of its controls. The letters of the page's font are wider than a page.
fn sent(page: &Page, options: &Options) -> Vec<Sent> {
    let all = page.evaluate("sent");
    let numbers = |value: &serde_json::Value| {
        let number = |idx: usize| value[idx].as_f64();
        Some(Sent { ms: number(0)?, size: [number(1)?, number(2)?] })
    };
    let all = all.as_array().into_iter().flatten().filter_map(numbers);
    let widest = options.size[0] as f64;
    all.filter(|sent| MIN_SIDE <= sent.size[1] && (MIN_SIDE..widest).contains(&sent.size[0]))
        .collect()
}

fn row(name: &str, [first_s, held_s]: [f64; 2], frames: &[Sent]) -> Vec<String> {
    let mut gaps: Vec<f64> = frames.windows(2).map(|pair| pair[1].ms - pair[0].ms).collect();
    gaps.sort_by(f64::total_cmp);
    let late = gaps[gaps.len() * 95 / 100];
    let [width, height] =
        [0, 1].map(|axis| median(&frames.iter().map(|sent| sent.size[axis]).collect::<Vec<_>>()));
    vec![
        name.to_owned(),
        format!("{first_s:.1} s"),
        format!("{held_s:.2} s"),
        format!("{:.0} ms; {late:.0} ms", median(&gaps)),
        format!("{width} × {height}"),
    ]
}

/// A server that ends when this is dropped.
struct Serving {
    child: Child,
    link: String,
}

impl Serving {
    fn start(program: &Program, site: &Path, volume: &Path) -> Result<Self> {
        let mut command = program.serve(volume, site);
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn()?;
        let stdout = child.stdout.take().context("it is piped")?;
        let mut link = String::new();
        BufReader::new(stdout).read_line(&mut link)?;
        Ok(Self { child, link: link.trim_end().to_owned() })
    }
}

impl Drop for Serving {
    fn drop(&mut self) {
        // It may have ended.
        drop(self.child.kill());
        drop(self.child.wait());
    }
}
