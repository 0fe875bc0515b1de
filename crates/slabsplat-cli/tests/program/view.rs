//! `slabsplat view`, in a display that nobody sees: used by mouse and keys, and looked at.

use crate::{answer, diagnostic, json, program, slabsplat};
use image::RgbaImage;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// The longest that anything may take on a machine that is busy with other tests.
const PATIENCE: Duration = Duration::from_secs(120);

#[test]
fn a_window_shows_and_saves_what_render_draws() {
    let Some(display) = Display::open() else { return };
    let dir = tempfile::tempdir().unwrap();
    answer(dir.path(), "convert builtin:neuron:48 neuron.nii.gz");
    let window = display.view(dir.path(), "neuron.nii.gz --preset mr-angio");
    let saved = window.saved("first");
    assert_same(&saved, &window.rendered("first"), "to the byte");
    window.shows(&saved);

    let turned = window.turned();
    assert!(1.0 < mean_difference(&turned, &saved), "it is turned");
    assert_same(&turned, &window.rendered("turned"), "after it was turned");
    window.shows(&turned);

    window.key("ctrl+z");
    assert_same(&window.saved("undone"), &saved, "a drag is one step");

    // The other projection, a side, and larger.
    for key in ["p", "3", "plus"] {
        window.key(key);
    }
    let aside = window.saved("aside");
    assert_same(&aside, &window.rendered("aside"), "aside");
    window.shows(&aside);
}

/// By a device that draws window and frames alike these are not read back while they move.
#[test]
fn a_window_shows_what_moves_as_what_is_at_rest() {
    let Some(display) = Display::open() else { return };
    let dir = tempfile::tempdir().unwrap();
    let backends = json(dir.path(), "backends --json");
    let is_wgpu = |backend: &&serde_json::Value| backend["name"] == "wgpu";
    let wgpu = backends["backends"].as_array().unwrap().iter().find(is_wgpu);
    let Some(wgpu) = wgpu.filter(|wgpu| !wgpu["unavailable"].is_string()) else {
        println!("skipped: there is no wgpu");
        return;
    };
    println!("wgpu: {}", wgpu["devices"][0]);
    let window = display.view_by("wgpu", dir.path(), "builtin:cube:12 --slab-width 2");
    let picture = window.saved("first");
    assert_same(&picture, &window.rendered("first"), "picture");
    window.shows(&picture);
    let rest = view_of(&window.screen(), &picture);
    let off = || mean_difference(&view_of(&window.screen(), &picture), &rest);
    // As long as the button is held, nothing is at rest.
    window.xdotool("mousemove 200 200 sleep 0.2 mousedown 1 sleep 0.2");
    window.xdotool("mousemove 260 230 sleep 0.2 mousemove 330 260 sleep 0.2");
    wait(|| 2.0 * MOVED < off());
    window.xdotool("mousemove 260 230 sleep 0.2 mousemove 200 200 sleep 0.2");
    // It may be smaller, and so less sharp at edges.
    wait(|| off() < MOVED);
    window.xdotool("mouseup 1 sleep 0.3");
    let again = window.saved("again");
    assert_same(&again, &window.rendered("again"), "again");
    window.shows(&again);
}

/// By how much two pictures differ on average, of 255, if it is not by their sharpness alone.
const MOVED: f64 = 4.0;

#[test]
fn a_window_opens_other_files_and_says_what_is_wrong_with_them() {
    let Some(display) = Display::open() else { return };
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("broken.nrrd"), "NRRD0004\nsizes: 9999999 9999999\n").unwrap();
    answer(
        dir.path(),
        "render builtin:sphere:24 --width 64 --height 48 -o ball.png --save-scene ball.toml",
    );
    let mut window = display.view(dir.path(), "builtin:cube:16");
    let cube = window.saved("cube");
    window.open("broken.nrrd");
    assert_same(&window.saved("still"), &cube, "what was open stays");
    window.open("ball.toml");
    let ball = window.saved_other_than("ball", &cube);
    assert_same(&ball, &window.rendered("ball"), "ball");
    // Another layer, which is a step of undo.
    window.enter("ctrl+shift+o", "builtin:cube:16");
    let both = window.saved_other_than("both", &ball);
    assert_same(&both, &window.rendered("both"), "both");
    window.shows(&both);
    window.key("ctrl+z");
    assert_same(&window.saved("alone"), &ball, "alone");
    assert!(window.child.try_wait().unwrap().is_none(), "the window is open");
}

