//! A Vulkan driver for the tests of the GPU backends, installed where that can be done.
//!
//! No graphics card is needed: Mesa's lavapipe, a driver that draws on the CPU, does, and a distribution packs it.
//! [`plan`] decides what is to be done about what is missing; [`machine`] looks, and [`apt`] installs.
//! Whether a driver finds a device is not asked here: the tests say so when they run.
//!
//! `SLABSPLAT_REQUIRE_GPU`, set to anything, makes the absence of a GPU or software driver a failure, here and in the
//! tests; without it they are skipped where there is none.
//! Only Linux is looked after: elsewhere drivers come with the system, and the tests skip by themselves.

mod machine;

use anyhow::{Result, bail};

use crate::apt::{self, Installer};

/// What the tests of the GPU backends need, the most important first.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Need {
    Loader,
    Driver,
    /// Not to run, but to notice what a driver forgives.
    Validation,
}

#[derive(Debug, PartialEq)]
enum Plan {
    /// Nothing is missing.
    Ready,
    /// To be said before it is installed.
    Install(String),
    /// To be said before the tests run without it.
    DoWithout(String),
    Fail(String),
}

/// The packages of Debian and its descendants; the tools check what the shaders are translated to.
const PACKAGES: &[&str] =
    &["mesa-vulkan-drivers", "libvulkan1", "vulkan-validationlayers", "spirv-tools"];

/// Says at most one line before it installs and one if the tests must do without; none where all is there.
pub(crate) fn set_up() -> Result<()> {
    if !cfg!(target_os = "linux") {
        return Ok(());
    }
    let is_required = std::env::var_os("SLABSPLAT_REQUIRE_GPU").is_some();
    let mut missing = machine::missing();
    if missing.is_empty() {
        return Ok(());
    }
    let mut installer = Installer::of_machine();
    if let Plan::Install(line) = plan(&missing, &installer, is_required) {
        eprintln!("test: {line}");
        installer = apt::install(PACKAGES);
        missing = machine::missing();
    }
    match plan(&missing, &installer, is_required) {
        Plan::Ready => {}
        Plan::Install(line) | Plan::DoWithout(line) => eprintln!("test: {line}"),
        Plan::Fail(message) => bail!(message),
    }
    Ok(())
}

fn plan(missing: &[Need], installer: &Installer, is_required: bool) -> Plan {
    if missing.is_empty() {
        return Plan::Ready;
    }
    let lack = format!("{} missing", named(missing));
    if *installer == Installer::Apt {
        return Plan::Install(format!("{lack}: installing {}", PACKAGES.join(", ")));
    }
    let remedy = installer.remedy(PACKAGES);
    if missing == [Need::Validation] {
        return Plan::DoWithout(format!(
            "{lack}: the GPU backends are tested without it; {remedy}"
        ));
    }
    if is_required {
        let why = "SLABSPLAT_REQUIRE_GPU asks for a GPU or a software driver";
        return Plan::Fail(format!("{lack}, and {why}; {remedy}"));
    }
    Plan::DoWithout(format!("{lack}: the tests of the GPU backends will be skipped; {remedy}"))
}

fn named(missing: &[Need]) -> String {
    let names = missing.iter().map(|need| match need {
        Need::Loader => "the Vulkan loader (libvulkan.so.1)",
        Need::Driver => "a Vulkan driver",
        Need::Validation => "Vulkan's validation layer",
    });
    let verb = if missing.len() == 1 { "is" } else { "are" };
    format!("{} {verb}", names.collect::<Vec<_>>().join(" and "))
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: &[Need] = &[Need::Loader, Need::Driver, Need::Validation];

    fn text(plan: Plan) -> String {
        let text = match plan {
            Plan::Ready => String::new(),
            Plan::Install(line) => format!("install: {line}"),
            Plan::DoWithout(line) => format!("do without: {line}"),
            Plan::Fail(line) => format!("fail: {line}"),
        };
        assert!(!text.contains('\n'), "one line: {text:?}");
        text
    }

    fn check(missing: &[Need], installer: &Installer, is_required: bool, expected: &[&str]) {
        let text = text(plan(missing, installer, is_required));
        for part in expected {
            assert!(text.contains(part), "{text:?} contains {part:?}");
        }
    }

    #[test]
    fn plan_ready_says_nothing() {
        for installer in [Installer::Apt, Installer::None, Installer::Tried(None)] {
            for is_required in [false, true] {
                assert_eq!(plan(&[], &installer, is_required), Plan::Ready, "{installer:?}");
            }
        }
    }

    #[test]
    fn plan_install_where_possible() {
        let packages = "installing mesa-vulkan-drivers, libvulkan1, vulkan-validationlayers";
        for is_required in [false, true] {
            check(ALL, &Installer::Apt, is_required, &["install: ", packages]);
            let layer = "install: Vulkan's validation layer is missing";
            check(&[Need::Validation], &Installer::Apt, is_required, &[layer]);
        }
    }

    #[test]
    fn plan_without_installer() {
        let lack = "the Vulkan loader (libvulkan.so.1) and a Vulkan driver and Vulkan's validation \
                    layer are missing";
        let command = "apt-get install --no-install-recommends mesa-vulkan-drivers libvulkan1";
        check(ALL, &Installer::None, false, &["do without: ", lack, "skipped", command]);
        check(ALL, &Installer::None, true, &["fail: ", lack, "SLABSPLAT_REQUIRE_GPU", command]);
        let driver = "do without: a Vulkan driver is missing: the tests of the GPU backends";
        check(&[Need::Driver], &Installer::None, false, &[driver]);
    }

    #[test]
    fn plan_after_installing() {
        let failed = Installer::Tried(Some("apt-get failed".to_owned()));
        check(&[Need::Driver], &failed, false, &["do without: ", "skipped", "apt-get failed"]);
        check(&[Need::Driver], &failed, true, &["fail: ", "apt-get failed"]);
        check(&[Need::Loader], &Installer::Tried(None), true, &["fail: ", "is not found"]);
    }

    /// The variable speaks of drivers; without the layer the tests run all the same.
    #[test]
    fn plan_validation_is_no_failure() {
        for is_required in [false, true] {
            let expected =
                ["do without: Vulkan's validation layer is missing", "tested without it"];
            check(&[Need::Validation], &Installer::None, is_required, &expected);
        }
    }
}
