//! `cargo xtask ci`: what must pass before a change is handed in.
//!
//! Beside all other commands that judge it builds each crate alone that has no features, as a build of the
//! whole workspace unites those of dependencies. Of crates that have features lint does so.

use anyhow::Result;

use crate::deny::{self, Deny};
use crate::test::{self, Test};
use crate::web::{self, Web};
use crate::{lint, msrv, outside, package, scalar, semver};

pub(crate) fn run() -> Result<()> {
    lint::run()?;
    test::run(&Test::default())?;
    scalar::run()?;
    package::run()?;
    web::run(Web::OF_PACKAGES)?;
    outside::run()?;
    msrv::run(false)?;
    deny::run(&Deny::default())?;
    semver::run(None)?;
    lint::check_alone(|package| !lint::has_features(package))
}
