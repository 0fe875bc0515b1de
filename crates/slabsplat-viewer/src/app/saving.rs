//! What is saved, and what of that cannot be.

use super::Viewer;
use crate::jobs::{self, Volumes};
use crate::ui::Wish;
use slabsplat::{ImageDesc, OpenScene};
use std::path::PathBuf;

impl Viewer {
    /// Does what was decided on in a window that asks for names.
    pub(super) fn grant(&mut self, wish: Wish) {
        match wish {
            #[cfg(target_arch = "wasm32")]
            Wish::OpenBytes(opens, name, bytes) => self.open_bytes(opens, name, bytes),
            Wish::Open(opens, path) => self.open_named(opens, path),
            Wish::SaveScene(path) => self.save_scene(path),
            Wish::SavePicture(path, size) => self.save_picture(path, size),
            Wish::Film(path, size, seconds) => self.film(path, size, seconds),
        }
    }

    /// What the first pane shows, as a picture of a size.
    fn shown_as(&self, [width, height]: [u32; 2]) -> Option<OpenScene> {
        let mut opened = self.document.as_ref()?.pane(0);
        let image = ImageDesc::new(width, height);
        opened.scene.image = image.background(opened.scene.image.background);
        Some(opened)
    }

    fn save_scene(&mut self, path: PathBuf) {
        let Some(document) = &self.document else { return };
        let n_hidden = document.n_hidden();
        if 0 < n_hidden {
            self.say(format!("layers that are hidden are not in a scene file: {n_hidden}"));
        }
        let volumes = if self.is_served { Volumes::Elsewhere } else { Volumes::Here };
        let opened = self.shown_as(self.view);
        self.jobs.extend(opened.map(|opened| jobs::save_scene(opened, volumes, path, &self.wake)));
    }

    fn save_picture(&mut self, path: PathBuf, size: [u32; 2]) {
        let opened = self.shown_as(size);
        self.jobs.extend(opened.map(|opened| jobs::save_picture(opened, path, &self.wake)));
    }

    fn film(&mut self, path: PathBuf, size: [u32; 2], seconds: f64) {
        if self.is_served {
            return self.say(
                "a server's scene is filmed where its volumes are: save the scene, and slabsplat turntable \
                 films it there",
            );
        }
        let opened = self.shown_as(size);
        self.jobs.extend(opened.map(|opened| jobs::film(opened, path, seconds, &self.wake)));
    }
}
