//! A page that is used as people use it: by a mouse, by keys, and by looking at it.

use crate::devtools::{DevTools, PATIENCE};
use serde_json::{Value, json};
use std::cell::RefCell;
use std::fs;
use std::path::PathBuf;
use std::rc::Rc;
use std::thread;
use std::time::{Duration, Instant};

/// A page in a window of its own, so that none is hidden by another. It is there as long as its browser, and
/// every method panics if that does not answer.
#[derive(Debug)]
pub struct Page {
    devtools: Rc<RefCell<DevTools>>,
    /// By which the browser knows it.
    session: String,
    downloads: PathBuf,
}

/// Something that a page has given its user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Download {
    /// As what it would be stored.
    pub name: String,
    /// What it is.
    pub bytes: Vec<u8>,
}

/// A key, and what is held with it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Key {
    /// Enter.
    Enter,
    /// Escape.
    Escape,
    /// The key of a letter of ASCII in lower case, with Ctrl.
    Ctrl(char),
    /// The same with Shift, too.
    CtrlShift(char),
}

/// Two frames of the page: what was told before the first is drawn in it or in the second.
const FRAMES: &str =
    "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))";

/// What is between two things that a mouse tells.
const MOUSE_EVERY: Duration = Duration::from_micros(16_667);

/// So many points has the way of a pointer that drags.
const N_STEPS: i32 = 5;

impl Page {
    pub(crate) fn new(
        devtools: Rc<RefCell<DevTools>>,
        downloads: PathBuf,
        [width, height]: [u32; 2],
    ) -> Self {
        let ask = |method: &str, params: Value| devtools.borrow_mut().ask(None, method, params);
        let target = ask("Target.createTarget", json!({ "url": "about:blank", "newWindow": true }));
        let params = json!({ "targetId": target["targetId"], "flatten": true });
        let attached = ask("Target.attachToTarget", params);
        let session = attached["sessionId"].as_str().unwrap_or_default().to_owned();
        let page = Self { devtools, session, downloads };
        // It then says when it has gone to another address.
        page.ask("Page.enable", json!({}));
        let mobile =
            json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        page.ask("Emulation.setDeviceMetricsOverride", mobile);
        // Each of several believes that it has the keyboard.
        page.ask("Emulation.setFocusEmulationEnabled", json!({ "enabled": true }));
        page
    }

    fn ask(&self, method: &str, params: Value) -> Value {
        self.devtools.borrow_mut().ask(Some(&self.session), method, params)
    }

    /// Has every page that is opened from now on run JavaScript before its own.
    pub fn run_first(&self, script: &str) {
        self.ask("Page.addScriptToEvaluateOnNewDocument", json!({ "source": script }));
    }

    /// Opens another address, and returns when there is a page.
    pub fn open(&self, url: &str) {
        self.ask("Page.navigate", json!({ "url": url }));
        let is_there = |event: &Value| {
            let is_ours = event["sessionId"] == *self.session;
            (is_ours && event["method"] == "Page.domContentEventFired").then_some(())
        };
        let page = self.devtools.borrow_mut().event(PATIENCE, is_there);
        assert!(page.is_some(), "there is no page at {url}");
    }

    /// What a line of JavaScript makes in the page, once it has.
    pub fn evaluate(&self, script: &str) -> Value {
        let params = json!({ "expression": script, "awaitPromise": true, "returnByValue": true });
        self.ask("Runtime.evaluate", params)["result"]["value"].clone()
    }

    /// Returns when the page has drawn what it was told.
    pub fn next_frames(&self) {
        self.evaluate(FRAMES);
    }

    /// What is to be seen of it, as a PNG.
    pub fn screenshot(&self) -> Vec<u8> {
        let shot = self.ask("Page.captureScreenshot", json!({ "format": "png" }));
        bytes_of_base64(shot["data"].as_str().unwrap_or_default())
    }

