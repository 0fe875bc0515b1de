//! Where frames come from: a renderer on a thread here, one in the page, or a server.
//!
//! A [`FrameSource`] is asked for pictures of scenes and never waited for. What it is asked replaces what it
//! was asked before for the same pane and has not begun; a picture that is only made better is given up for
//! whatever is newer. Where one device draws the window and its frames, those that move stay on it.

mod window_texture;

#[cfg(not(target_arch = "wasm32"))]
mod in_window;
#[cfg(not(target_arch = "wasm32"))]
mod thread;

#[cfg(not(target_arch = "wasm32"))]
pub use in_window::WindowDevice;
#[cfg(not(target_arch = "wasm32"))]
pub use thread::RenderingThread;
pub use window_texture::WindowTexture;

use slabsplat::{Image, OpenScene};

/// A picture that is wanted.
#[derive(Clone, Debug)]
pub struct Request {
    /// Where it is shown: pictures of different panes do not replace each other.
    pub pane: usize,
    /// Tells pictures of a pane from each other; later ones have greater numbers.
    pub number: u64,
    /// What it shows; its image has the size of the picture.
    pub opened: OpenScene,
    /// How soon it is wanted.
    pub urgency: Urgency,
    /// Whether its pixels are wanted even if it moves, as by who compares frames.
    pub is_read_back: bool,
}

/// How soon a picture is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Urgency {
    /// Something moves: a frame that has begun is drawn to its end, so that there is something to be seen.
    Moving,
    /// All is at rest: a frame that has begun is given up for one that is newer.
    AtRest,
}

/// What came of requests.
#[derive(Debug)]
pub enum Event {
    /// A picture is there.
    Drawn(Box<Drawn>),
    /// A picture that moves is there, in a texture of the window's.
    InTexture(DrawnInTexture),
    /// There is none.
    Failed {
        /// The request's pane.
        pane: usize,
        /// The request's number.
        number: u64,
        /// Why, in a line for people.
        why: String,
    },
    /// Something that people should know.
    Note(String),
}

/// A picture, and what it was asked for as.
#[derive(Debug)]
pub struct Drawn {
    /// The request's pane.
    pub pane: usize,
    /// The request's number.
    pub number: u64,
    /// The request's urgency.
    pub urgency: Urgency,
    /// The picture, finished.
    pub image: Image,
    /// What has to be said of it, a line each.
    pub notes: Vec<String>,
    /// What it took, from when it was begun; without a clock nothing.
    pub ms: Option<f64>,
    /// How many voxels were drawn.
    pub n_voxels: u64,
}

/// A picture that moves and was not read back, and what it was asked for as.
#[derive(Debug)]
pub struct DrawnInTexture {
    /// The request's pane.
    pub pane: usize,
    /// The request's number.
    pub number: u64,
    /// Where the picture is.
    pub texture: WindowTexture,
    /// What it took, from when it was begun.
    pub ms: f64,
    /// How many voxels were drawn.
    pub n_voxels: u64,
}

/// Where frames come from.
pub trait FrameSource {
    /// Asks for a picture.
    fn ask(&mut self, request: Request);

    /// What came of requests since it was asked last.
    fn events(&mut self) -> Vec<Event>;

    /// How much of the frame that is being drawn is done, 0 … 1, if one is and that is known.
    fn progress(&self) -> Option<f32>;

    /// What draws, for people.
    fn drawn_by(&self) -> String;
}

/// Calls whoever shows frames: something has happened.
pub type Wake = std::sync::Arc<dyn Fn() + Send + Sync>;
