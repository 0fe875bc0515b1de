//! A renderer on a thread of its own.
//!
//! It takes the oldest request first, so that no pane starves another. Where a graphics card fails, `auto`
//! goes on with the CPU, which is said.
//!
//! What moves may be drawn on the window's device. The thread then looks every millisecond whether it is
//! done: to wait for the device would hold a lock that the window needs to show anything.

use super::{Drawn, DrawnInTexture, Event, FrameSource, Request, Urgency, Wake, WindowDevice};
use slabsplat::{FrameHandle, RenderError, Renderer};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{self, Receiver, Sender};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::task::Poll;
use std::thread::{JoinHandle, sleep};
use std::time::{Duration, Instant};

/// How often is looked whether the window's device has drawn a frame.
const LOOK_EVERY: Duration = Duration::from_millis(1);

/// Draws on a thread of its own. Dropping it gives up what is under way.
#[derive(Debug)]
pub struct RenderingThread {
    shared: Arc<Shared>,
    events: Receiver<Event>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Debug, Default)]
struct Shared {
    queue: Mutex<Queue>,
    has_changed: Condvar,
}

#[derive(Debug, Default)]
struct Queue {
    /// The newest request of each pane, in the order in which panes were asked for.
    waiting: Vec<Request>,
    under_way: Option<(FrameHandle, usize, Urgency)>,
    drawn_by: String,
    ends: bool,
}

impl RenderingThread {
    /// A renderer on the backend called `backend`, as [`Renderer::open`] opens it, which happens on the
    /// thread. `wake` is called there whenever there are events.
    ///
    /// # Errors
    /// If the system starts no more threads.
    pub fn spawn(backend: String, wake: Wake) -> std::io::Result<Self> {
        Self::spawn_in_window(backend, wake, None)
    }

    /// The same, but where the renderer is on wgpu, frames that move are drawn on the window's own device, if
    /// that can, and come as [`Event::InTexture`].
    ///
    /// # Errors
    /// If the system starts no more threads.
    pub fn spawn_in_window(
        backend: String,
        wake: Wake,
        window: Option<WindowDevice>,
    ) -> std::io::Result<Self> {
        let shared = Arc::new(Shared::default());
        let (sender, events) = mpsc::channel();
        let painter = Painter { shared: shared.clone(), sender, wake };
        let thread = std::thread::Builder::new().name("slabsplat-frames".to_owned());
        let thread = thread.spawn(move || painter.paint_all(&backend, window))?;
        Ok(Self { shared, events, thread: Some(thread) })
    }
}

impl FrameSource for RenderingThread {
    fn ask(&mut self, request: Request) {
        let mut queue = self.shared.locked();
        if let Some((frame, pane, Urgency::AtRest)) = &queue.under_way
            && (*pane == request.pane || request.urgency == Urgency::Moving)
        {
            frame.cancel();
        }
        let place = queue.waiting.iter_mut().find(|waiting| waiting.pane == request.pane);
        match place {
            Some(place) => *place = request,
            None => queue.waiting.push(request),
        }
        drop(queue);
        self.shared.has_changed.notify_one();
    }

    fn events(&mut self) -> Vec<Event> {
        self.events.try_iter().collect()
    }

    fn progress(&self) -> Option<f32> {
        self.shared.locked().under_way.as_ref().map(|(frame, ..)| frame.progress())
    }

    fn drawn_by(&self) -> String {
        self.shared.locked().drawn_by.clone()
    }
}

impl Drop for RenderingThread {
    fn drop(&mut self) {
        let mut queue = self.shared.locked();
        queue.ends = true;
        if let Some((frame, ..)) = &queue.under_way {
            frame.cancel();
        }
        drop(queue);
        self.shared.has_changed.notify_one();
        if let Some(thread) = self.thread.take() {
            // It catches what renderers panic with.
            drop(thread.join());
        }
    }
}

impl Shared {
    fn locked(&self) -> MutexGuard<'_, Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The next request and a handle of its frame, as soon as there is one; `None` at the end.
    fn next(&self) -> Option<(Request, FrameHandle)> {
        let mut queue = self.locked();
        while queue.waiting.is_empty() && !queue.ends {
            queue = self.has_changed.wait(queue).unwrap_or_else(PoisonError::into_inner);
        }
        if queue.ends {
            return None;
        }
        let request = queue.waiting.remove(0);
        let frame = FrameHandle::new();
        queue.begin(&frame, &request);
        Some((request, frame))
    }
}

