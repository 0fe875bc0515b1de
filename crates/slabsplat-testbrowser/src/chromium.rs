//! A Chromium without a window, whose graphics card is SwiftShader, a program.

use crate::devtools::DevTools;
use crate::page::Page;
use std::cell::RefCell;
use std::fs::{self, File};
use std::io;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::rc::Rc;
use tempfile::TempDir;

/// What pages can draw with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Graphics {
    /// WebGPU.
    WebGpu,
    /// WebGL alone, as where a browser is older, or knows no driver for the card.
    WebGl,
}

impl Graphics {
    fn switches(self) -> &'static [&'static str] {
        match self {
            // Without one of the last four the device is lost when a page draws.
            Self::WebGpu => &[
                "--enable-unsafe-webgpu",
                "--enable-features=Vulkan",
                "--use-vulkan=swiftshader",
                "--use-angle=swiftshader",
                "--use-webgpu-adapter=swiftshader",
            ],
            Self::WebGl => &["--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
        }
    }
}

/// Nothing but the page: no questions, no updates. Root, whom build servers run as, has no sandbox.
const ALONE: &[&str] = &[
    "--headless",
    "--no-sandbox",
    "--no-first-run",
    "--disable-quic",
    "--disable-sync",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-dev-shm-usage",
    "--enable-logging=stderr",
    "--remote-debugging-pipe",
];

/// Has the browser's descriptors 3 and 4 be our ends of two pipes: the standard library only gives a child
/// its first three.
const PIPES: &str = "exec \"$0\" \"$@\" 3<&0 4>&1 0</dev/null 1>/dev/null";

/// A browser, until this is dropped. Its pages end with it.
#[derive(Debug)]
pub struct Chromium {
    process: Child,
    devtools: Rc<RefCell<DevTools>>,
    /// Removed once the process has ended.
    profile: TempDir,
}

impl Chromium {
    /// Starts one, in a profile that nothing was done in before.
    ///
    /// # Errors
    /// If there is no Chromium, or no room for its profile.
    pub fn start(graphics: Graphics) -> io::Result<Self> {
        let profile = tempfile::tempdir()?;
        let log = profile.path().join("log");
        let mut command = Command::new("sh");
        command.args(["-c", PIPES, "chromium"]).args(graphics.switches()).args(ALONE);
        command.arg(format!("--user-data-dir={}", profile.path().display()));
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(File::create(&log)?);
        let mut process = command.spawn()?;
        let ends = process.stdin.take().zip(process.stdout.take());
        let (stdin, stdout) = ends.ok_or_else(|| io::Error::other("there are no pipes"))?;
        let devtools = Rc::new(RefCell::new(DevTools::new(stdin, stdout, log)));
        let started = Self { process, devtools, profile };
        started.devtools.borrow_mut().download_to(&started.downloads())?;
        Ok(started)
    }

    /// An empty page that is so many pixels wide and high.
    ///
    /// # Panics
    /// If the browser does not answer.
    pub fn page(&self, size: [u32; 2]) -> Page {
        Page::new(self.devtools.clone(), self.downloads(), size)
    }

    /// What it complained of last.
    pub fn last_words(&self) -> String {
        self.devtools.borrow().last_words()
    }

    fn downloads(&self) -> PathBuf {
        self.profile.path().join("downloads")
    }
}

impl Drop for Chromium {
    /// Ends it; the processes that it has started end with it.
    fn drop(&mut self) {
        // It may have ended by itself.
        drop(self.process.kill());
        drop(self.process.wait());
    }
}

/// The end of what a browser has logged.
pub(crate) fn end_of(log: &std::path::Path) -> String {
    let log = fs::read(log).unwrap_or_default();
    let log = String::from_utf8_lossy(&log);
    let n_lines = log.lines().count();
    log.lines().skip(n_lines.saturating_sub(30)).collect::<Vec<_>>().join("\n")
}