    /// Drags from a point of the page to another, frame by frame.
    pub fn drag(&self, from: [i32; 2], to: [i32; 2]) {
        self.mouse("mouseMoved", from, 0);
        self.mouse("mousePressed", from, 1);
        for step in 1..=N_STEPS {
            let at = |axis: usize| from[axis] + (to[axis] - from[axis]) * step / N_STEPS;
            self.mouse("mouseMoved", [at(0), at(1)], 0);
        }
        self.mouse("mouseReleased", to, 1);
    }

    /// Drags to and fro around a point for so long, told as often as a mouse tells it or the page listens.
    pub fn shake(&self, around: [i32; 2], by: i32, lasting: Duration) {
        self.mouse("mouseMoved", around, 0);
        self.mouse("mousePressed", around, 1);
        let (began, mut n_told) = (Instant::now(), 0);
        while began.elapsed() < lasting {
            let turn = 0.05 * f64::from(n_told);
            let at = [turn.sin(), 0.3 * (0.7 * turn).sin()].map(|x| (f64::from(by) * x) as i32);
            let at = [around[0] + at[0], around[1] + at[1]];
            self.ask("Input.dispatchMouseEvent", mouse("mouseMoved", at, 0));
            n_told += 1;
            thread::sleep((MOUSE_EVERY * n_told).saturating_sub(began.elapsed()));
        }
        self.mouse("mouseReleased", around, 1);
    }

    /// Fingers touch the page at points, go to others frame by frame, and are lifted.
    pub fn touch<const N: usize>(&self, from: [[i32; 2]; N], to: [[i32; 2]; N]) {
        self.ask(
            "Emulation.setTouchEmulationEnabled",
            json!({ "enabled": true, "maxTouchPoints": N }),
        );
        self.fingers("touchStart", &from);
        for step in 1..=N_STEPS {
            let at = |finger: usize, axis: usize| {
                let [from, to] = [from[finger][axis], to[finger][axis]];
                from + (to - from) * step / N_STEPS
            };
            let now: Vec<[i32; 2]> = (0..N).map(|finger| [at(finger, 0), at(finger, 1)]).collect();
            self.fingers("touchMove", &now);
        }
        self.fingers("touchEnd", &[]);
    }

    fn fingers(&self, kind: &str, at: &[[i32; 2]]) {
        let point = |(id, [x, y]): (usize, &[i32; 2])| json!({ "x": x, "y": y, "id": id });
        let points: Vec<Value> = at.iter().enumerate().map(point).collect();
        self.ask("Input.dispatchTouchEvent", json!({ "type": kind, "touchPoints": points }));
        self.next_frames();
    }

    /// Clicks.
    pub fn click(&self, at: [i32; 2]) {
        self.mouse("mouseMoved", at, 0);
        self.mouse("mousePressed", at, 1);
        self.mouse("mouseReleased", at, 1);
    }

    /// Clicks twice, as fast as nobody can.
    pub fn double_click(&self, at: [i32; 2]) {
        self.mouse("mouseMoved", at, 0);
        for n_clicks in 1..=2 {
            self.ask("Input.dispatchMouseEvent", mouse("mousePressed", at, n_clicks));
            self.ask("Input.dispatchMouseEvent", mouse("mouseReleased", at, n_clicks));
        }
        self.next_frames();
    }

    fn mouse(&self, kind: &str, at: [i32; 2], n_clicks: u32) {
        self.ask("Input.dispatchMouseEvent", mouse(kind, at, n_clicks));
        self.next_frames();
    }

    /// Presses a key and lets it go.
    pub fn press(&self, key: Key) {
        for kind in ["rawKeyDown", "keyUp"] {
            self.ask("Input.dispatchKeyEvent", key.event(kind));
        }
        self.next_frames();
    }

    /// Writes text where the page takes it.
    pub fn write(&self, text: &str) {
        self.ask("Input.insertText", json!({ "text": text }));
        self.next_frames();
    }

