//! A browser to run tests in: a [`Server`] that gives it files and takes what its pages post, and a
//! [`Chromium`] that needs no screen and no graphics card, with [`Page`]s that are used by mouse and keys.
//!
//! Nothing else has to be installed: a page is driven by the browser's own DevTools protocol, over two pipes
//! (`devtools`).
//! For tests and benchmarks only: nothing that draws a picture knows of this crate.
//!
//! Reading order: `server`, `chromium`, `page`, `devtools`.

mod server;

mod chromium;

mod page;

mod devtools;

pub use chromium::{Chromium, Graphics};
pub use page::{Download, Key, Page};
pub use server::{Message, Server};
