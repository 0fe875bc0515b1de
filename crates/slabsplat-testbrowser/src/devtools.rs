//! The DevTools protocol of Chromium, over two pipes: requests and what they return, and events.
//!
//! A message is JSON that ends with a zero byte.
//! So no port is open to others, no WebSocket is spoken, and the browser ends when its pipes do.
//! <https://chromedevtools.github.io/devtools-protocol/>

use serde_json::{Value, json};
use std::collections::VecDeque;
use std::io::{self, BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{ChildStdin, ChildStdout};
use std::sync::mpsc::{self, Receiver};
use std::thread;
use std::time::{Duration, Instant};

/// The longest that anything may take on a machine that is busy with other tests.
pub(crate) const PATIENCE: Duration = Duration::from_secs(180);

/// A browser's end of the conversation.
#[derive(Debug)]
pub(crate) struct DevTools {
    requests: ChildStdin,
    messages: Receiver<Value>,
    n_requests: u64,
    /// What was told in passing, the oldest first.
    events: VecDeque<Value>,
    log: PathBuf,
}

impl DevTools {
    pub(crate) fn new(requests: ChildStdin, answers: ChildStdout, log: PathBuf) -> Self {
        let (sender, messages) = mpsc::channel();
        thread::spawn(move || {
            for message in BufReader::new(answers).split(0) {
                // A message that is none tells nothing, and after the end nobody listens.
                let message = message.ok().and_then(|bytes| serde_json::from_slice(&bytes).ok());
                let Some(message) = message else { break };
                if sender.send(message).is_err() {
                    break;
                }
            }
        });
        Self { requests, messages, n_requests: 0, events: VecDeque::new(), log }
    }

    /// What the browser says to a request of a page, or without one of itself.
    ///
    /// # Panics
    /// If it says that it cannot, or nothing.
    pub(crate) fn ask(&mut self, page: Option<&str>, method: &str, params: Value) -> Value {
        match self.try_ask(page, method, params) {
            Ok(answer) => answer,
            Err(error) => panic!("{method}: {error}. The browser's log:\n{}", self.last_words()),
        }
    }

    fn try_ask(&mut self, page: Option<&str>, method: &str, params: Value) -> io::Result<Value> {
        self.n_requests += 1;
        let id = self.n_requests;
        let mut request = json!({ "id": id, "method": method });
        request["params"] = params;
        if let Some(page) = page {
            request["sessionId"] = page.into();
        }
        let mut bytes = request.to_string().into_bytes();
        bytes.push(0);
        self.requests.write_all(&bytes)?;
        let asked = Instant::now();
        loop {
            let message = self.next(PATIENCE.saturating_sub(asked.elapsed()))?;
            if message["id"] != id {
                self.events.push_back(message);
                continue;
            }
            return match message.get("error") {
                Some(error) => Err(io::Error::other(error.to_string())),
                None => Ok(message["result"].clone()),
            };
        }
    }

    fn next(&mut self, at_most: Duration) -> io::Result<Value> {
        self.messages.recv_timeout(at_most).map_err(|_| io::ErrorKind::TimedOut.into())
    }

    /// The next event that `read` makes something of, if one comes in time. Those before it are forgotten.
    pub(crate) fn event<T>(
        &mut self,
        at_most: Duration,
        read: impl Fn(&Value) -> Option<T>,
    ) -> Option<T> {
        let began = Instant::now();
        loop {
            let event = match self.events.pop_front() {
                Some(event) => event,
                None => self.next(at_most.saturating_sub(began.elapsed())).ok()?,
            };
            if let Some(made) = read(&event) {
                return Some(made);
            }
        }
    }

    /// Has downloads be files of a folder, each by a name of its own, and told of.
    pub(crate) fn download_to(&mut self, folder: &Path) -> io::Result<()> {
        let folder = folder.to_str().ok_or_else(|| io::Error::other("no UTF-8"))?;
        let params =
            json!({ "behavior": "allowAndName", "downloadPath": folder, "eventsEnabled": true });
        self.try_ask(None, "Browser.setDownloadBehavior", params).map(drop)
    }

    pub(crate) fn last_words(&self) -> String {
        crate::chromium::end_of(&self.log)
    }
}
