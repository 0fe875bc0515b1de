//! What a thread works with, kept from tile to tile and from frame to frame.

use crate::by_sheet::BySheet;
use crate::sheet::Sheet;
use std::sync::Mutex;

/// What a thread needs for a tile.
#[derive(Debug, Default)]
pub(crate) struct Workspace {
    pub(crate) voxels: BySheet,
    /// Empty between tiles.
    pub(crate) sheet: Sheet,
}

/// One for every thread, so that no lock is ever waited for.
#[derive(Debug, Default)]
pub(crate) struct Workspaces(pub(crate) Vec<Mutex<Workspace>>);

impl Workspaces {
    pub(crate) fn resident_bytes(&self) -> usize {
        let bytes = |workspace: &Mutex<Workspace>| {
            workspace.lock().map_or(0, |workspace| workspace.voxels.resident_bytes())
        };
        self.0.iter().map(bytes).sum()
    }
}
