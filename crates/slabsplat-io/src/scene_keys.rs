//! Every key of a scene file, what it means, and what it may be: an example that has all of them. Nothing is
//! here but that example.
//!
#![doc = concat!("```toml\n", include_str!("../docs/example.toml"), "```")]
