//! Presets that are taken, and what has to be known of them: that is said for as long as a layer is shown so,
//! be it that undo takes the preset back or that another takes its place.

use super::Document;
use slabsplat::io::preset;

/// Where a note is: a layer, and which of its notes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoteIdx {
    layer_idx: usize,
    note_idx: usize,
}

impl Document {
    /// Shows a layer by a preset of that name: a step of undo.
    ///
    /// # Errors
    /// If there is no such preset, or it cannot be fitted to the layer's volume, in a sentence.
    pub fn show_by(&mut self, layer_idx: usize, name: &str) -> Result<(), String> {
        let source = preset(name).map_err(|error| error.to_string())?.source;
        let mut opened = self.state().opened.clone();
        let shown = opened.show_by(layer_idx, source);
        let notes = shown.map_err(|error| error.to_string())?;
        self.step("preset", |state| {
            state.opened = opened;
            state.layers[layer_idx].notes = notes;
        });
        Ok(())
    }

    /// What has to be known of how layers are shown, a line each.
    pub fn notes(&self) -> impl Iterator<Item = (NoteIdx, &str)> {
        self.state().layers.iter().enumerate().flat_map(|(layer_idx, layer)| {
            let notes = layer.notes.iter().enumerate();
            notes.map(move |(note_idx, note)| (NoteIdx { layer_idx, note_idx }, note.as_str()))
        })
    }

    /// A note was read. That is nothing to be undone.
    pub fn close_note(&mut self, NoteIdx { layer_idx, note_idx }: NoteIdx) {
        self.amend(|state| drop(state.layers[layer_idx].notes.remove(note_idx)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat::io::{SceneFile, VolumeSource};

    fn document(name: &str) -> Document {
        let source = VolumeSource::Builtin { name: name.to_owned(), size: Some(12) };
        Document::open(&SceneFile::of_volume(source), name.to_owned(), [40, 30]).unwrap()
    }

    fn notes(document: &Document) -> Vec<&str> {
        document.notes().map(|(_, note)| note).collect()
    }

    /// "ct-bone is for Hounsfield units" stayed after it was undone.
    #[test]
    fn what_is_said_of_a_preset_goes_and_comes_with_it() {
        let mut document = document("sphere");
        document.show_by(0, "ct-bone").unwrap();
        assert!(notes(&document)[0].contains("Hounsfield"), "{:?}", notes(&document));
        document.undo();
        assert_eq!(notes(&document), [""; 0]);
        document.redo();
        assert_eq!(notes(&document).len(), 1);
        document.move_camera(|camera| camera.orbited(0.3));
        assert_eq!(notes(&document).len(), 1, "it is shown so from all sides");
        document.show_by(0, "xray").unwrap();
        assert_eq!(notes(&document), [""; 0], "another preset took its place");
        document.undo();
        let (idx, _) = document.notes().next().unwrap();
        document.close_note(idx);
        assert_eq!((notes(&document).len(), document.has_steps()), (0, [true, true]));
    }

    #[test]
    fn what_is_said_of_a_layer_goes_with_it() {
        let mut document = document("sphere");
        document.add(&self::document("cube"));
        document.show_by(1, "ct-bone").unwrap();
        document.remove_layer(0);
        assert_eq!(notes(&document).len(), 1);
        document.undo();
        document.remove_layer(1);
        assert_eq!(notes(&document), [""; 0]);
    }

    #[test]
    fn a_preset_that_cannot_be_is_no_step() {
        let mut document = document("sphere");
        assert!(document.show_by(0, "no-such").unwrap_err().contains("no-such"));
        assert_eq!(document.has_steps(), [false, false]);
    }
}