impl Queue {
    fn begin(&mut self, frame: &FrameHandle, request: &Request) {
        self.under_way = Some((frame.clone(), request.pane, request.urgency));
        if self.ends {
            frame.cancel();
        }
    }
}

/// What the thread does.
struct Painter {
    shared: Arc<Shared>,
    sender: Sender<Event>,
    wake: Wake,
}

impl Painter {
    /// Each pane has a renderer, as what one keeps for its next frame is of no use to a frame that is made
    /// otherwise.
    fn paint_all(&self, backend: &str, mut window: Option<WindowDevice>) {
        let Some(first) = self.opened(backend) else { return };
        let mut renderers = vec![first];
        while let Some((request, frame)) = self.shared.next() {
            // It may have gone on with the CPU.
            window.take_if(|_| renderers[0].caps().name != "wgpu");
            if self.is_painted_in_window(&mut window, &request) {
                continue;
            }
            while renderers.len() <= request.pane {
                let Some(another) = self.opened(backend) else { return };
                renderers.push(another);
            }
            let renderer = &mut renderers[request.pane];
            let result = drawn(renderer, &request, &frame);
            self.shared.locked().under_way = None;
            // With `auto` it may have gone on with the CPU.
            self.name(renderer);
            let has_panicked = matches!(result, Err(RenderError::Panicked { .. }));
            self.tell_of(result, &request);
            if has_panicked {
                // Nothing is used again that may be half done.
                let Some(another) = self.opened(backend) else { return };
                *renderer = another;
            }
        }
    }

    /// Draws a frame in the window, if it may be drawn there; whether it was, or will never be.
    fn is_painted_in_window(&self, window: &mut Option<WindowDevice>, request: &Request) -> bool {
        let Some(device) = window.as_mut().filter(|_| WindowDevice::takes(request)) else {
            return false;
        };
        let drawing = AssertUnwindSafe(|| self.drawn_in_window(device, request));
        match catch_unwind(drawing) {
            Ok(Ok(drawn)) => self.tell(Event::InTexture(drawn)),
            Ok(Err(error)) if !WindowDevice::is_failure(&error) => {
                self.tell_of(Err(error), request);
            }
            Ok(Err(error)) => return self.give_up(window, &error.to_string()),
            Err(_) => return self.give_up(window, "the window's device stopped in the middle"),
        }
        self.shared.locked().under_way = None;
        true
    }

    /// The window's device is not asked again; whether it has drawn anything.
    fn give_up(&self, window: &mut Option<WindowDevice>, why: &str) -> bool {
        *window = None;
        self.tell(Event::Note(format!("{why}; frames are read back")));
        false
    }

    fn drawn_in_window(
        &self,
        device: &mut WindowDevice,
        request: &Request,
    ) -> Result<DrawnInTexture, RenderError> {
        let started = Instant::now();
        let begun = device.begin(request)?;
        self.shared.locked().begin(&begun.frame, request);
        loop {
            if let Poll::Ready((texture, n_voxels)) = device.poll(&begun)? {
                let (pane, number) = (request.pane, request.number);
                let ms = started.elapsed().as_secs_f64() * 1e3;
                return Ok(DrawnInTexture { pane, number, texture, ms, n_voxels });
            }
            sleep(LOOK_EVERY);
        }
    }

    fn tell_of(&self, result: Result<Drawn, RenderError>, request: &Request) {
        match result {
            Ok(drawn) => self.tell(Event::Drawn(Box::new(drawn))),
            Err(error) if error.is_cancelled() => (self.wake)(),
            Err(error) => {
                let (pane, number) = (request.pane, request.number);
                self.tell(Event::Failed { pane, number, why: error.to_string() });
            }
        }
    }

    /// A renderer on the backend, or on the CPU where that cannot be had, which is said.
    fn opened(&self, backend: &str) -> Option<Renderer> {
        let teller = || {
            let (sender, wake) = (self.sender.clone(), self.wake.clone());
            move |note: &str| {
                drop(sender.send(Event::Note(note.to_owned())));
                wake();
            }
        };
        let opened = Renderer::open(backend, teller()).or_else(|error| {
            self.tell(Event::Note(format!("{error}; the CPU draws")));
            Renderer::open("cpu", teller())
        });
        let renderer =
            opened.inspect_err(|error| self.tell(Event::Note(error.to_string()))).ok()?;
        self.name(&renderer);
        Some(renderer)
    }

