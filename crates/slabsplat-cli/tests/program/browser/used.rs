//! A viewer in a page, and what is done with it.

use crate::answer;
use crate::view::{is_covered_at, mean_difference};
use image::RgbaImage;
use slabsplat_testbrowser::{Download, Key, Page};
use std::fs;
use std::path::Path;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// The longest that anything may take on a machine that is busy with other tests.
const PATIENCE: Duration = Duration::from_secs(180);

/// How often is looked whether something has happened.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// Pixels on the right that the view has not.
const PANEL: u32 = 330;

/// Rows in which the upper edge of the view is.
const TOPS: std::ops::Range<u32> = 20..120;

/// A page, and a folder for what it saves, where its volume is too.
pub(super) struct Used<'a> {
    pub(super) page: Page,
    pub(super) folder: &'a Path,
}

impl Used<'_> {
    /// What is to be seen.
    pub(super) fn screen(&self) -> RgbaImage {
        let shot = image::load_from_memory(&self.page.screenshot());
        shot.expect("a screenshot is a picture").into_rgba8()
    }

    /// Waits until something is as it should be.
    fn wait<T>(&self, what: &str, mut found: impl FnMut(&RgbaImage) -> Option<T>) -> T {
        let began = Instant::now();
        loop {
            let screen = self.screen();
            if let Some(found) = found(&screen) {
                return found;
            }
            if PATIENCE < began.elapsed() {
                let shot = std::env::temp_dir().join("slabsplat-page.png");
                drop(screen.save(&shot));
                panic!("{what}: {}; the page says: {}", shot.display(), self.says());
            }
            sleep(LOOK_EVERY);
        }
    }

    /// Waits until there is a picture in the view.
    pub(super) fn has_picture(&self) {
        self.wait("there is no picture", |screen| (!is_blank(screen)).then_some(()));
    }

    /// Waits until the page has a picture in its view. Its messages may cover the lower half.
    pub(super) fn shows(&self, picture: &RgbaImage) {
        self.wait("the page shows something else", |screen| {
            TOPS.clone().any(|top| is_covered_at(screen, picture, top)).then_some(())
        });
    }

    /// What the page says in words.
    pub(super) fn says(&self) -> String {
        let said = self.page.evaluate("document.getElementById('said')?.textContent");
        said.as_str().unwrap_or_default().to_owned()
    }

    /// Waits until it says so.
    pub(super) fn must_say(&self, what: &str) {
        self.wait(what, |_| self.says().contains(what).then_some(()));
    }

    /// Saves the scene and its picture as people do; the picture.
    pub(super) fn saved(&self, name: &str) -> RgbaImage {
        let scene = self.download('s', "scene.toml");
        fs::write(self.folder.join(format!("saved-{name}.toml")), scene.bytes)
            .expect("there is room");
        let picture = self.download('e', "picture.png");
        image::load_from_memory(&picture.bytes).expect("it is a picture").into_rgba8()
    }

    /// What the key asks for, and Enter grants; once more if the page was too busy to hear it.
    fn download(&self, key: char, name: &str) -> Download {
        let began = Instant::now();
        while began.elapsed() < PATIENCE {
            self.page.press(Key::Ctrl(key));
            self.page.press(Key::Enter);
            if let Some(download) = self.page.download(PATIENCE / 4) {
                assert_eq!(download.name, name);
                return download;
            }
            self.page.press(Key::Escape);
        }
        panic!("{name} was not saved; the page says: {}", self.says());
    }

    /// A film of a turn, named so, as people ask for one.
    pub(super) fn film(&self, name: &str) -> Vec<u8> {
        self.page.press(Key::CtrlShift('e'));
        self.page.press(Key::Ctrl('a'));
        self.page.write(name);
        self.page.press(Key::Enter);
        let Some(film) = self.page.download(PATIENCE) else {
            panic!("{name} was not saved; the page says: {}", self.says());
        };
        assert_eq!(film.name, name);
        film.bytes
    }

    /// What `slabsplat render` draws of the scene that was saved, by the CPU.
    pub(super) fn rendered(&self, name: &str) -> RgbaImage {
        let command = format!("render saved-{name}.toml --backend cpu -o rendered-{name}.png");
        answer(self.folder, &command);
        let picture = image::open(self.folder.join(format!("rendered-{name}.png")));
        picture.expect("render wrote it").into_rgba8()
    }

    /// Saves, and compares with what `render` makes of it, which may differ by `at_most` of 255, and with
    /// what is shown.
    pub(super) fn saves_what_render_draws(&self, name: &str, at_most: u8) -> RgbaImage {
        let (saved, rendered) = (self.saved(name), self.rendered(name));
        let off = largest_difference(&saved, &rendered);
        let mean = mean_difference(&saved, &rendered);
        println!("{name}: off by {off} of 255 at most, by {mean:.1e} on average");
        assert!(off <= at_most, "{name}: off by {off}");
        self.shows(&rendered);
        rendered
    }

    /// The height of what an orthographic scene shows that was saved by that name.
    pub(super) fn view_height(&self, name: &str) -> f64 {
        let text = fs::read_to_string(self.folder.join(format!("saved-{name}.toml")));
        let text = text.expect("it was saved");
        let height = text.split_once("view_height = ").expect("the camera is orthographic").1;
        let number = height.split(|c: char| !(c.is_ascii_digit() || c == '.')).next();
        number.and_then(|number| number.parse().ok()).expect("it is a number")
    }

    /// Turns by a drag through the view.
    pub(super) fn turn(&self) {
        self.page.drag([60, 200], [150, 230]);
    }

    /// Shows the last of a server's layers alone, or all of them again.
    pub(super) fn switch_last_layer_alone(&self) {
        let [left, top] = self.wait("there is no plot", plot);
        self.page.click([left as i32 + ALONE[0], top as i32 + ALONE[1]]);
    }

    /// Adds a point to the opacities by a double click onto the plot, above the curve.
    pub(super) fn add_opacity(&self) {
        let at = self.wait("there is no plot", |screen| {
            let [left, top] = plot(screen)?;
            Some([left as i32 + 40, top as i32 + 24])
        });
        let around = |screen: &RgbaImage| {
            let [x, y] = [at[0] as u32 - 6, at[1] as u32 - 6];
            image::imageops::crop_imm(screen, x, y, 12, 12).to_image()
        };
        let before = around(&self.screen());
        self.wait("no point was added", |_| {
            self.page.double_click(at);
            (around(&self.screen()) != before).then_some(())
        });
    }
}

