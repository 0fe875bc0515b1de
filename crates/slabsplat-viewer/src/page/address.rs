//! The page's address, and what it says.

use web_sys::{UrlSearchParams, window};

/// What the address says of `name`, if anything.
pub(super) fn parameter(name: &str) -> Option<String> {
    let search = window()?.location().search().ok()?;
    UrlSearchParams::new_with_str(&search).ok()?.get(name).filter(|value| !value.is_empty())
}

/// The backend that the address names.
pub(crate) fn backend() -> Option<String> {
    parameter("backend")
}

/// What lets the page into its server, if that draws.
pub(crate) fn token() -> Option<String> {
    parameter("token")
}

/// The address of something beside the page, on the same server, for a protocol like `http` or `ws`.
pub(super) fn beside(protocol: &str, path: &str) -> Option<String> {
    let location = window()?.location();
    let is_safe = location.protocol().ok()? == "https:";
    let (host, folder) = (location.host().ok()?, location.pathname().ok()?);
    let folder = &folder[..=folder.rfind('/')?];
    let s = if is_safe { "s" } else { "" };
    Some(format!("{protocol}{s}://{host}{folder}{path}"))
}
