//! What there is while a scene is served, and how it ends.

use crate::described::Described;
use crate::hub::{End, Hub};
use crate::listener::Listener;
use crate::painter;
use crate::routes::{self, Served};
use crate::site::Site;
use crate::token::Token;
use axum::Router;
use axum::extract::ws::close_code;
use futures_util::future;
use slabsplat::OpenScene;
use slabsplat::io::{IoError, VolumeSource};
use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, TcpListener, ToSocketAddrs};
use std::path::PathBuf;
use std::pin::pin;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;
use thiserror::Error;
use tokio::runtime::{Builder, Runtime};
use tokio::sync::{Notify, Semaphore};
use tokio::time::sleep;

/// Where a scene is served, and for whom.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ServeConfig {
    /// What the scene is called, for people; if nothing is said, as its first volume or mesh.
    pub name: Option<String>,
    /// The address that is listened to, or its name. Whoever reaches it and has the token may look, and all
    /// between can read what is sent.
    pub host: String,
    /// Its port; 0 for any that is free.
    pub port: u16,
    /// The token of the link, of letters, digits and `-._~`; if there is none, one at random.
    pub token: Option<String>,
    /// The folder of the viewer's page; if there is none, where it is installed.
    pub site: Option<PathBuf>,
    /// How many may look at the same time.
    pub max_sessions: usize,
}

impl Default for ServeConfig {
    /// For this machine alone, on any port.
    fn default() -> Self {
        let host = Ipv4Addr::LOCALHOST.to_string();
        Self { name: None, host, port: 0, token: None, site: None, max_sessions: 8 }
    }
}

impl ServeConfig {
    /// The same by another name.
    #[must_use]
    pub fn name(self, name: impl Into<String>) -> Self {
        Self { name: Some(name.into()), ..self }
    }

    /// The same on that port.
    #[must_use]
    pub fn port(self, port: u16) -> Self {
        Self { port, ..self }
    }

    /// The same with that token.
    #[must_use]
    pub fn token(self, token: impl Into<String>) -> Self {
        Self { token: Some(token.into()), ..self }
    }

    /// The same with the page in that folder.
    #[must_use]
    pub fn site(self, folder: impl Into<PathBuf>) -> Self {
        Self { site: Some(folder.into()), ..self }
    }

    /// The same for so many at the same time.
    #[must_use]
    pub fn max_sessions(self, max_sessions: usize) -> Self {
        Self { max_sessions, ..self }
    }
}

