//! What is opened and saved: names, sizes, and the system's dialogs.

use eframe::egui::{Context, DragValue, Key, Ui, Window};
use std::path::PathBuf;
use std::sync::mpsc::{self, Receiver};

/// Something that is to be opened or saved.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Wish {
    /// A volume, a scene, a picture that says what it shows.
    Open(PathBuf),
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
    dialog: Option<Receiver<Option<PathBuf>>>,
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
    Open,
    Scene,
    Picture,
    Film,
}

impl What {
    fn title(self) -> &'static str {
        match self {
            Self::Open => "Open a volume or a scene",
            Self::Scene => "Save the scene",
            Self::Picture => "Save a picture",
            Self::Film => "Film a turn",
        }
    }

    fn usual_name(self) -> &'static str {
        match self {
            Self::Open => "",
            Self::Scene => "scene.toml",
            Self::Picture => "picture.png",
            Self::Film => "turn.webp",
        }
    }
}

impl Files {
    /// Remembers what was opened.
    pub(crate) fn opened(&mut self, path: &std::path::Path) {
        self.recent = crate::recent::add(&self.recent, path);
    }

    /// Asks what to open.
    pub(crate) fn ask_open(&mut self) {
        self.ask(What::Open, [1, 1]);
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

    fn ask(&mut self, what: What, size: [u32; 2]) {
        let name = what.usual_name().to_owned();
        self.asked = Some(Asked { what, name, size, seconds: 6.0, is_new: true });
    }

    /// The window that asks, if one does. What was decided on.
    pub(crate) fn show(&mut self, context: &Context) -> Option<Wish> {
        if let Some(chosen) = self.dialog.as_ref().and_then(|dialog| dialog.try_recv().ok()) {
            self.dialog = None;
            if let (Some(asked), Some(path)) = (&mut self.asked, chosen) {
                asked.name = path.display().to_string();
            }
        }
        let asked = self.asked.as_mut()?;
        let (mut is_open, mut wish, mut browses) = (true, None, false);
        let window = Window::new(asked.what.title()).open(&mut is_open).collapsible(false);
        window.show(context, |ui| {
            let (is_decided, is_browsing) = name(ui, asked);
            browses = is_browsing;
            details(ui, asked);
            if asked.what == What::Open {
                for path in &self.recent {
                    if ui.link(path.display().to_string()).clicked() {
                        wish = Some(Wish::Open(path.clone()));
                    }
                }
            }
            let verb = if asked.what == What::Open { "open" } else { "save" };
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
            What::Open => Wish::Open(path),
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
        let response = ui.add(field.hint_text("path"));
        if asked.is_new {
            response.request_focus();
            asked.is_new = false;
        }
        let is_entered = response.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
        (is_entered, ui.button("browse…").clicked())
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

/// The system's own dialog, on a thread of its own where that may be.
fn browse(what: What, context: Context) -> Receiver<Option<PathBuf>> {
    let (sender, receiver) = mpsc::channel();
    let ask = move || {
        let dialog = rfd::FileDialog::new().set_title(what.title());
        let chosen = match what {
            What::Open => dialog.pick_file(),
            _ => dialog.set_file_name(what.usual_name()).save_file(),
        };
        drop(sender.send(chosen));
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
