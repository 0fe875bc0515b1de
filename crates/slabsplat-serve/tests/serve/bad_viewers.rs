//! Viewers that behave badly, and what they cannot do.

use crate::client::{Answer, LONG, Viewer, block_on, started, turned};
use futures_util::SinkExt;
use serde_json::json;
use slabsplat_serve::{ServeConfig, Server};
use std::fs;
use std::io::{Read, Write};
use std::net::TcpStream;
use tokio_tungstenite::tungstenite::Message;

#[test]
fn bad_requests_are_answered() {
    let server = started(ServeConfig::default());
    let good = turned(0.0, [64, 48]);
    let no_layer = "mesh = { path = \"a.ply\" }".to_owned();
    let large = turned(0.0, [8192, 4096]);
    let sampled = turned(0.0, [2500, 2500]).replace("samples = 1\n", "samples = 16\n");
    block_on(async {
        let mut viewer = Viewer::connect(&server).await;
        for (number, (scene, expected)) in (0..).zip([
            ("volume = ", "scene.toml:1: "),
            ("volum = 1", "scene.toml:1: "),
            ("", "no [volume]"),
            (&no_layer, "another scene"),
            (&large, "too large"),
            (&sampled, "too large"),
        ]) {
            viewer.ask(1, number, "rest", scene).await;
            let text = viewer.text().await;
            assert_eq!((&text["pane"], &text["number"]), (&json!(1), &json!(number)));
            assert!(text["error"].as_str().unwrap().contains(expected), "{expected}: {text}");
        }
        for (layers, expected) in
            [(json!([1]), "there is no layer 1"), (json!([]), "another scene")]
        {
            let ask = json!({
                "pane": 1, "number": 8, "urgency": "rest", "layers": layers, "scene": good,
            });
            viewer.send(&ask.to_string()).await;
            let text = viewer.text().await;
            assert!(text["error"].as_str().unwrap().contains(expected), "{expected}: {text}");
        }
        for bad in ["", "{}", "[1, 2", "{\"pane\": 4}"] {
            viewer.send(bad).await;
            let text = viewer.text().await;
            assert!(text["note"].as_str().unwrap().contains("was not understood"), "{text}");
        }
        viewer.ask(1, 99, "rest", &good).await;
        assert_eq!(viewer.picture().await.0["number"], json!(99), "the session lives");
    });
}

/// A scene names files; the server has what it needs.
#[test]
fn files_of_viewers_are_not_read() {
    let server = started(ServeConfig::default());
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("colors.json");
    fs::write(&path, "{}").unwrap();
    let path = path.to_str().unwrap();
    let good = turned(0.0, [64, 48]);
    let camera = good.split("[camera]").nth(1).expect("it has a camera");
    let of = |volume: &str, classify: &str| {
        format!("volume = {volume}\nclassify = {classify}\n[camera]{camera}")
    };
    let ball = "{ generate = \"sphere\" }";
    let picture = "values = [0, 1], gradients = [0, 1]";
    block_on(async {
        let mut viewer = Viewer::connect(&server).await;
        for (scene, expected) in [
            (of(ball, &format!("{{ file = {path:?} }}")), "no file is read"),
            (of(ball, &format!("{{ image = {{ file = {path:?}, {picture} }} }}")), "is not read"),
            (of(ball, &format!("{{}}\nlabels = {{ path = {path:?} }}")), "has no labels"),
        ] {
            viewer.ask(0, 1, "rest", &scene).await;
            let text = viewer.text().await;
            assert!(text["error"].as_str().unwrap().contains(expected), "{text}");
        }
        // What a volume is called does not count.
        let classify = "{ opacity = [[0, 0], [255, 1]] }";
        let mut pictures = Vec::new();
        for volume in [ball.to_owned(), format!("{{ path = {path:?} }}")] {
            viewer.ask(0, 2, "rest", &of(&volume, classify)).await;
            pictures.push(viewer.picture().await.1);
        }
        assert!(pictures[0] == pictures[1]);
    });
}

