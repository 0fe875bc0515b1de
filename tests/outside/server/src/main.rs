//! `server [VOLUME]`: serves pictures of a volume, by default a built-in one, at
//! `http://127.0.0.1:8000/picture.png?turn=30&size=512`.

use slabsplat::io;
use std::error::Error;
use std::sync::Arc;
use tokio::net::TcpListener;

#[tokio::main]
async fn main() -> Result<(), Box<dyn Error>> {
    let volume = match std::env::args_os().nth(1) {
        Some(path) => Arc::unwrap_or_clone(io::read_volume(path)?.volume),
        None => io::builtin_volume("shepp-logan", None)?,
    };
    let listener = TcpListener::bind("127.0.0.1:8000").await?;
    println!("http://{}/picture.png?turn=30", listener.local_addr()?);
    Ok(axum::serve(listener, server::router(volume)?).await?)
}
