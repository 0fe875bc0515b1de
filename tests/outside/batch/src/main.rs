//! `batch SCENE.toml ...`: renders each scene to a PNG beside it, and goes on past those that fail.

use slabsplat::Renderer;
use std::path::PathBuf;
use std::process::ExitCode;

fn main() -> ExitCode {
    let scenes: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let mut renderer = match Renderer::open("auto", |note| eprintln!("{note}")) {
        Ok(renderer) => renderer,
        Err(error) => {
            eprintln!("error: {error}");
            return ExitCode::FAILURE;
        }
    };
    let mut n_failed = 0;
    for scene in &scenes {
        match batch::render(&mut renderer, scene) {
            Ok(picture) => println!("{}", picture.display()),
            Err(error) => {
                eprintln!("error: {error}");
                n_failed += 1;
            }
        }
    }
    eprintln!("{} of {} scenes rendered", scenes.len() - n_failed, scenes.len());
    if n_failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
