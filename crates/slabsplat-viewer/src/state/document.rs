//! What is open, all that can be undone of it, and what is known of its volumes.

use super::History;
use super::layers::LayerState;
use super::seen::Seen;
use slabsplat::io::{IoError, SceneFile, scene_text};
use slabsplat::{
    Aim, CameraError, Framing, OpenError, OpenScene, RenderSettings, Scene, Viewpoint,
};
use std::path::Path;

/// All that can be undone.
#[derive(Clone, Debug)]
pub struct State {
    /// What is shown, and where it comes from.
    pub opened: OpenScene,
    /// How the panes beside the first one are made; the first one is made as the scene says.
    pub compared: Vec<RenderSettings>,
    /// What of each layer is no part of the scene.
    pub(super) layers: Vec<LayerState>,
}

/// What is open.
#[derive(Clone, Debug)]
pub struct Document {
    /// What it is called, for people.
    pub name: String,
    /// What it is, and was.
    history: History<State>,
    /// Changes whenever what is shown does.
    revision: u64,
    /// What pictures are to hold, once somebody has asked, and what that is of.
    framing: Option<(Framing, Seen)>,
}

impl Document {
    /// Panes that are shown at most.
    pub const MAX_PANES: usize = 4;

    /// Opens what a scene file says, as pictures of that size. It reads volumes and looks at all of their
    /// voxels: not on a thread that draws a window.
    ///
    /// # Errors
    /// As [`OpenScene::open`].
    pub fn open(file: &SceneFile, name: String, size: [u32; 2]) -> Result<Self, OpenError> {
        let mut file = file.clone();
        [file.image.width, file.image.height] = size;
        Ok(Self::of(OpenScene::open(&file)?, name))
    }

    /// What is open already.
    pub fn of(opened: OpenScene, name: String) -> Self {
        let layers = opened.scene.layers.iter().map(LayerState::of).collect();
        let history = History::new(State { opened, compared: Vec::new(), layers });
        Self { name, history, framing: None, revision: 0 }
    }

    /// What is now.
    pub fn state(&self) -> &State {
        self.history.now()
    }

    /// Changes what is now; changes of one kind in a row are one step of undo.
    pub fn change(&mut self, kind: &'static str, change: impl FnOnce(&mut State)) {
        let mut state = self.state().clone();
        change(&mut state);
        self.history.change(kind, state);
        self.revision += 1;
    }

    /// A change that is a step of undo by itself.
    pub fn step(&mut self, kind: &'static str, change: impl FnOnce(&mut State)) {
        self.settle();
        self.change(kind, change);
        self.settle();
    }

    /// Changes what is now without a way back.
    pub(super) fn amend(&mut self, change: impl FnOnce(&mut State)) {
        self.history.amend(change);
    }

    /// What was dragged was let go: what is changed next is another step of undo.
    pub fn settle(&mut self) {
        self.history.settle();
    }

    /// Back to before the last step.
    pub fn undo(&mut self) {
        self.revision += u64::from(self.history.undo());
    }

    /// Once more what was undone last.
    pub fn redo(&mut self) {
        self.revision += u64::from(self.history.redo());
    }

    /// Whether there is anything to be undone, and to be redone.
    pub fn has_steps(&self) -> [bool; 2] {
        self.history.has_steps()
    }

    /// A number that changes whenever what is shown does.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// What is shown is as large as the view, and holds what it held. That is nothing to be undone.
    pub fn resize(&mut self, [width, height]: [u32; 2]) {
        let image = self.state().opened.scene.image;
        if [image.width, image.height] == [width, height] {
            return;
        }
        self.revision += 1;
        let factor =
            share_of_square([width, height]) / share_of_square([image.width, image.height]);
        self.history.amend(|state| {
            let Scene { image, camera, .. } = &mut state.opened.scene;
            (image.width, image.height) = (width, height);
            *camera = camera.magnified(factor).unwrap_or(*camera);
        });
    }

    /// Moves the camera.
    pub fn move_camera(&mut self, change: impl FnOnce(&slabsplat::Camera) -> slabsplat::Camera) {
        let camera = change(&self.state().opened.scene.camera);
        self.change("camera", |state| state.opened.scene.camera = camera);
    }

