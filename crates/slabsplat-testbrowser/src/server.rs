//! A web server for one test: the files of some folders, and a channel for what is posted.

use std::fs;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::thread;
use std::time::Duration;

/// Most bytes that a page may post.
const MAX_BODY: u64 = 64 << 20;

/// Most bytes of a request before its body.
const MAX_HEAD: u64 = 64 << 10;

/// How long a connection may be silent.
const SILENCE: Duration = Duration::from_secs(10);

/// Serves the files of some folders to this machine alone, until the process ends.
#[derive(Debug)]
pub struct Server {
    address: SocketAddr,
    posted: Receiver<Message>,
}

/// What a page posted.
#[derive(Debug, PartialEq, Eq)]
pub struct Message {
    /// Where to, as `/picture/1`.
    pub path: String,
    /// What.
    pub body: Vec<u8>,
}

impl Server {
    /// Serves what lies in the folders themselves, not below; of files of one name that of the first.
    ///
    /// # Errors
    /// If the system does not let it.
    pub fn start(folders: Vec<PathBuf>) -> io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
        let address = listener.local_addr()?;
        let (sender, posted) = mpsc::channel();
        let folders = Arc::new(folders);
        thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                let (folders, sender) = (folders.clone(), sender.clone());
                // A browser that goes away is no failure of the server's.
                thread::spawn(move || answer(&stream, &folders, &sender).ok());
            }
        });
        Ok(Self { address, posted })
    }

    /// The address of a page.
    pub fn url(&self, page: &str) -> String {
        format!("http://{}/{page}", self.address)
    }

    /// What is posted next.
    ///
    /// # Errors
    /// If that is nothing for so long.
    pub fn posted(&self, at_most: Duration) -> Result<Message, RecvTimeoutError> {
        self.posted.recv_timeout(at_most)
    }
}

/// Answers the one request of a connection.
fn answer(stream: &TcpStream, folders: &[PathBuf], sender: &Sender<Message>) -> io::Result<()> {
    stream.set_read_timeout(Some(SILENCE))?;
    let mut reader = BufReader::new(stream);
    let Some(request) = read_head(&mut (&mut reader).take(MAX_HEAD))? else {
        return respond(stream, "400 Bad Request", "text/plain", b"");
    };
    let path = request.target.split('?').next().unwrap_or_default();
    match &*request.method {
        "GET" => match find(path, folders) {
            Some(bytes) => respond(stream, "200 OK", kind_of(path), &bytes),
            None => respond(stream, "404 Not Found", "text/plain", b""),
        },
        "POST" if request.n_bytes <= MAX_BODY => {
            let mut body = Vec::new();
            reader.take(request.n_bytes).read_to_end(&mut body)?;
            // Nobody listens any more once the test has ended.
            sender.send(Message { path: path.to_owned(), body }).ok();
            respond(stream, "200 OK", "text/plain", b"")
        }
        _ => respond(stream, "400 Bad Request", "text/plain", b""),
    }
}

/// What a request says before its body.
#[derive(Debug, PartialEq)]
struct Request {
    method: String,
    target: String,
    /// Of the body.
    n_bytes: u64,
}

/// Reads up to the empty line; nothing if it is no request.
fn read_head(reader: &mut impl BufRead) -> io::Result<Option<Request>> {
    let mut lines = reader.lines();
    let Some(first) = lines.next().transpose()? else { return Ok(None) };
    let mut words = first.split(' ').map(str::to_owned);
    let (Some(method), Some(target)) = (words.next(), words.next()) else { return Ok(None) };
    let mut n_bytes = 0;
    for line in lines {
        let line = line?;
        if line.is_empty() {
            return Ok(Some(Request { method, target, n_bytes }));
        }
        if let Some((name, value)) = line.split_once(':')
            && name.eq_ignore_ascii_case("content-length")
        {
            n_bytes = value.trim().parse().unwrap_or(u64::MAX);
        }
    }
    Ok(None)
}

