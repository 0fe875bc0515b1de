//! How soon the viewer shows something, and how fast frames come while a camera goes around: all of it but
//! the window, which is the system's to draw.
//!
//! ```sh
//! cargo run --release -p slabsplat-viewer --example pace -- head.nii.gz [WIDTH HEIGHT [BACKEND]]
//! ```

use slabsplat::io::{SceneFile, VolumeSource};
use slabsplat_viewer::state::{Document, FrameBudget, Pacing, orbited};
use slabsplat_viewer::{Event, FrameSource, RenderingThread, Request, Urgency, Wake};
use std::error::Error;
use std::sync::mpsc;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Seconds for which the camera goes around.
const TURNING_S: f64 = 8.0;

/// What a pointer tells in a second.
const EVENTS_PER_SECOND: f64 = 60.0;

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let path = args.first().ok_or("name a volume")?;
    let side = |idx: usize, usual: u32| args.get(idx).map_or(Ok(usual), |text| text.parse());
    let view = [side(1, 950)?, side(2, 750)?];
    let backend = args.get(3).map_or("cpu", String::as_str);

    let started = Instant::now();
    let (sender, woken) = mpsc::channel();
    let sender = Mutex::new(sender);
    let wake: Wake = Arc::new(move || {
        // Nobody is there to be woken once the last frame is seen.
        let _sent = sender.lock().map(|sender| sender.send(()));
    });
    let mut source = RenderingThread::spawn(backend.to_owned(), wake)?;
    let file = SceneFile::of_volume(VolumeSource::File(path.into()));
    let mut document = Document::open(&file, path.clone(), view)?;
    println!("open after {:.0} ms", ms_since(started));

    let (mut pacing, mut budget) = (Pacing::default(), FrameBudget::new(FrameBudget::USUAL_MS));
    let mut seen: Vec<(f64, Urgency, [u32; 2])> = Vec::new();
    let mut turned = 0.0;
    // Large volumes take longer to open than the camera goes around.
    let begun_s = |seen: &[(f64, Urgency, [u32; 2])]| seen.first().map(|(ms, ..)| ms / 1e3);
    let is_over = |seen: &[(f64, Urgency, [u32; 2])], now: f64| {
        let is_whole = seen.last().is_some_and(|last| last.1 == Urgency::AtRest);
        is_whole && begun_s(seen).is_some_and(|begun| TURNING_S + 0.2 < now - begun)
    };
    while !is_over(&seen, started.elapsed().as_secs_f64()) {
        let now = started.elapsed().as_secs_f64();
        let is_turning = begun_s(&seen).is_some_and(|begun| now - begun < TURNING_S);
        if is_turning && 1.0 / EVENTS_PER_SECOND <= now - turned {
            turned = now;
            document.move_camera(|camera| orbited(camera, [0.005, 0.001].into()));
        }
        for asked in pacing.step(document.revision(), 1, now, is_turning) {
            let opened = match asked.urgency {
                Urgency::AtRest => document.pane(0),
                Urgency::Moving => budget.preview(document.pane(0), view),
            };
            let (pane, number, urgency) = (asked.pane, asked.number, asked.urgency);
            source.ask(Request { pane, number, opened, urgency, is_read_back: true });
        }
        // Woken or not, there is the next pointer event to be told.
        let _woken = woken.recv_timeout(Duration::from_millis(4));
        for event in source.events() {
            let Event::Drawn(drawn) = event else { continue };
            pacing.came(drawn.pane, drawn.number);
            if let (Urgency::Moving, Some(ms)) = (drawn.urgency, drawn.ms) {
                budget.took(ms);
            }
            let size = [drawn.image.width(), drawn.image.height()];
            seen.push((ms_since(started), drawn.urgency, size));
        }
    }
    tell(&seen);
    let of_scene = document.pane(0).scene.settings.tolerance;
    println!("tolerance {of_scene}, and {} while it turned", budget.tolerance(of_scene));
    Ok(())
}

fn ms_since(started: Instant) -> f64 {
    started.elapsed().as_secs_f64() * 1e3
}

fn tell(seen: &[(f64, Urgency, [u32; 2])]) {
    let Some((first, .., size)) = seen.first() else { return };
    println!("first picture after {first:.0} ms, {} x {}", size[0], size[1]);
    let moving = |pair: &&[(f64, Urgency, [u32; 2])]| {
        pair.iter().all(|(_, urgency, _)| *urgency == Urgency::Moving)
    };
    let mut gaps: Vec<f64> =
        seen.windows(2).filter(moving).map(|pair| pair[1].0 - pair[0].0).collect();
    gaps.sort_by(f64::total_cmp);
    let at =
        |share: f64| gaps.get((share * gaps.len() as f64) as usize).copied().unwrap_or(f64::NAN);
    let size = seen.iter().rev().find(|(_, urgency, _)| *urgency == Urgency::Moving);
    let size = size.map_or([0, 0], |(.., size)| *size);
    println!(
        "turning: {} frames, {:.0} ms from one to the next, 95 of 100 within {:.0} ms, in the end {} x {}",
        gaps.len() + 1,
        at(0.5),
        at(0.95),
        size[0],
        size[1],
    );
    if let [.., (before, ..), (last, ..)] = seen {
        println!("whole {:.0} ms after the last of them", last - before);
    }
}
