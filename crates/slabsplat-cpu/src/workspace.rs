//! What a thread works with, kept from tile to tile and from frame to frame.

use crate::by_sheet::BySheet;
use crate::sheet::Sheet;
use std::sync::Mutex;

/// What a thread needs for a tile.
#[derive(Debug, Default)]
pub(crate) struct Workspace {
    /// Voxels of a tile.
    pub(crate) voxels: BySheet,
    /// Empty between tiles.
    pub(crate) sheet: Sheet,
}

impl Workspace {
    fn resident_bytes(&self) -> usize {
        self.voxels.resident_bytes()
    }
}

/// One for every thread, so that no lock is ever waited for.
#[derive(Debug, Default)]
pub(crate) struct Workspaces(pub(crate) Vec<Mutex<Workspace>>);

impl Workspaces {
    pub(crate) fn resident_bytes(&self) -> usize {
        let bytes = |workspace: &Mutex<Workspace>| {
            workspace.lock().map_or(0, |workspace| Workspace::resident_bytes(&workspace))
        };
        self.0.iter().map(bytes).sum()
    }
}
