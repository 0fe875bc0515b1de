//! What a pixel is, by definition: the page that the documentation of all crates cites as "model §3". Nothing
//! is here but that page.
//!
//! Paths in it are those of the [repository](https://github.com/slabsplat/slabsplat), which has the other
//! pages and the tests that it names.
//!
//! ---
//!
#![doc = include_str!("../docs/model.md")]
