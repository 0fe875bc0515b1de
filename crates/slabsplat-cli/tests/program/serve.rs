//! `slabsplat serve`: a link on stdout, a scene behind it, and an end.

use crate::{diagnostic, program};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// The program while it serves; it does not outlive a test.
pub(crate) struct Serving {
    child: Child,
    /// Address, and path with the token.
    address: String,
    path: String,
}

impl Serving {
    fn start(args: &str) -> Self {
        Self::start_in(Path::new("."), args)
    }

    pub(crate) fn start_in(folder: &Path, args: &str) -> Self {
        let mut command = program(folder, args);
        command.stdout(Stdio::piped()).stderr(Stdio::null());
        let mut child = command.spawn().expect("the program starts");
        let mut line = String::new();
        let stdout = child.stdout.as_mut().expect("it is piped");
        BufReader::new(stdout).read_line(&mut line).expect("it prints text");
        let link = line.trim_end().strip_prefix("http://").expect("it prints a link");
        let (address, path) = link.split_once('/').expect("it has a path");
        let (address, path) = (address.to_owned(), format!("/{path}"));
        Self { child, address, path }
    }

    /// What it prints.
    pub(crate) fn link(&self) -> String {
        format!("http://{}{}", self.address, self.path)
    }

    /// Status and body of an answer.
    fn get(&self, path: &str) -> (String, String) {
        let mut stream = TcpStream::connect(&self.address).expect("it listens");
        let host = &self.address;
        write!(stream, "GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n")
            .expect("it reads");
        let mut answer = String::new();
        stream.read_to_string(&mut answer).expect("it answers in text");
        let (head, body) = answer.split_once("\r\n\r\n").expect("there is a head");
        (head.lines().next().unwrap_or_default().to_owned(), body.to_owned())
    }
}

impl Drop for Serving {
    fn drop(&mut self) {
        // It may have ended.
        drop(self.child.kill());
        drop(self.child.wait());
    }
}

#[test]
fn serve_prints_a_link_to_the_scene() {
    let serving = Serving::start("serve builtin:sphere:16 --port 0 --backend cpu");
    let (_, query) = serving.path.split_once('?').expect("the token is in the query");
    assert!(serving.path.starts_with("/?token=") && query.len() == "token=".len() + 32);
    let (status, body) = serving.get(&format!("/session?{query}"));
    assert_eq!(status, "HTTP/1.1 200 OK");
    let session: serde_json::Value = serde_json::from_str(&body).expect("it is JSON");
    assert_eq!(session["name"], "builtin:sphere");
    assert!(session["scene"].as_str().is_some_and(|text| text.contains("[camera]")), "{body}");
    assert_eq!(serving.get("/session?token=wrong").0, "HTTP/1.1 403 Forbidden");
    assert_eq!(serving.get(&serving.path).0, "HTTP/1.1 200 OK");
}

/// Ctrl-C is how it ends, and no failure.
#[cfg(unix)]
#[test]
fn serve_ends_when_interrupted() {
    let args = "serve builtin:cube:8 --port 0 --token a.b --backend cpu --sessions 1";
    for (signal, number) in [("-INT", 2), ("-TERM", 15)] {
        // What starts programs in the background has them ignore interrupts.
        if crate::signals::is_ignored(number) {
            continue;
        }
        let mut serving = Serving::start(args);
        assert_eq!(serving.path, "/?token=a.b");
        let mut kill = Command::new("kill");
        kill.arg(signal).arg(serving.child.id().to_string());
        assert!(kill.status().expect("there is a kill").success());
        let status = serving.child.wait().expect("it is our child");
        assert_eq!(status.code(), Some(0), "{signal}");
    }
}

#[test]
fn serve_says_why_it_cannot() {
    let serving = Serving::start("serve builtin:cube:8 --port 0 --backend cpu");
    let (_, port) = serving.address.rsplit_once(':').expect("there is a port");
    let here = Path::new(".");
    let taken = diagnostic(here, &format!("serve builtin:cube:8 --port {port}"));
    assert!(taken.contains(&format!("cannot listen on 127.0.0.1, port {port}")), "{taken}");
    let token = diagnostic(here, "serve builtin:cube:8 --port 0 --token a&b");
    assert!(token.contains("a token is"), "{token}");
    let site = diagnostic(here, "serve builtin:cube:8 --port 0 --site nowhere");
    assert!(site.contains("cannot take the viewer's page from nowhere"), "{site}");
}
