//! What is opened and saved: names, sizes, and the system's dialogs.

use eframe::egui::{Align2, Context, DragValue, Key, Ui, Window};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Receiver};

/// What becomes of what is opened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum OpenAs {
    /// It is shown instead of what is open.
    Document,
    /// It is added to what is open.
    Layer,
}

/// Something that is to be opened or saved.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Wish {
    /// A volume, a scene, a picture that says what it shows; in a page what is under an address.
    Open(OpenAs, PathBuf),
    /// A file that was chosen in a page.
    #[cfg(target_arch = "wasm32")]
    OpenBytes(OpenAs, String, Vec<u8>),
    /// The scene, as a file.
    SaveScene(PathBuf),
    /// The picture, in pixels.
    SavePicture(PathBuf, [u32; 2]),
    /// A film of a turn, in pixels and seconds.
    Film(PathBuf, [u32; 2], f64),
}

/// The windows that ask for names.
#[derive(Debug, Default)]
pub(crate) struct Files {
    asked: Option<Asked>,
    /// What was opened before, the newest first.
    pub(crate) recent: Vec<PathBuf>,
    dialog: Option<Receiver<Chosen>>,
}

/// What is asked for.
#[derive(Clone, Debug)]
struct Asked {
    what: What,
    name: String,
    size: [u32; 2],
    seconds: f64,
    /// Whether the field for the name is still to be chosen, as when the window has just opened.
    is_new: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum What {
    Open(OpenAs),
    Scene,
    Picture,
    Film,
}

impl What {
    fn title(self) -> &'static str {
        match self {
            Self::Open(OpenAs::Document) => "Open a volume or a scene",
            Self::Open(OpenAs::Layer) => "Add a layer",
            Self::Scene => "Save the scene",
            Self::Picture => "Save a picture",
            Self::Film => "Film a turn",
        }
    }

    fn usual_name(self) -> &'static str {
        match self {
            Self::Open(_) => "",
            Self::Scene => "scene.toml",
            Self::Picture => "picture.png",
            Self::Film => "turn.webp",
        }
    }
}

impl Files {
    /// Remembers what was opened.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn opened(&mut self, path: &Path) {
        self.recent = crate::recent::add(&self.recent, path);
    }

    /// A page remembers nothing.
    #[cfg(target_arch = "wasm32")]
    #[expect(clippy::unused_self, reason = "a desktop remembers")]
    pub(crate) fn opened(&mut self, _: &Path) {}

    /// Asks what to open.
    pub(crate) fn ask_open(&mut self) {
        self.ask(What::Open(OpenAs::Document), [1, 1]);
    }

    /// Asks what to add to what is open.
    pub(crate) fn ask_layer(&mut self) {
        self.ask(What::Open(OpenAs::Layer), [1, 1]);
    }

    /// Asks where to save the scene.
    pub(crate) fn ask_scene(&mut self) {
        self.ask(What::Scene, [1, 1]);
    }

    /// Asks where to save a picture, and how large.
    pub(crate) fn ask_picture(&mut self, size: [u32; 2]) {
        self.ask(What::Picture, size);
    }

    /// Asks where to put a film, and how large and long.
    pub(crate) fn ask_film(&mut self, size: [u32; 2]) {
        self.ask(What::Film, size);
    }

    /// Whether a name is asked for.
    pub(crate) fn is_asking(&self) -> bool {
        self.asked.is_some()
    }

    fn ask(&mut self, what: What, size: [u32; 2]) {
        let name = what.usual_name().to_owned();
        self.asked = Some(Asked { what, name, size, seconds: 6.0, is_new: true });
    }

    /// The window that asks, if one does. What was decided on.
    pub(crate) fn show(&mut self, context: &Context) -> Option<Wish> {
        if let Some(chosen) = self.dialog.as_ref().and_then(|dialog| dialog.try_recv().ok()) {
            self.dialog = None;
            match (chosen, &mut self.asked) {
                #[cfg(not(target_arch = "wasm32"))]
                (Chosen::Path(path), Some(asked)) => asked.name = path.display().to_string(),
                #[cfg(target_arch = "wasm32")]
                (Chosen::Bytes(name, bytes), Some(Asked { what: What::Open(opens), .. })) => {
                    let opens = *opens;
                    self.asked = None;
                    return Some(Wish::OpenBytes(opens, name, bytes));
                }
                _ => {}
            }
        }
        let asked = self.asked.as_mut()?;
        let (mut is_open, mut wish, mut browses) = (true, None, false);
        let window = Window::new(asked.what.title()).open(&mut is_open).collapsible(false);
        // Below the bar, and where the thing that is shown is still seen.
        let window = window.anchor(Align2::CENTER_TOP, [0.0, 60.0]);
        window.show(context, |ui| {
            let (is_decided, is_browsing) = name(ui, asked);
            browses = is_browsing;
            details(ui, asked);
            if let What::Open(opens) = asked.what {
                for path in &self.recent {
                    if ui.link(path.display().to_string()).clicked() {
                        wish = Some(Wish::Open(opens, path.clone()));
                    }
                }
            }
            let verb = match asked.what {
                What::Open(OpenAs::Document) => "open",
                What::Open(OpenAs::Layer) => "add",
                What::Scene | What::Picture | What::Film => "save",
            };
            let is_named = !asked.name.trim().is_empty();
            if (ui.button(verb).clicked() || is_decided) && is_named {
                wish = Some(asked.wish());
            }
        });
        if browses {
            self.dialog = Some(browse(asked.what, context.clone()));
        }
        let is_escaped = context.input(|input| input.key_pressed(Key::Escape));
        if wish.is_some() || !is_open || is_escaped {
            self.asked = None;
        }
        wish
    }
}

