//! What is open, all that can be undone of it, and what is known of its volumes.

use super::History;
use slabsplat::io::{IoError, SceneFile, scene_text};
use slabsplat::{
    Aim, CameraError, Framing, Labels, Layer, OpenError, OpenScene, RenderSettings,
    ValueCounts, Viewpoint,
};
use std::path::Path;

/// All that can be undone.
#[derive(Clone, Debug)]
pub struct State {
    /// What is shown, and where it comes from.
    pub opened: OpenScene,
    /// How the panes beside the first one are made; the first one is made as the scene says.
    pub compared: Vec<RenderSettings>,
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
    /// The labels that voxels of each layer have, rising.
    pub labels: Vec<Vec<i64>>,
    /// How many voxels of each layer's volume have which values, where any is finite.
    pub counts: Vec<Option<ValueCounts>>,
    framing: Framing,
}

/// Bins of a histogram.
const N_BINS: usize = 256;

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
        let layers = &opened.scene.layers;
        let counts = layers.iter().map(|layer| ValueCounts::of(&layer.volume, N_BINS)).collect();
        let framing = opened.framing();
        let of_layer = |layer: &Layer| layer.labels.as_ref().map(Labels::of_voxels);
        let labels = layers.iter().map(|layer| of_layer(layer).unwrap_or_default()).collect();
        let history = History::new(State { opened, compared: Vec::new() });
        Self { name, history, counts, labels, framing, revision: 0 }
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

    /// What is shown is as large as the view. That is nothing to be undone.
    pub fn resize(&mut self, [width, height]: [u32; 2]) {
        let image = self.state().opened.scene.image;
        if [image.width, image.height] == [width, height] {
            return;
        }
        self.revision += 1;
        self.history.amend(|state| {
            let image = &mut state.opened.scene.image;
            (image.width, image.height) = (width, height);
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
        let scene = &self.state().opened.scene;
        let aim = Aim::default().viewpoint(viewpoint).fit(slabsplat::Fit::Visible);
        let camera = self.framing.aimed(&scene.camera, &aim, true, &scene.image)?;
        self.move_camera(|_| camera);
        Ok(())
    }

    /// Looks again at what is visible, which another transfer function has changed.
    pub fn reframe(&mut self) {
        self.framing = self.state().opened.framing();
    }

    /// The scene of a pane.
    ///
    /// # Panics
    /// If there is no such pane.
    pub fn pane(&self, pane: usize) -> OpenScene {
        let State { opened, compared } = self.state();
        let mut opened = opened.clone();
        if let Some(before) = pane.checked_sub(1) {
            opened.scene.settings = compared[before].clone();
        }
        opened
    }

    /// How many panes there are.
    pub fn n_panes(&self) -> usize {
        1 + self.state().compared.len()
    }

    /// All of it as the text of a scene file in a folder of that path.
    ///
    /// # Errors
    /// As [`OpenScene::to_file`].
    pub fn scene_text(&self, path: &Path) -> Result<String, IoError> {
        scene_text(&self.state().opened.to_file()?, path)
    }
}