    /// The next download of any page, whole, if it comes in time.
    pub fn download(&self, at_most: Duration) -> Option<Download> {
        let mut devtools = self.devtools.borrow_mut();
        let text = |value: &Value| value.as_str().map(str::to_owned);
        let (id, name) = devtools.event(at_most, |event| {
            let begun = event["method"] == "Browser.downloadWillBegin";
            let params = &event["params"];
            begun.then(|| Some((text(&params["guid"])?, text(&params["suggestedFilename"])?)))?
        })?;
        devtools.event(at_most, |event| {
            let params = &event["params"];
            let is_whole = event["method"] == "Browser.downloadProgress"
                && params["guid"] == *id
                && params["state"] == "completed";
            is_whole.then_some(())
        })?;
        let bytes = fs::read(self.downloads.join(id)).ok()?;
        Some(Download { name, bytes })
    }
}

/// An event of the left button, or with no clicks of none.
fn mouse(kind: &str, [x, y]: [i32; 2], n_clicks: u32) -> Value {
    let is_move = n_clicks == 0;
    let button = if is_move { "none" } else { "left" };
    json!({ "type": kind, "x": x, "y": y, "button": button, "clickCount": n_clicks })
}

/// What is held with a key, as bits.
const CTRL: u32 = 2;
const SHIFT: u32 = 8;

/// What a letter's key is called, what it writes, its number, and what is held with it.
fn letter_with(letter: char, written: char, held: u32) -> (String, String, u32, u32) {
    let upper = letter.to_ascii_uppercase();
    (written.to_string(), format!("Key{upper}"), upper as u32, held)
}

impl Key {
    fn event(self, kind: &str) -> Value {
        let (key, code, number, modifiers) = match self {
            Self::Enter => ("Enter".to_owned(), "Enter".to_owned(), 13, 0),
            Self::Escape => ("Escape".to_owned(), "Escape".to_owned(), 27, 0),
            Self::Ctrl(letter) => letter_with(letter, letter, CTRL),
            Self::CtrlShift(letter) => {
                letter_with(letter, letter.to_ascii_uppercase(), CTRL | SHIFT)
            }
        };
        json!({
            "type": kind, "key": key, "code": code, "windowsVirtualKeyCode": number,
            "modifiers": modifiers,
        })
    }
}

/// Bytes as text of 64 letters (RFC 4648); what is none of them ends it.
fn bytes_of_base64(text: &str) -> Vec<u8> {
    let value = |letter: u8| {
        Some(match letter {
            b'A'..=b'Z' => letter - b'A',
            b'a'..=b'z' => letter - b'a' + 26,
            b'0'..=b'9' => letter - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            _ => return None,
        })
    };
    let sixths: Vec<u8> = text.bytes().map_while(value).collect();
    let of_chunk = |chunk: &[u8]| {
        let bits = chunk.iter().fold(0, |bits, &sixth| bits << 6 | u32::from(sixth));
        let bits = bits << (32 - 6 * chunk.len());
        bits.to_be_bytes().into_iter().take(chunk.len() * 6 / 8)
    };
    sixths.chunks(4).flat_map(of_chunk).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_bytes() {
        let check = |text: &str, expected: &[u8]| assert_eq!(bytes_of_base64(text), expected);
        check("", b"");
        check("Zg==", b"f");
        check("Zm8=", b"fo");
        check("Zm9v", b"foo");
        check("Zm9vYmFy", b"foobar");
        check("//79", &[0xff, 0xfe, 0xfd]);
    }

    #[test]
    fn keys_are_those_of_a_keyboard() {
        let event = Key::Ctrl('s').event("rawKeyDown");
        assert_eq!((&event["key"], &event["code"]), (&json!("s"), &json!("KeyS")));
        assert_eq!((&event["windowsVirtualKeyCode"], &event["modifiers"]), (&json!(83), &json!(2)));
        assert_eq!(Key::Enter.event("keyUp")["windowsVirtualKeyCode"], 13);
    }
}