#[test]
fn large_messages_are_refused() {
    let server = started(ServeConfig::default());
    block_on(async {
        let mut viewer = Viewer::connect(&server).await;
        let large = Message::text(" ".repeat((1 << 20) + 1));
        // The server hangs up at the first bytes. What it says then may be lost, as all that a network has is
        // when there is more to come than anybody reads.
        drop(viewer.socket.send(large).await);
        loop {
            match viewer.answer().await {
                Answer::Closed(code) => break assert!(code.is_none_or(|code| code == 1009)),
                Answer::Text(_) | Answer::Picture { .. } => {}
            }
        }
    });
}

/// A raw connection, past the handshake.
fn upgraded(server: &Server) -> TcpStream {
    let mut stream = TcpStream::connect(server.address()).expect("it listens");
    stream.set_read_timeout(Some(LONG)).expect("it can be set");
    let request = format!(
        "GET /frames?token=secret HTTP/1.1\r\nHost: {}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\
         Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n",
        server.address()
    );
    stream.write_all(request.as_bytes()).expect("it reads");
    let (mut head, mut byte) = (Vec::new(), [0]);
    while !head.ends_with(b"\r\n\r\n") {
        stream.read_exact(&mut byte).expect("it answers");
        head.push(byte[0]);
    }
    assert!(head.starts_with(b"HTTP/1.1 101"));
    stream
}

/// Bytes of memory that this process, server and all, has taken at most.
#[cfg(target_os = "linux")]
fn peak_bytes() -> u64 {
    let status = fs::read_to_string("/proc/self/status").expect("it is Linux");
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let line = line.expect("it has a line of it");
    1024 * line.trim().trim_end_matches(" kB").parse::<u64>().expect("it is a number")
}

/// Whatever a frame says of its length, and in however many frames a message comes.
#[cfg(target_os = "linux")]
#[test]
fn endless_messages_take_no_memory() {
    let server = started(ServeConfig::default());
    let before = peak_bytes();
    let gigabyte = 1_u64 << 30;
    let whole = [&[0x81, 0xff][..], &gigabyte.to_be_bytes(), &[0; 4]].concat();
    let part = [&[0x01, 0xff][..], &(512_u64 << 10).to_be_bytes(), &[0; 4]].concat();
    for (head, piece_bytes) in [(whole, usize::MAX), (part, 512 << 10)] {
        let mut stream = upgraded(&server);
        let chunk = [b'x'; 64 << 10];
        let mut n_sent = 0_usize;
        let mut refused = stream.write_all(&head).is_err();
        while !refused && (n_sent as u64) < gigabyte {
            refused = stream.write_all(&chunk).is_err();
            n_sent += chunk.len();
            if !refused && n_sent.is_multiple_of(piece_bytes) {
                let next = [&[0x00][..], &head[1..]].concat();
                refused = stream.write_all(&next).is_err();
            }
        }
        assert!(refused, "nobody reads a gigabyte");
    }
    let grown = peak_bytes() - before;
    assert!(grown < 256 << 20, "{grown} bytes");
}

#[test]
fn viewers_that_never_read_stop_nobody() {
    let server = started(ServeConfig::default());
    let large = turned(0.2, [1024, 1024]);
    let small = turned(0.3, [64, 48]);
    block_on(async {
        let (mut deaf, mut other) =
            (Viewer::connect(&server).await, Viewer::connect(&server).await);
        for number in 0..60 {
            deaf.ask(0, number, "rest", &large).await;
            other.ask(0, number, "moving", &small).await;
            assert_eq!(other.picture().await.0["number"], json!(number));
        }
        deaf.ask(0, 1000, "rest", &large).await;
        // It finds what was on its way, and the newest.
        while deaf.picture().await.0["number"] != json!(1000) {}
    });
}
