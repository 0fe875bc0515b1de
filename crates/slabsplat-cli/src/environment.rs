//! What drivers expect of the environment, so that a run that succeeds prints only what it has to say.

/// Sees to it that there is an `XDG_RUNTIME_DIR`, by starting the program once more in its own place if there
/// is none.
///
/// wgpu opens Vulkan with all that screens need; then Mesa asks Wayland for the screen, and Wayland's library
/// complains on stderr, several times, if it is not set, as in a container or over ssh. A
/// folder that does not exist is answer enough. It is set from outside since no safe code can change the
/// environment from within.
#[cfg(all(target_os = "linux", feature = "wgpu"))]
pub(crate) fn complete() {
    use std::os::unix::process::CommandExt;
    use std::path::Path;
    use std::process::Command;

    const VARIABLE: &str = "XDG_RUNTIME_DIR";
    if std::env::var_os(VARIABLE).is_some_and(|folder| Path::new(&folder).is_absolute()) {
        return;
    }
    let Ok(program) = std::env::current_exe() else { return };
    let mut args = std::env::args_os();
    let mut command = Command::new(program);
    if let Some(name) = args.next() {
        command.arg0(name);
    }
    // It only returns if that is not possible, and then the diagnostics have to be borne.
    let _ = command.args(args).env(VARIABLE, "/nonexistent").exec();
}

#[cfg(not(all(target_os = "linux", feature = "wgpu")))]
pub(crate) fn complete() {}
