//! A viewer: what comes by its WebSocket goes to the hub, and what the hub has for it is sent.

use crate::hub::{End, Hub, Outgoing, ViewerId};
use crate::message::{Ask, note};
use axum::extract::ws::{CloseFrame, Message, WebSocket, close_code};
use futures_util::future::{self, Either};
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt, StreamExt};
use std::error::Error;
use std::pin::pin;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::Notify;
use tokio::time::timeout;

/// Bytes of a request, most of which are a scene.
pub(crate) const MAX_MESSAGE_BYTES: usize = 1 << 20;

/// How often a silent viewer is asked whether it is there, and after how long it is not.
const PING_AFTER: Duration = Duration::from_secs(30);
const GONE_AFTER: Duration = Duration::from_secs(150);

/// How long a viewer whose messages cannot be read has to be told so.
const END_WITHIN: Duration = Duration::from_secs(5);

const TOO_LARGE: End = End { code: close_code::SIZE, why: "a message has at most 1 MiB" };
const NO_MESSAGE: End = End { code: close_code::PROTOCOL, why: "this is no message" };
const SILENT: End = End { code: close_code::POLICY, why: "nothing was heard for too long" };

/// Serves a viewer until it goes, or is sent away.
pub(crate) async fn run(socket: WebSocket, hub: Arc<Hub>) {
    let (viewer, wake) = hub.join();
    // However this ends, be it with the runtime.
    let leaving = Leaving { hub, viewer };
    let (mut sink, mut stream) = socket.split();
    let sending = pin!(send_all(&mut sink, &leaving.hub, viewer, &wake));
    let receiving = pin!(receive_all(&mut stream, &leaving.hub, viewer));
    if let Either::Right((Some(end), sending)) = future::select(sending, receiving).await {
        leaving.hub.close(viewer, end);
        // Whoever does not read is not told.
        drop(timeout(END_WITHIN, sending).await);
    }
}

struct Leaving {
    hub: Arc<Hub>,
    viewer: ViewerId,
}

impl Drop for Leaving {
    fn drop(&mut self) {
        self.hub.leave(self.viewer);
    }
}

/// Takes requests until there are no more; returns what the viewer is to be told then.
async fn receive_all(
    stream: &mut SplitStream<WebSocket>,
    hub: &Hub,
    viewer: ViewerId,
) -> Option<End> {
    loop {
        match timeout(GONE_AFTER, stream.next()).await {
            Err(_) => return Some(SILENT),
            Ok(None | Some(Ok(Message::Close(_)))) => return None,
            Ok(Some(Err(error))) => return Some(end_of(&error)),
            Ok(Some(Ok(Message::Text(text)))) => match Ask::parse(&text) {
                Ok(ask) => hub.ask(viewer, ask),
                Err(why) => hub.tell(viewer, note(&format!("a request was not understood: {why}"))),
            },
            Ok(Some(Ok(Message::Binary(_)))) => {
                hub.tell(viewer, note("a request was not understood: it is no text"));
            }
            // They are answered on the way.
            Ok(Some(Ok(Message::Ping(_) | Message::Pong(_)))) => {}
        }
    }
}

/// What is wrong with a message that cannot be read. Only the words of an error say that.
fn end_of(error: &axum::Error) -> End {
    let mut cause: Option<&dyn Error> = Some(error);
    while let Some(error) = cause {
        if error.to_string().to_lowercase().contains("too long") {
            return TOO_LARGE;
        }
        cause = error.source();
    }
    NO_MESSAGE
}

/// Sends what there is, until the connection ends from here, or breaks.
async fn send_all(
    sink: &mut SplitSink<WebSocket, Message>,
    hub: &Hub,
    viewer: ViewerId,
    wake: &Notify,
) {
    loop {
        let message = match hub.take(viewer) {
            Some(Outgoing::Text(text)) => Message::text(text),
            Some(Outgoing::Picture(bytes)) => Message::binary(bytes),
            Some(Outgoing::End(End { code, why })) => {
                let frame = CloseFrame { code, reason: why.into() };
                drop(sink.send(Message::Close(Some(frame))).await);
                return;
            }
            None => match timeout(PING_AFTER, wake.notified()).await {
                Ok(()) => continue,
                Err(_) => Message::Ping(Vec::new().into()),
            },
        };
        if sink.send(message).await.is_err() {
            return;
        }
    }
}