/// Why a scene cannot be served.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ServeError {
    /// Nobody can listen there.
    #[error("cannot listen on {host}, port {port}: {source}")]
    Listen {
        /// The address.
        host: String,
        /// The port.
        port: u16,
        /// What the system says.
        source: io::Error,
    },
    /// The viewer's page cannot be read.
    #[error("cannot take the viewer's page from {}: {source}", folder.display())]
    Site {
        /// Its folder.
        folder: PathBuf,
        /// What is wrong.
        source: io::Error,
    },
    /// The token cannot stand in a link.
    #[error("a token is 1 to 128 letters, digits and -._~")]
    BadToken,
    /// The system has no random numbers for a token.
    #[error("the system has no random numbers: give a token")]
    NoRandomNumbers,
    /// The scene cannot be a text.
    #[error(transparent)]
    Scene(#[from] IoError),
    /// The system starts no more threads.
    #[error("cannot start a thread: {0}")]
    Thread(#[source] io::Error),
}

/// A scene that is served; dropping it ends that.
#[derive(Debug)]
pub struct Server {
    url: String,
    address: SocketAddr,
    shared: Arc<Shared>,
    threads: Mutex<Vec<JoinHandle<()>>>,
}

/// What those who end a server and those who wait for that share.
#[derive(Debug, Default)]
struct Shared {
    hub: Arc<Hub>,
    stop: Notify,
    has_ended: Mutex<bool>,
    ended: Condvar,
}

/// How long viewers may take to hear that it ends.
const END_WITHIN: Duration = Duration::from_millis(500);

/// Threads that go through volumes.
const N_BLOCKING: usize = 2;

/// Serves a scene, on threads of its own.
///
/// # Errors
/// If the address cannot be listened to, the viewer's page cannot be read, the token cannot stand in a link,
/// or the scene cannot be written as a text.
pub fn serve(opened: OpenScene, config: ServeConfig) -> Result<Server, ServeError> {
    let token = config.token.as_deref().map_or_else(Token::random, Token::chosen)?;
    let site = Site::read(config.site.as_deref())?;
    let name = config.name.unwrap_or_else(|| name_of(&opened));
    let opened = Arc::new(opened);
    let file = opened.to_file()?;
    let described = Described::new(opened.clone(), &file, name)?;
    let failed =
        |source| ServeError::Listen { host: config.host.clone(), port: config.port, source };
    let listener = listen(&config.host, config.port).map_err(failed)?;
    let address = listener.local_addr().map_err(failed)?;
    let url = format!("http://{}/?token={}", reached_at(address), token.text());
    let runtime = Builder::new_current_thread()
        .enable_all()
        .max_blocking_threads(N_BLOCKING)
        .build()
        .map_err(ServeError::Thread)?;
    let shared = Arc::new(Shared::default());
    let hub = shared.hub.clone();
    let free_sessions = Arc::new(Semaphore::new(config.max_sessions.min(Semaphore::MAX_PERMITS)));
    let served = Served { token, site, described, hub: hub.clone(), free_sessions };
    let router = routes::router(Arc::new(served));
    let painters = painter::spawn(hub, opened, file).map_err(ServeError::Thread)?;
    let server = Server { url, address, shared, threads: Mutex::new(painters.into()) };
    server.listen(runtime, listener, router)?;
    Ok(server)
}

impl Server {
    /// The link that a viewer opens, with the token.
    pub fn url(&self) -> &str {
        &self.url
    }

    /// What is listened to.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Ends it, and returns when it has ended: nobody listens any more, and viewers have been told. Any
    /// thread may do so.
    pub fn stop(&self) {
        self.shared.hub.end(End { code: close_code::AWAY, why: "the server was stopped" });
        self.shared.stop.notify_one();
        let threads: Vec<_> =
            self.threads.lock().unwrap_or_else(PoisonError::into_inner).drain(..).collect();
        for thread in threads {
            // One that panicked has ended, too.
            drop(thread.join());
        }
        self.wait();
    }

    /// Returns when another thread has ended it.
    pub fn wait(&self) {
        let mut has_ended = self.shared.has_ended.lock().unwrap_or_else(PoisonError::into_inner);
        while !*has_ended {
            has_ended = self.shared.ended.wait(has_ended).unwrap_or_else(PoisonError::into_inner);
        }
    }

    fn listen(
        &self,
        runtime: Runtime,
        listener: TcpListener,
        router: Router,
    ) -> Result<(), ServeError> {
        let ending = Ending(self.shared.clone());
        let thread = thread::Builder::new().name("slabsplat-serve".to_owned());
        let thread = thread.spawn(move || {
            runtime.block_on(answer_all(listener, router, &ending.0));
            runtime.shutdown_timeout(END_WITHIN);
            drop(ending);
        });
        let thread = thread.map_err(ServeError::Thread)?;
        self.threads.lock().unwrap_or_else(PoisonError::into_inner).push(thread);
        Ok(())
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.stop();
    }
}

/// Reports the end, however it came.
struct Ending(Arc<Shared>);

impl Drop for Ending {
    fn drop(&mut self) {
        *self.0.has_ended.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.0.ended.notify_all();
    }
}

/// Answers whoever comes, until it is stopped and viewers have been told.
async fn answer_all(listener: TcpListener, router: Router, shared: &Shared) {
    // It has been made ready for that.
    let Ok(listener) = tokio::net::TcpListener::from_std(listener) else { return };
    let answering = pin!(axum::serve(Listener(listener), router).into_future());
    let stopping = pin!(shared.stop.notified());
    future::select(answering, stopping).await;
    let step = Duration::from_millis(5);
    for _ in 0..END_WITHIN.as_millis() / step.as_millis() {
        if shared.hub.is_empty() {
            return;
        }
        sleep(step).await;
    }
}

fn listen(host: &str, port: u16) -> io::Result<TcpListener> {
    let addresses: Vec<SocketAddr> = (host, port).to_socket_addrs()?.collect();
    let listener = TcpListener::bind(addresses.as_slice())?;
    listener.set_nonblocking(true)?;
    Ok(listener)
}

/// The address by which this machine reaches what listens: one that listens to all is no address.
fn reached_at(mut address: SocketAddr) -> SocketAddr {
    if address.ip().is_unspecified() {
        address.set_ip(match address.ip() {
            IpAddr::V4(_) => Ipv4Addr::LOCALHOST.into(),
            IpAddr::V6(_) => Ipv6Addr::LOCALHOST.into(),
        });
    }
    address
}

fn name_of(opened: &OpenScene) -> String {
    let volume = opened.sources.layers.first().map(|layer| match &layer.volume {
        VolumeSource::File(path) => {
            path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
        }
        other => other.to_string(),
    });
    let mesh = || {
        let path = &opened.sources.meshes.first()?.path;
        Some(path.file_name()?.to_string_lossy().into_owned())
    };
    volume.or_else(mesh).unwrap_or_default()
}
