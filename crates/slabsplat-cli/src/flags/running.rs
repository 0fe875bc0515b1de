//! Flags of the program itself, which every command has.

use crate::terminal::{self, Loudness};
use anyhow::{Context, Result};
use clap::Args;

#[derive(Args)]
#[command(next_help_heading = "Program")]
pub(crate) struct RunningFlags {
    /// Tell on stderr whatever is known of the work, statistics included
    #[arg(short, long, global = true)]
    verbose: bool,

    /// Say nothing on stderr but errors
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    quiet: bool,

    /// Threads that the CPU works on [default: one for each of its cores]
    #[arg(
        long, value_name = "N", global = true,
        value_parser = clap::value_parser!(u16).range(1..=MAX_THREADS)
    )]
    threads: Option<u16>,
}

/// No machine has use for more, and each of them takes memory.
const MAX_THREADS: i64 = 1024;

impl RunningFlags {
    /// Sees to it that the program runs as the flags say.
    pub(crate) fn start(&self) -> Result<()> {
        if self.quiet {
            terminal::set_loudness(Loudness::Quiet);
        } else if self.verbose {
            terminal::set_loudness(Loudness::Verbose);
        }
        let Some(threads) = self.threads else { return Ok(()) };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(usize::from(threads));
        pool.build_global().with_context(|| format!("cannot start {threads} threads"))
    }
}
