//! Scenes in a browser: a server that opens a scene, renders what its viewers ask for, and sends pictures.
//!
//! The volume stays where it is, and so does the graphics card; a viewer gets a small volume to steer by, and
//! pictures. Whoever has the link may look, and change how things look: neither can anybody else, nor does
//! the server read a file that a viewer names.
//!
//! ```
//! use slabsplat::{OpenScene, io};
//! use slabsplat_serve::{ServeConfig, serve};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let file = io::parse_scene("volume = { generate = \"sphere\", size = 16 }", "ball.toml")?;
//! let server = serve(OpenScene::open(&file)?, ServeConfig::default().name("a ball"))?;
//! println!("open {}", server.url());
//! // A program would now call `server.wait()`.
//! server.stop();
//! # Ok(())
//! # }
//! ```
//!
//! # What is served
//!
//! | path | what |
//! | --- | --- |
//! | `/` and below | the viewer's page, from [`ServeConfig::site`]; it holds nothing of the scene |
//! | `/session?token=T` | JSON: the scene's name and text, warnings, and counts of each layer's values |
//! | `/overview/K?token=T` | layer K, of at most 64 voxels a side, as NRRD in its place in the world |
//! | `/frames?token=T` | a WebSocket: scenes in, pictures out |
//!
//! A request for a picture is a text, `{"pane":0,"number":7,"urgency":"moving","scene":"…"}`; `urgency` is
//! `moving` or `rest`, and the scene a scene file, of which only counts how things look. Where that has some
//! of the layers alone, `"layers":[0,2]` says which, counted from 0. A picture is a binary message: the
//! length of a header in four bytes, the least first, the header as JSON (`pane`, `number`, `urgency`,
//! `format`, `ms`, `n_voxels`, `notes`), and the picture, `jpeg` or `png`. What is at rest is always `png`,
//! without loss. Other texts are `{"pane","number","error"}` and `{"note"}`.
//!
//! A newer request takes the place of an older one of the same pane that has not begun. One that is at rest
//! and being drawn is given up for a newer one of that pane, and put off for whatever moves in another.
//!
//! Reading order: `server` (what there is, and how it ends), `routes` (who may have what), `token`, `site`,
//! `described` and `overview` (what is told of a scene), `session` (a viewer), `hub` (whose turn it is),
//! `painter` (who draws), `message` (what is sent), `listener` (connections that do not move).

#![deny(clippy::exhaustive_enums, clippy::exhaustive_structs)]

mod server;

mod routes;
mod site;
mod token;

mod described;
mod overview;

mod hub;
mod message;
mod painter;
mod session;

mod listener;

pub use server::{ServeConfig, ServeError, Server, serve};