/// From the upper left corner of the plot to the button above it that shows the last of the layers alone.
const ALONE: [i32; 2] = [44, -41];

/// Opens an address, and tells how long it takes until there is a picture.
pub(super) fn first_picture(used: &Used<'_>, what: &str, url: &str) {
    let began = Instant::now();
    used.page.open(url);
    used.has_picture();
    // That is told, and nothing judged by it: the machine may be busy.
    println!("{what}: first picture after {:.1} s", began.elapsed().as_secs_f64());
}

/// Whether nothing is in the view but its background, and a word. A page that loads is that, too.
fn is_blank(screen: &RgbaImage) -> bool {
    let [width, height] = [screen.width() - PANEL, screen.height()];
    let middle = (height / 4..height * 3 / 4).flat_map(|y| (0..width).map(move |x| (x, y)));
    let background = screen.get_pixel(2, height / 2);
    let differs = |&(x, y): &(u32, u32)| {
        let pixel = screen.get_pixel(x, y);
        (0..3).any(|c| 12 < pixel[c].abs_diff(background[c]))
    };
    middle.filter(differs).count() * 20 < (width * height / 2) as usize
}

/// The upper left corner of the plot of opacities: the first white field in the panel that is larger than a
/// line of text.
fn plot(screen: &RgbaImage) -> Option<[u32; 2]> {
    let in_panel = screen.width() - PANEL..screen.width();
    let white = |y: u32| {
        let mut xs = in_panel.clone().filter(|&x| screen.get_pixel(x, y).0 == [255; 4]);
        Some([xs.next()?, xs.count() as u32])
    };
    let rows: Vec<Option<[u32; 2]>> = (0..screen.height()).map(white).collect();
    let is_of_plot = |row: &Option<[u32; 2]>| row.is_some_and(|[_, n]| PANEL / 2 < n);
    let top = rows.windows(30).position(|rows| rows.iter().all(is_of_plot))?;
    Some([rows[top]?[0], top as u32])
}

fn largest_difference(a: &RgbaImage, b: &RgbaImage) -> u8 {
    assert_eq!(a.dimensions(), b.dimensions());
    a.iter().zip(b.iter()).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0)
}