impl Asked {
    fn wish(&self) -> Wish {
        let path = PathBuf::from(self.name.trim());
        match self.what {
            What::Open(opens) => Wish::Open(opens, path),
            What::Scene => Wish::SaveScene(path),
            What::Picture => Wish::SavePicture(path, self.size),
            What::Film => Wish::Film(path, self.size, self.seconds),
        }
    }
}

/// The field for the name. Whether it is decided on, and whether a dialog is wanted.
fn name(ui: &mut Ui, asked: &mut Asked) -> (bool, bool) {
    ui.horizontal(|ui| {
        let field = eframe::egui::TextEdit::singleline(&mut asked.name).desired_width(340.0);
        let response =
            ui.add(field.hint_text(if cfg!(target_arch = "wasm32") { "address" } else { "path" }));
        if asked.is_new {
            response.request_focus();
            asked.is_new = false;
        }
        let is_entered = response.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
        let has_dialog = matches!(asked.what, What::Open(_)) || cfg!(not(target_arch = "wasm32"));
        (is_entered, has_dialog && ui.button("browse…").clicked())
    })
    .inner
}

/// Sizes and times.
fn details(ui: &mut Ui, asked: &mut Asked) {
    if !matches!(asked.what, What::Picture | What::Film) {
        return;
    }
    ui.horizontal(|ui| {
        ui.add(DragValue::new(&mut asked.size[0]).range(1..=16384));
        ui.label("x");
        ui.add(DragValue::new(&mut asked.size[1]).range(1..=16384));
        ui.label("pixels");
        if asked.what == What::Film {
            ui.add(DragValue::new(&mut asked.seconds).range(0.5..=600.0).speed(0.1));
            ui.label("seconds");
        }
    });
}

/// What was chosen in a dialog of the system's.
#[derive(Clone, Debug)]
enum Chosen {
    Nothing,
    #[cfg(not(target_arch = "wasm32"))]
    Path(PathBuf),
    #[cfg(target_arch = "wasm32")]
    Bytes(String, Vec<u8>),
}

/// The system's own dialog, on a thread of its own where that may be.
#[cfg(not(target_arch = "wasm32"))]
fn browse(what: What, context: Context) -> Receiver<Chosen> {
    let (sender, receiver) = mpsc::channel();
    let ask = move || {
        let dialog = rfd::FileDialog::new().set_title(what.title());
        let chosen = match what {
            What::Open(_) => dialog.pick_file(),
            _ => dialog.set_file_name(what.usual_name()).save_file(),
        };
        drop(sender.send(chosen.map_or(Chosen::Nothing, Chosen::Path)));
        context.request_repaint();
    };
    if cfg!(target_os = "macos") {
        // There, dialogs belong to the thread of the window.
        ask();
    } else {
        std::thread::spawn(ask);
    }
    receiver
}

/// The browser's own dialog. What is saved goes where the browser has its downloads.
#[cfg(target_arch = "wasm32")]
fn browse(_: What, context: Context) -> Receiver<Chosen> {
    let (sender, receiver) = mpsc::channel();
    wasm_bindgen_futures::spawn_local(async move {
        let chosen = match rfd::AsyncFileDialog::new().pick_file().await {
            Some(file) => Chosen::Bytes(file.file_name(), file.read().await),
            None => Chosen::Nothing,
        };
        drop(sender.send(chosen));
        context.request_repaint();
    });
    receiver
}
