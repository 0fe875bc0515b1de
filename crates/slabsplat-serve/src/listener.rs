//! Connections. One that takes nothing of what is sent to it for long is broken.

use axum::serve;
use std::io;
use std::net::SocketAddr;
use std::pin::Pin;
use std::task::{Context, Poll, ready};
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::{TcpListener, TcpStream};
use tokio::time::{Sleep, sleep};

/// How long a connection may take nothing.
const STALLED_AFTER: Duration = Duration::from_secs(30);

/// How long nobody is let in after an error, such as too many open files.
const PAUSE: Duration = Duration::from_millis(200);

/// Whoever connects.
pub(crate) struct Listener(pub(crate) TcpListener);

impl serve::Listener for Listener {
    type Io = Connection;
    type Addr = SocketAddr;

    async fn accept(&mut self) -> (Connection, SocketAddr) {
        loop {
            if let Ok((stream, address)) = self.0.accept().await {
                // Without it a request waits for more; it is no error where there is no such thing.
                drop(stream.set_nodelay(true));
                return (Connection { stream, stalled: None }, address);
            }
            sleep(PAUSE).await;
        }
    }

    fn local_addr(&self) -> io::Result<SocketAddr> {
        self.0.local_addr()
    }
}

/// A connection, and since when it takes nothing.
pub(crate) struct Connection {
    stream: TcpStream,
    stalled: Option<Pin<Box<Sleep>>>,
}

impl AsyncRead for Connection {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_read(context, buffer)
    }
}

impl AsyncWrite for Connection {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        if let Poll::Ready(written) = Pin::new(&mut self.stream).poll_write(context, bytes) {
            self.stalled = None;
            return Poll::Ready(written);
        }
        let stalled = self.stalled.get_or_insert_with(|| Box::pin(sleep(STALLED_AFTER)));
        ready!(stalled.as_mut().poll(context));
        Poll::Ready(Err(io::ErrorKind::TimedOut.into()))
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::serve::Listener as _;
    use std::future::poll_fn;
    use tokio::runtime::Builder;
    use tokio::time::{Instant, pause};

    /// The clock jumps to whatever is waited for.
    #[test]
    fn connection_that_takes_nothing_is_broken() {
        let runtime = Builder::new_current_thread().enable_all().build().unwrap();
        let error = runtime.block_on(async {
            let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
            let _deaf = TcpStream::connect(listener.local_addr().unwrap()).await.unwrap();
            let (mut connection, _) = Listener(listener).accept().await;
            pause();
            let started = Instant::now();
            let chunk = vec![7; 1 << 20];
            let error = loop {
                let written =
                    poll_fn(|context| Pin::new(&mut connection).poll_write(context, &chunk));
                if let Err(error) = written.await {
                    break error;
                }
            };
            assert!(STALLED_AFTER <= started.elapsed());
            error
        });
        assert_eq!(error.kind(), io::ErrorKind::TimedOut);
    }
}
