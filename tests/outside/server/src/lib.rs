//! A service that answers `GET /picture.png?turn=30&size=512` with a picture of one volume.
//!
//! A [`RenderThread`] draws, so that no thread of the executor is ever busy for longer than it takes to copy
//! a scene. The frame of a client that goes away is cancelled: what awaits it is dropped.

use axum::Router;
use axum::extract::{Query, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use serde::Deserialize;
use slabsplat::{Automatic, ImageDesc, RenderSettings, RenderThread, Volume, io};
use std::error::Error;
use std::sync::Arc;

/// What all requests share.
struct Service {
    automatic: Automatic,
    renderer: RenderThread,
}

/// What a request asks for.
#[derive(Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Wish {
    /// How far the camera is turned around the volume, in degrees.
    turn: f64,
    /// Pixels along either side.
    size: u32,
}

impl Default for Wish {
    fn default() -> Self {
        Self { turn: 0.0, size: 512 }
    }
}

/// The service for one volume.
///
/// # Errors
/// If the system starts no more threads.
pub fn router(volume: Volume) -> std::io::Result<Router> {
    let renderer = RenderThread::open("auto", |note| eprintln!("{note}"))?;
    let service = Service { automatic: Automatic::new(volume), renderer };
    Ok(Router::new().route("/picture.png", get(picture)).with_state(Arc::new(service)))
}

async fn picture(State(service): State<Arc<Service>>, Query(wish): Query<Wish>) -> Response {
    if !(1..=2048).contains(&wish.size) || !wish.turn.is_finite() {
        return (StatusCode::BAD_REQUEST, "size is from 1 to 2048, turn in degrees")
            .into_response();
    }
    match service.draw(&wish).await {
        Ok(png) => ([(header::CONTENT_TYPE, "image/png")], png).into_response(),
        Err(error) => (StatusCode::INTERNAL_SERVER_ERROR, error.to_string()).into_response(),
    }
}

impl Service {
    async fn draw(&self, wish: &Wish) -> Result<Vec<u8>, Box<dyn Error + Send + Sync>> {
        let image = ImageDesc::new(wish.size, wish.size);
        let mut scene = self.automatic.scene(image, RenderSettings::default());
        scene.camera = scene.camera.orbited(wish.turn.to_radians());
        let frame = self.renderer.submit(&scene).await?;
        Ok(io::png_bytes(&frame.image)?)
    }
}
