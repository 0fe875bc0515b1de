//! `slabsplat serve`: a scene in browsers, rendered here.

use crate::flags::SceneFlags;
use crate::progress::Progress;
use crate::{output, terminal};
use anyhow::Result;
use clap::Args;
use slabsplat_serve::{ServeConfig, serve};
use std::path::PathBuf;
use std::sync::Arc;

/// Look at a volume or a scene in a browser, also on another machine
///
/// It is opened and rendered here, and the browser gets pictures. The link that is printed is the key: who
/// has it may look, and change how things look, and nobody else. To look from another machine, have ssh
/// forward the port: ssh -L 8080:127.0.0.1:8080 THIS-MACHINE. Ctrl-C ends it.
#[derive(Args)]
pub(crate) struct ServeArgs {
    /// The port that is listened to; 0 for any that is free
    #[arg(long, default_value_t = 8080, help_heading = "Server")]
    port: u16,

    /// The address that is listened to. Others than this machine's own let in whoever reaches it and has the
    /// link, and what is sent is not encrypted
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1", help_heading = "Server")]
    host: String,

    /// The key in the link, of letters, digits and -._~ [default: one at random]
    #[arg(long, value_name = "TEXT", help_heading = "Server")]
    token: Option<String>,

    /// How many may look at the same time
    #[arg(long, value_name = "N", default_value_t = 8, help_heading = "Server")]
    sessions: usize,

    /// The folder of the viewer's page [default: where it is installed]
    #[arg(long, value_name = "FOLDER", help_heading = "Server")]
    site: Option<PathBuf>,

    #[command(flatten)]
    scene: SceneFlags,
}

pub(crate) fn run(args: ServeArgs) -> Result<()> {
    let progress = Progress::start("reading", 0);
    let opened = args.scene.open()?;
    drop(progress);
    terminal::warn_all(&opened.warnings);
    let mut config = ServeConfig::default().port(args.port).max_sessions(args.sessions);
    (config.host, config.token, config.site) = (args.host, args.token, args.site);
    let server = Arc::new(serve(opened, config)?);
    if !server.address().ip().is_loopback() {
        terminal::warn("other machines reach this server, and what is sent is not encrypted");
    }
    let interrupted = server.clone();
    output::when_interrupted(move || interrupted.stop());
    terminal::answer(&format!("{}\n", server.url()))?;
    terminal::say(format_args!("open that in a browser; Ctrl-C ends it"));
    server.wait();
    Ok(())
}
