//! The viewer in a browser, as people use it: by mouse and keys, and looked at. `cargo xtask web` builds the
//! page, and runs this.

mod alone;
#[cfg(feature = "serve")]
mod served;
mod used;

use used::{Used, first_picture};

use std::path::PathBuf;

/// Names the folder with the pages.
const SITE: &str = "SLABSPLAT_SITE";

/// The folder of the viewer's page, or `None` after a line.
fn site() -> Option<PathBuf> {
    let site = std::env::var_os(SITE);
    if site.is_none() {
        println!("skipped: `cargo xtask web` runs this in a browser");
    }
    site.map(|site| PathBuf::from(site).join("viewer"))
}