    /// The camera on a side, or where it is, filled by what is visible.
    ///
    /// # Errors
    /// If numbers do not suffice.
    pub fn aim(&mut self, viewpoint: Option<Viewpoint>) -> Result<(), CameraError> {
        let shown = self.shown();
        let seen = Seen::of(&shown.scene);
        let known = self.framing.take();
        let known = known.filter(|(_, framed)| !seen.is_to_be_looked_at_after(framed));
        let (framing, _) = self.framing.insert(known.unwrap_or_else(|| (shown.framing(), seen)));
        let aim = Aim::default().viewpoint(viewpoint).fit(slabsplat::Fit::Visible);
        let camera = framing.aimed(&shown.scene.camera, &aim, true, &shown.scene.image)?;
        self.move_camera(|_| camera);
        Ok(())
    }

    /// The scene of a pane.
    ///
    /// # Panics
    /// If there is no such pane.
    pub fn pane(&self, pane: usize) -> OpenScene {
        let mut opened = self.shown();
        if let Some(before) = pane.checked_sub(1) {
            opened.scene.settings = self.state().compared[before].clone();
        }
        opened
    }

    /// How many panes there are.
    pub fn n_panes(&self) -> usize {
        1 + self.state().compared.len()
    }

    /// All that is shown as the text of a scene file in a folder of that path.
    ///
    /// # Errors
    /// As [`OpenScene::to_file`].
    pub fn scene_text(&self, path: &Path) -> Result<String, IoError> {
        scene_text(&self.shown().to_file()?, path)
    }
}

/// The share of a view's height that the largest square in it has.
fn share_of_square([width, height]: [u32; 2]) -> f64 {
    f64::from(width.min(height)) / f64::from(height)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::height_at_target;
    use slabsplat::io::VolumeSource;

    fn document() -> Document {
        let source = VolumeSource::Builtin { name: "neuron".to_owned(), size: Some(16) };
        Document::open(&SceneFile::of_volume(source), "neuron".to_owned(), [80, 60]).unwrap()
    }

    #[test]
    fn every_state_is_a_scene_file() {
        let mut document = document();
        document.move_camera(|camera| crate::state::zoomed(camera, [0.1, 0.2].into(), 1.3));
        document.aim(Some(Viewpoint::Left)).unwrap();
        document.change("slab width", |state| state.opened.scene.settings.slab_width = 0.5);
        let text = document.scene_text(Path::new("scene.toml")).unwrap();
        let again = slabsplat::io::parse_scene(&text, "scene.toml").unwrap();
        let again = OpenScene::open(&again).unwrap();
        assert_eq!(again.scene.camera, document.state().opened.scene.camera);
        assert_eq!(again.scene.settings, document.state().opened.scene.settings);
        assert_eq!(again.scene.image, document.state().opened.scene.image);
    }

    #[test]
    fn all_is_undone() {
        let mut document = document();
        let before = document.state().opened.scene.clone();
        let revision = document.revision();
        document.move_camera(|camera| camera.orbited(0.3));
        document.move_camera(|camera| camera.orbited(0.3));
        document.change("panes", |state| {
            state.compared.push(state.opened.scene.settings.clone());
        });
        assert_eq!((document.n_panes(), document.has_steps()), (2, [true, false]));
        document.undo();
        document.undo();
        assert_eq!((document.n_panes(), document.has_steps()), (1, [false, true]));
        assert_eq!(document.state().opened.scene.camera, before.camera);
        assert!(revision < document.revision());
        document.redo();
        assert_ne!(document.state().opened.scene.camera, before.camera);
    }

    #[test]
    fn views_of_other_sizes_hold_what_they_held() {
        let mut document = document();
        let height = |document: &Document| height_at_target(&document.state().opened.scene.camera);
        let before = height(&document);
        document.resize([60, 120]);
        assert!((height(&document) / before - 2.0).abs() < 1e-9);
        document.resize([600, 120]);
        assert!((height(&document) / before - 1.0).abs() < 1e-9);
        assert_eq!(document.has_steps(), [false, false]);
    }

    #[test]
    fn panes_differ_in_their_settings_alone() {
        let mut document = document();
        let other = RenderSettings::default().slab_width(2.0);
        document.change("panes", |state| state.compared.push(other.clone()));
        assert_eq!(document.pane(1).scene.settings, other);
        assert_eq!(document.pane(1).scene.camera, document.pane(0).scene.camera);
        assert_ne!(document.pane(0).scene.settings, other);
    }
}