/// The file of a path, which is a plain name: no folder, and nothing above.
fn find(path: &str, folders: &[PathBuf]) -> Option<Vec<u8>> {
    let name = path.strip_prefix('/')?;
    let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '.' || c == '-';
    if name.starts_with('.') || !name.chars().all(is_plain) {
        return None;
    }
    folders.iter().find_map(|folder| fs::read(folder.join(name)).ok())
}

/// As what a browser takes it; of WebAssembly, modules and styles it is particular.
fn kind_of(path: &str) -> &'static str {
    match path.rsplit('.').next() {
        Some("css") => "text/css",
        Some("html") => "text/html",
        Some("js") => "text/javascript",
        Some("wasm") => "application/wasm",
        _ => "application/octet-stream",
    }
}

fn respond(mut stream: &TcpStream, status: &str, kind: &str, body: &[u8]) -> io::Result<()> {
    let n_bytes = body.len();
    write!(
        stream,
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {n_bytes}\r\n\
         Cache-Control: no-store\r\nConnection: close\r\n\r\n"
    )?;
    stream.write_all(body)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(server: &Server, request: &str) -> String {
        let mut stream = TcpStream::connect(server.address).unwrap();
        stream.write_all(request.as_bytes()).unwrap();
        let mut response = String::new();
        stream.read_to_string(&mut response).unwrap();
        response
    }

    #[test]
    fn server_gives_files_of_its_folders_alone() {
        let dir = tempfile::tempdir().unwrap();
        let [inner, other] = ["inner", "other"].map(|name| dir.path().join(name));
        fs::create_dir(&inner).unwrap();
        fs::create_dir(&other).unwrap();
        fs::write(inner.join("a.js"), "let a = 1;").unwrap();
        fs::write(other.join("a.js"), "let a = 2;").unwrap();
        fs::write(other.join("b.css"), "p {}").unwrap();
        fs::write(dir.path().join("secret"), "no").unwrap();
        let server = Server::start(vec![inner, other]).unwrap();
        let style = asked(&server, "GET /b.css HTTP/1.1\r\n\r\n");
        assert!(style.contains("text/css") && style.ends_with("p {}"), "{style}");
        let found = asked(&server, "GET /a.js?x=1 HTTP/1.1\r\n\r\n");
        assert!(
            found.starts_with("HTTP/1.1 200 OK\r\nContent-Type: text/javascript\r\n"),
            "{found}"
        );
        assert!(found.ends_with("\r\n\r\nlet a = 1;"), "{found}");
        for path in ["/../secret", "/b.js", "/", "/..", "//a.js", "/inner/a.js"] {
            let missing = asked(&server, &format!("GET {path} HTTP/1.1\r\n\r\n"));
            assert!(missing.starts_with("HTTP/1.1 404"), "{path}: {missing}");
        }
    }

    #[test]
    fn server_hands_on_what_is_posted() {
        let server = Server::start(vec!["no-such-folder".into()]).unwrap();
        let posted = asked(&server, "POST /say HTTP/1.1\r\ncontent-length: 5\r\n\r\nhellomore");
        assert!(posted.starts_with("HTTP/1.1 200"), "{posted}");
        let message = server.posted(SILENCE).unwrap();
        assert_eq!(message, Message { path: "/say".to_owned(), body: b"hello".to_vec() });
        for bad in
            ["", "\r\n\r\n", "DELETE / HTTP/1.1\r\n\r\n", "POST / X\r\nContent-Length: -1\r\n\r\n"]
        {
            let mut stream = TcpStream::connect(server.address).unwrap();
            stream.write_all(bad.as_bytes()).unwrap();
            stream.shutdown(std::net::Shutdown::Write).unwrap();
            let mut response = String::new();
            stream.read_to_string(&mut response).unwrap();
            assert!(response.starts_with("HTTP/1.1 400"), "{bad:?}: {response}");
        }
        assert!(server.posted(Duration::from_millis(1)).is_err());
    }
}
