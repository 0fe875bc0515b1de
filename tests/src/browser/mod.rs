//! A browser to run tests in: a [`Server`] that gives it the pages of a folder and takes what these post, and
//! a [`Chromium`] that needs no screen and no graphics card.

mod chromium;
mod server;

pub use chromium::Chromium;
pub use server::{Message, Server};