#[test]
fn what_cannot_be_viewed_is_said_in_one_line() {
    let dir = tempfile::tempdir().unwrap();
    let said = diagnostic(dir.path(), "view nothing.nii --preset ct-bones");
    assert!(said.contains("ct-bones"), "{said}");
    if cfg!(target_os = "linux") {
        let mut without_display = program(dir.path(), "view builtin:cube:8");
        without_display.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
        let output = without_display.output().unwrap();
        let said = crate::text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.lines().count() == 1 && said.contains("slabsplat render"), "{said}");
    }
    assert!(slabsplat(dir.path(), "view --help").status.success());
}

/// A display in memory.
struct Display {
    server: Child,
    name: String,
}

impl Display {
    /// `None`, and a line, where something is missing that is needed.
    fn open() -> Option<Self> {
        let missing = ["Xvfb", "xdotool", "import"].into_iter().find(|name| !is_there(name));
        if let Some(missing) = missing {
            let must_be = std::env::var_os("SLABSPLAT_REQUIRE_GPU").is_some();
            assert!(!must_be, "SLABSPLAT_REQUIRE_GPU is set, but there is no {missing}");
            println!("skipped: there is no {missing}");
            return None;
        }
        let mut server = Command::new("Xvfb");
        server.args(["-displayfd", "1", "-screen", "0", "900x640x24", "-nolisten", "tcp"]);
        let mut server =
            server.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().expect("it is there");
        let mut number = String::new();
        let stdout = server.stdout.take().expect("it is piped");
        BufReader::new(stdout).read_line(&mut number).expect("it tells its number");
        Some(Self { server, name: format!(":{}", number.trim()) })
    }

    fn view(&self, folder: &Path, args: &str) -> Window<'_> {
        self.view_by("cpu", folder, args)
    }

    fn view_by(&self, backend: &str, folder: &Path, args: &str) -> Window<'_> {
        let mut program = program(folder, &format!("view --backend {backend} {args}"));
        program.env("DISPLAY", &self.name).env_remove("WAYLAND_DISPLAY");
        // What is remembered is no business of the tester's.
        program.env("XDG_STATE_HOME", folder.join("state"));
        let child = program.spawn().expect("it starts");
        let window = Window { display: self, child, folder: folder.to_owned() };
        window.xdotool("search --sync --onlyvisible --name slabsplat windowfocus --sync");
        window
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        drop(self.server.kill());
        drop(self.server.wait());
    }
}

struct Window<'d> {
    display: &'d Display,
    child: Child,
    folder: PathBuf,
}

