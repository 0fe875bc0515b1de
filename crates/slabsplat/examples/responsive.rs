//! What a window does that never stands still while its pictures are drawn: it asks for a frame whenever the
//! user drags the mouse, shows progress meanwhile, and cancels what nobody waits for any more. The window is
//! one of text: `cargo run --release -p slabsplat --example responsive`.

use slabsplat::{Automatic, Frame, ImageDesc, PendingFrame, RenderSettings, RenderThread, io};
use std::error::Error;
use std::task::Poll;
use std::thread;
use std::time::{Duration, Instant};

/// An event loop turns 60 times a second.
const TURN: Duration = Duration::from_millis(16);

/// The user drags for so many turns of it.
const N_DRAGGED: usize = 20;

const RADIANS_PER_TURN: f64 = 0.05;

fn main() -> Result<(), Box<dyn Error>> {
    let volume = io::builtin_volume("neuron", Some(96))?;
    let image = ImageDesc::new(384, 384);
    let mut scene = Automatic::new(volume).scene(image, RenderSettings::default());
    let renderer = RenderThread::open("auto", |note| eprintln!("{note}"))?;

    let mut window = Window::default();
    for turn in 0..N_DRAGGED {
        scene.camera = scene.camera.orbited(RADIANS_PER_TURN);
        let asked = Instant::now();
        // What has not begun is replaced; what is under way is shown when it is done.
        window.pending.push(renderer.submit_newest(&scene));
        println!("turn {turn}: asked within {:?}", asked.elapsed());
        window.update()?;
        thread::sleep(TURN);
    }
    while !window.pending.is_empty() {
        window.update()?;
        thread::sleep(TURN);
    }
    println!("{} frames shown, {} replaced by newer ones", window.n_shown, window.n_replaced);

    // A large picture, of which the user is tired at once.
    scene.image = scene.image.size(2048, 2048);
    let large = renderer.submit(&scene);
    thread::sleep(TURN);
    println!("large picture: {:.0} % drawn, and cancelled", 100.0 * large.progress());
    large.cancel();
    match large.wait() {
        Err(error) if error.is_cancelled() => Ok(()),
        other => Err(format!("it should be cancelled: {other:?}").into()),
    }
}

/// What it shows, and what it waits for.
#[derive(Default)]
struct Window {
    shown: Option<Frame>,
    pending: Vec<PendingFrame>,
    n_shown: u32,
    n_replaced: u32,
}

impl Window {
    /// Takes what is done since the last turn. It never waits.
    fn update(&mut self) -> Result<(), Box<dyn Error>> {
        for mut frame in std::mem::take(&mut self.pending) {
            match frame.try_take() {
                Ok(Poll::Ready(frame)) => {
                    self.shown = Some(frame);
                    self.n_shown += 1;
                }
                Ok(Poll::Pending) => {
                    println!("    {:.0} % drawn", 100.0 * frame.progress());
                    self.pending.push(frame);
                }
                Err(error) if error.is_cancelled() => self.n_replaced += 1,
                Err(error) => return Err(error.into()),
            }
        }
        Ok(())
    }
}

#[test]
fn responsive_runs() {
    main().unwrap();
}
