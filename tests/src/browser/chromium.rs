//! A Chromium without a window, whose graphics card is SwiftShader, a program.

use std::fs::{self, File};
use std::io;
use std::process::{Child, Command, Stdio};
use tempfile::TempDir;

/// WebGPU on SwiftShader, with canvases; without one of the last four the device is lost when a page draws.
const GRAPHICS: &[&str] = &[
    "--enable-unsafe-webgpu",
    "--enable-features=Vulkan",
    "--use-vulkan=swiftshader",
    "--use-angle=swiftshader",
    "--use-webgpu-adapter=swiftshader",
];

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
];

/// A browser that shows a page until this is dropped.
#[derive(Debug)]
pub struct Chromium {
    process: Child,
    /// Removed once the process has ended.
    profile: TempDir,
}

impl Chromium {
    /// Opens a page, in a profile that nothing was done in before.
    ///
    /// # Errors
    /// If there is no Chromium, or no room for its profile.
    pub fn open(url: &str) -> io::Result<Self> {
        let profile = tempfile::tempdir()?;
        let log = File::create(profile.path().join("log"))?;
        let mut command = Command::new("chromium");
        command.args(GRAPHICS).args(ALONE);
        command.arg(format!("--user-data-dir={}", profile.path().display())).arg(url);
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(log);
        Ok(Self { process: command.spawn()?, profile })
    }

    /// What it complained of last.
    pub fn last_words(&self) -> String {
        let log = fs::read(self.profile.path().join("log")).unwrap_or_default();
        let log = String::from_utf8_lossy(&log);
        let n_lines = log.lines().count();
        log.lines().skip(n_lines.saturating_sub(30)).collect::<Vec<_>>().join("\n")
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