impl Window<'_> {
    fn xdotool(&self, args: &str) {
        let mut xdotool = Command::new("xdotool");
        xdotool.env("DISPLAY", &self.display.name).args(args.split_whitespace());
        let output = xdotool.output().expect("it is there");
        assert!(output.status.success(), "{args}: {}", crate::text(&output.stderr));
    }

    fn key(&self, key: &str) {
        self.xdotool(&format!("key {key} sleep 0.3"));
    }

    /// Enters a name in the window that a key opens.
    fn enter(&self, key: &str, name: &str) {
        self.xdotool(&format!("key {key} sleep 0.5 key ctrl+a type --delay 20 {name}"));
        self.xdotool("sleep 0.3 key Return sleep 0.3");
    }

    fn open(&self, name: &str) {
        self.enter("ctrl+o", name);
        sleep(Duration::from_secs(1));
    }

    fn drag(&self, [x, y]: [i32; 2], [to_x, to_y]: [i32; 2]) {
        let (half_x, half_y) = (i32::midpoint(x, to_x), i32::midpoint(y, to_y));
        self.xdotool(&format!(
            "mousemove {x} {y} sleep 0.2 mousedown 1 sleep 0.2 mousemove {half_x} {half_y} sleep 0.2 \
             mousemove {to_x} {to_y} sleep 0.2 mouseup 1 sleep 0.3"
        ));
    }

    /// The picture after a drag.
    fn turned(&self) -> RgbaImage {
        self.drag([200, 200], [320, 260]);
        self.saved("turned")
    }

    /// The picture and the scene, as the window saves them under a name.
    fn saved(&self, name: &str) -> RgbaImage {
        let [picture, scene] = ["png", "toml"].map(|ending| format!("saved-{name}.{ending}"));
        self.save("ctrl+s", &scene, |path| path.exists().then_some(()));
        // It is there whole or not at all.
        self.save("ctrl+e", &picture, |path| image::open(path).ok()).into_rgba8()
    }

    /// Has a file saved; more than once if the window was too busy to hear all that was typed.
    fn save<T>(&self, key: &str, name: &str, read: impl Fn(&Path) -> Option<T>) -> T {
        let began = Instant::now();
        while began.elapsed() < PATIENCE {
            self.enter(key, name);
            let entered = Instant::now();
            while entered.elapsed() < PATIENCE / 6 {
                if let Some(saved) = read(&self.folder.join(name)) {
                    return saved;
                }
                sleep(Duration::from_millis(100));
            }
            self.key("Escape");
        }
        panic!("{name} was not saved");
    }

    /// The same once it is another: what is opened takes its time.
    fn saved_other_than(&self, name: &str, other: &RgbaImage) -> RgbaImage {
        let began = Instant::now();
        loop {
            let saved = self.saved(name);
            if saved != *other {
                return saved;
            }
            assert!(began.elapsed() < PATIENCE, "{name} was not opened");
            for ending in ["png", "toml"] {
                drop(std::fs::remove_file(self.folder.join(format!("saved-{name}.{ending}"))));
            }
            sleep(Duration::from_millis(500));
        }
    }

    /// What `render` draws of the scene that was saved.
    fn rendered(&self, name: &str) -> RgbaImage {
        answer(&self.folder, &format!("render saved-{name}.toml -o rendered-{name}.png"));
        let picture = image::open(self.folder.join(format!("rendered-{name}.png")));
        picture.expect("render wrote it").into_rgba8()
    }

    /// That the window has the picture in its view. Its panels may cover the lower edge, where it says what
    /// was done.
    fn shows(&self, picture: &RgbaImage) {
        let began = Instant::now();
        loop {
            let screen = self.screen();
            let offs = (20..80).map(|top| off_from(&screen, picture, top));
            let off = offs.min().expect("there are some");
            if off <= 1 {
                return;
            }
            let shot = std::env::temp_dir().join("slabsplat-view.png");
            if PATIENCE < began.elapsed() {
                drop(screen.save(&shot));
                panic!("the window shows something else, off by {off}: {}", shot.display());
            }
            sleep(Duration::from_millis(200));
        }
    }

    fn screen(&self) -> RgbaImage {
        let path = self.folder.join("screen.png");
        let mut import = Command::new("import");
        import.env("DISPLAY", &self.display.name).args(["-window", "root"]).arg(&path);
        assert!(import.status().expect("it is there").success());
        image::open(path).expect("it wrote a picture").into_rgba8()
    }
}

impl Drop for Window<'_> {
    fn drop(&mut self) {
        drop(self.child.kill());
        drop(self.child.wait());
    }
}

/// What is where a picture is on a screen that shows it, but for what may lie over it.
fn view_of(screen: &RgbaImage, picture: &RgbaImage) -> RgbaImage {
    let (width, height) = (picture.width(), picture.height() / 2);
    image::imageops::crop_imm(screen, 0, 80, width, height).to_image()
}

/// Whether the screen has a picture in it whose top is there. What covers its lower half is not looked at.
pub(crate) fn is_covered_at(screen: &RgbaImage, picture: &RgbaImage, top: u32) -> bool {
    off_from(screen, picture, top) <= 1
}

/// By how much the screen is off in the upper half of a picture whose top is there, at most.
fn off_from(screen: &RgbaImage, picture: &RgbaImage, top: u32) -> u8 {
    let half = (0..picture.height() / 2).flat_map(|y| (0..picture.width()).map(move |x| (x, y)));
    half.map(|(x, y)| {
        let (shown, expected) = (screen.get_pixel(x, top + y).0, picture.get_pixel(x, y).0);
        (0..3).map(|c| shown[c].abs_diff(expected[c])).max().unwrap_or(0)
    })
    .max()
    .unwrap_or(0)
}

/// That two pictures have the same bytes; they are too long to be printed.
fn assert_same(a: &RgbaImage, b: &RgbaImage, what: &str) {
    assert!(
        a == b,
        "{what}: {:?}, {:?}, off by {}",
        a.dimensions(),
        b.dimensions(),
        mean_difference(a, b)
    );
}

pub(crate) fn mean_difference(a: &RgbaImage, b: &RgbaImage) -> f64 {
    assert_eq!(a.dimensions(), b.dimensions());
    let sum: u64 = a.iter().zip(b.iter()).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
    sum as f64 / a.len() as f64
}

fn wait(until: impl Fn() -> bool) {
    let began = Instant::now();
    while !until() {
        assert!(began.elapsed() < PATIENCE, "it does not happen");
        sleep(Duration::from_millis(200));
    }
}

fn is_there(program: &str) -> bool {
    let found = |folder: PathBuf| folder.join(program).is_file();
    std::env::var_os("PATH").is_some_and(|path| std::env::split_paths(&path).any(found))
}
