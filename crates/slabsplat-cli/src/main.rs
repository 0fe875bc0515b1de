//! The program `slabsplat`: pictures of volumes, from the command line.
//!
//! It parses flags, asks the facade, and prints. Whatever decides a pixel is in the libraries, so that
//! other programs can do all that this one can.
//!
//! Exit codes: 0 done, 1 it could not be done (one line on stderr says why), 2 wrong usage.
//!
//! Reading order: [`input`] and [`flags`] (what is drawn), then a command each: [`render`], `view`,
//! `serve`, [`batch`], [`turntable`], [`film`], [`scene`], [`info`], [`convert`], [`tf`], [`presets`],
//! [`popping`], [`compare`], [`bench`], [`demo`], [`reproduce`], [`backends`], [`manual`]; [`filming`] is
//! how films are made, [`ranks`] who else draws; [`terminal`], [`progress`], [`columns`], [`stats`] and
//! [`meter`] are what they print with, [`output`] is how pictures are written, [`advice`] what helps where a
//! backend does not, [`help`] what stands in help beside the flags, and [`environment`] what drivers find.

mod flags;
mod input;

mod backends;
mod batch;
mod bench;
mod compare;
mod convert;
mod demo;
#[cfg(feature = "mpi")]
mod distributed;
mod divided;
mod film;
mod info;
mod manual;
mod plain;
mod popping;
mod presets;
mod render;
mod reproduce;
mod scene;
#[cfg(feature = "serve")]
mod serve;
mod tf;
mod turntable;
#[cfg(feature = "viewer")]
mod view;

mod advice;
mod columns;
mod environment;
mod filming;
mod help;
mod mesh_info;
mod meter;
mod output;
mod painter;
mod progress;
mod ranks;
mod stats;
mod stdin;
mod terminal;

use anyhow::Result;
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use std::process::ExitCode;

/// Renders volumes by image-aligned splatting, which does not pop when the camera turns.
#[derive(Parser)]
#[command(name = "slabsplat", version, arg_required_else_help = true)]
struct Cli {
    #[command(flatten)]
    running: flags::RunningFlags,

    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Render(Box<render::RenderArgs>),
    #[cfg(feature = "viewer")]
    View(Box<view::ViewArgs>),
    #[cfg(feature = "serve")]
    Serve(Box<serve::ServeArgs>),
    Batch(Box<batch::BatchArgs>),
    Turntable(Box<turntable::TurntableArgs>),
    Film(Box<film::FilmArgs>),
    Scene(Box<scene::SceneArgs>),
    Info(info::InfoArgs),
    Convert(convert::ConvertArgs),
    Tf(Box<tf::TfArgs>),
    Presets(presets::PresetsArgs),
    Demo(demo::DemoArgs),
    Reproduce(reproduce::ReproduceArgs),
    Popping(Box<popping::PoppingArgs>),
    Compare(Box<compare::CompareArgs>),
    Bench(Box<bench::BenchArgs>),
    Backends(backends::BackendsArgs),
    Completions(manual::CompletionsArgs),
    #[command(hide = true)]
    Manual(manual::ManualArgs),
}

fn main() -> ExitCode {
    environment::complete();
    output::end_between_pictures();
    let Cli { running, command } = parsed();
    match running.start().and_then(|()| run(command)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            if !terminal::is_unsaid(&error) {
                terminal::report(format_args!("error: {}", terminal::one_line(&error)));
            }
            ExitCode::FAILURE
        }
    }
}

/// What the command line says; if it cannot be understood, or asks for help, this does not return.
fn parsed() -> Cli {
    let matches = command_line().get_matches();
    Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.exit())
}

/// What the command line may say.
fn command_line() -> clap::Command {
    help::completed(Cli::command())
}

fn run(command: Command) -> Result<()> {
    match command {
        Command::Render(args) => render::run(&args),
        #[cfg(feature = "viewer")]
        Command::View(args) => view::run(*args),
        #[cfg(feature = "serve")]
        Command::Serve(args) => serve::run(*args),
        Command::Batch(args) => batch::run(*args),
        Command::Turntable(args) => turntable::run(&args),
        Command::Film(args) => film::run(&args),
        Command::Scene(args) => scene::run(&args),
        Command::Info(args) => info::run(&args),
        Command::Convert(args) => convert::run(&args),
        Command::Tf(args) => tf::run(&args),
        Command::Presets(args) => presets::run(&args),
        Command::Demo(args) => demo::run(&args),
        Command::Reproduce(args) => reproduce::run(&args),
        Command::Popping(args) => popping::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Bench(args) => bench::run(&args),
        Command::Backends(args) => backends::run(&args),
        Command::Completions(args) => manual::print_completions(&args, command_line()),
        Command::Manual(args) => manual::write(&args, command_line()),
    }
}
