//! A server, and viewers that behave well or badly.

mod bad_viewers;
mod client;
mod many;
mod pictures;
mod requests;