    fn name(&self, renderer: &Renderer) {
        let caps = renderer.caps();
        self.shared.locked().drawn_by = match caps.name {
            "cpu" => "CPU".to_owned(),
            name => format!("{name}: {}", caps.device),
        };
    }

    fn tell(&self, event: Event) {
        // Nobody hears it only at the end.
        drop(self.sender.send(event));
        (self.wake)();
    }
}

fn drawn(
    renderer: &mut Renderer,
    request: &Request,
    frame: &FrameHandle,
) -> Result<Drawn, RenderError> {
    let started = Instant::now();
    let opened = &request.opened;
    // What panics once would do so again, and the thread goes on.
    let drawing =
        AssertUnwindSafe(|| renderer.picture_as(&opened.scene, opened.acquisition, frame));
    let picture = catch_unwind(drawing).unwrap_or_else(|_| {
        Err(RenderError::Panicked { message: "the renderer stopped in the middle".to_owned() })
    })?;
    Ok(Drawn {
        pane: request.pane,
        number: request.number,
        urgency: request.urgency,
        n_voxels: picture.frame.stats.n_voxels,
        image: picture.frame.image,
        notes: picture.notes,
        ms: Some(started.elapsed().as_secs_f64() * 1e3),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat::io::{SceneFile, VolumeSource};
    use slabsplat::{Mode, OpenScene};
    use std::time::Duration;

    fn scene() -> OpenScene {
        let source = VolumeSource::Builtin { name: "sphere".to_owned(), size: Some(24) };
        let mut file = SceneFile::of_volume(source);
        [file.image.width, file.image.height] = [32, 24];
        OpenScene::open(&file).unwrap()
    }

    fn thread() -> (RenderingThread, Receiver<()>) {
        let (sender, woken) = mpsc::channel();
        let sender = Mutex::new(sender);
        let wake: Wake = Arc::new(move || _ = sender.lock().unwrap().send(()));
        (RenderingThread::spawn("cpu".to_owned(), wake).unwrap(), woken)
    }

    /// Events until `n` of them have come.
    fn events(thread: &mut RenderingThread, woken: &Receiver<()>, n: usize) -> Vec<Event> {
        let mut events = Vec::new();
        while events.len() < n {
            woken.recv_timeout(Duration::from_secs(60)).unwrap();
            events.extend(thread.events());
        }
        events
    }

    fn request(number: u64, opened: &OpenScene, urgency: Urgency) -> Request {
        Request { pane: 0, number, opened: opened.clone(), urgency, is_read_back: false }
    }

    #[test]
    fn pictures_are_those_of_a_renderer() {
        let (mut thread, woken) = thread();
        let opened = scene();
        thread.ask(request(1, &opened, Urgency::AtRest));
        let events = events(&mut thread, &woken, 1);
        let [Event::Drawn(drawn)] = &events[..] else { panic!("{events:?}") };
        let mut renderer = Renderer::open("cpu", |_| {}).unwrap();
        let picture = renderer.picture(&opened.scene, opened.acquisition).unwrap();
        assert_eq!(drawn.image, picture.frame.image);
        assert_eq!(thread.drawn_by(), "CPU");
    }

    #[test]
    fn the_newest_request_is_drawn() {
        let (mut thread, woken) = thread();
        let mut opened = scene();
        for number in 1..=200 {
            opened.scene.camera = opened.scene.camera.orbited(0.01);
            thread.ask(request(number, &opened, Urgency::Moving));
        }
        let mut numbers = Vec::new();
        while numbers.last() != Some(&200) {
            for event in events(&mut thread, &woken, 1) {
                let Event::Drawn(drawn) = event else { panic!("{event:?}") };
                numbers.push(drawn.number);
            }
        }
        assert!(numbers.is_sorted() && numbers.len() < 200, "{numbers:?}");
    }

    #[test]
    fn a_scene_that_cannot_be_drawn_is_an_error_and_the_next_is_not() {
        let (mut thread, woken) = thread();
        let mut opened = scene();
        opened.scene.settings.mode = Mode::Isosurfaces;
        thread.ask(request(1, &opened, Urgency::AtRest));
        let failed = events(&mut thread, &woken, 1);
        assert!(matches!(&failed[..], [Event::Failed { number: 1, .. }]), "{failed:?}");
        thread.ask(request(2, &scene(), Urgency::AtRest));
        let drawn = events(&mut thread, &woken, 1);
        assert!(matches!(&drawn[..], [Event::Drawn(_)]), "{drawn:?}");
    }
}
