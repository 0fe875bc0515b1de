//! A server of a small scene, and what talks to it: plain HTTP, and WebSockets.

use futures_util::{SinkExt, StreamExt};
use serde_json::{Value, json};
use slabsplat::{OpenScene, io};
use slabsplat_serve::{ServeConfig, Server, serve};
use std::future::Future;
use std::io::{Read, Write};
use std::time::Duration;
use tokio::net::TcpStream;
use tokio::time::timeout;
use tokio_tungstenite::tungstenite::client::IntoClientRequest;
use tokio_tungstenite::tungstenite::{Error, Message};
use tokio_tungstenite::{MaybeTlsStream, WebSocketStream, connect_async};

/// Longer than anything takes on a busy machine.
pub(crate) const LONG: Duration = Duration::from_secs(120);

pub(crate) const SCENE: &str = "volume = { generate = \"sphere\", size = 16 }\n\
                                image = { width = 64, height = 48, background = [0.1, 0.1, 0.2, 1] }\nrender = { backend = \"cpu\" }\n";

/// The scene that is served.
pub(crate) fn opened() -> OpenScene {
    let file = io::parse_scene(SCENE, "ball.toml").expect("it is a scene");
    OpenScene::open(&file).expect("it needs no files")
}

pub(crate) fn started(config: ServeConfig) -> Server {
    serve(opened(), config.token("secret")).expect("any port will do")
}

/// The scene seen from another side, in a picture of another size, as a viewer sends it.
pub(crate) fn turned(angle: f64, [width, height]: [u32; 2]) -> String {
    let mut opened = opened();
    opened.scene.camera = opened.scene.camera.orbited(angle);
    (opened.scene.image.width, opened.scene.image.height) = (width, height);
    io::scene_text(&opened.to_file().expect("it has no labels"), "scene.toml").expect("a text")
}

/// Runs what waits.
pub(crate) fn block_on<T>(future: impl Future<Output = T>) -> T {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    let limited = async { timeout(LONG, future).await.expect("it ends") };
    runtime.expect("there are threads").block_on(limited)
}

/// Asks for a path as it is, and returns status, headers and body.
pub(crate) fn get(server: &Server, path: &str) -> (u16, String, Vec<u8>) {
    let address = server.address();
    let mut stream = std::net::TcpStream::connect(address).expect("it listens");
    stream.set_read_timeout(Some(LONG)).expect("it can be set");
    let request = format!("GET {path} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n");
    stream.write_all(request.as_bytes()).expect("it reads");
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).expect("it answers");
    let end = answer.windows(4).position(|bytes| bytes == b"\r\n\r\n").expect("there is a head");
    let head = String::from_utf8(answer[..end].to_vec()).expect("a head is text").to_lowercase();
    let status = head.split(' ').nth(1).and_then(|status| status.parse().ok());
    (status.expect("there is a status"), head, answer[end + 4..].to_vec())
}

/// The JSON of `/session`.
pub(crate) fn session(server: &Server) -> Value {
    let (status, _, body) = get(server, "/session?token=secret");
    assert_eq!(status, 200);
    serde_json::from_slice(&body).expect("it is JSON")
}

/// A viewer.
pub(crate) struct Viewer {
    pub(crate) socket: WebSocketStream<MaybeTlsStream<TcpStream>>,
}

/// What comes from the server.
#[derive(Debug)]
pub(crate) enum Answer {
    Picture { header: Value, bytes: Vec<u8> },
    Text(Value),
    Closed(Option<u16>),
}

impl Viewer {
    pub(crate) async fn connect(server: &Server) -> Self {
        Self::try_connect(server, "secret", None).await.expect("viewers are let in")
    }

    /// Connects as a page from `origin` would.
    pub(crate) async fn try_connect(
        server: &Server,
        token: &str,
        origin: Option<&str>,
    ) -> Result<Self, Error> {
        let link = format!("ws://{}/frames?token={token}", server.address());
        let mut request = link.into_client_request()?;
        if let Some(origin) = origin {
            request.headers_mut().insert("Origin", origin.parse().expect("it is a header"));
        }
        connect_async(request).await.map(|(socket, _)| Self { socket })
    }

    pub(crate) async fn ask(&mut self, pane: usize, number: u64, urgency: &str, scene: &str) {
        let ask = json!({ "pane": pane, "number": number, "urgency": urgency, "scene": scene });
        self.send(&ask.to_string()).await;
    }

    pub(crate) async fn send(&mut self, text: &str) {
        self.socket.send(Message::text(text)).await.expect("the server reads");
    }

    pub(crate) async fn answer(&mut self) -> Answer {
        loop {
            match self.socket.next().await {
                Some(Ok(Message::Binary(message))) => {
                    let (length, rest) = message.split_at(4);
                    let length = u32::from_le_bytes(length.try_into().expect("four bytes"));
                    let (header, bytes) = rest.split_at(length as usize);
                    let header = serde_json::from_slice(header).expect("it is JSON");
                    return Answer::Picture { header, bytes: bytes.to_vec() };
                }
                Some(Ok(Message::Text(text))) => {
                    return Answer::Text(serde_json::from_str(&text).expect("it is JSON"));
                }
                Some(Ok(Message::Close(frame))) => {
                    return Answer::Closed(frame.map(|frame| frame.code.into()));
                }
                Some(Ok(_)) => {}
                Some(Err(_)) | None => return Answer::Closed(None),
            }
        }
    }

    /// The next picture, and its header.
    pub(crate) async fn picture(&mut self) -> (Value, Vec<u8>) {
        match self.answer().await {
            Answer::Picture { header, bytes } => (header, bytes),
            other => panic!("{other:?} instead of a picture"),
        }
    }

    /// The next text.
    pub(crate) async fn text(&mut self) -> Value {
        match self.answer().await {
            Answer::Text(text) => text,
            other => panic!("{other:?} instead of a text"),
        }
    }

    /// Why the server does not let somebody in.
    pub(crate) async fn refusal(server: &Server, token: &str, origin: Option<&str>) -> u16 {
        match Self::try_connect(server, token, origin).await {
            Err(Error::Http(response)) => response.status().as_u16(),
            Err(error) => panic!("{error}"),
            Ok(_) => panic!("it was let in"),
        }
    }
}
