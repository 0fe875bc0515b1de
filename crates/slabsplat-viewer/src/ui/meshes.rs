//! How meshes look. Where they are, and what they are made of, is their files'.

use super::colors;
use crate::state::Document;
use eframe::egui::{DragValue, Ui};
use slabsplat::MeshLayer;
use slabsplat::io::MeshFile;

/// The grey of meshes whose files have no colours.
const GRAY: [f64; 3] = [0.8; 3];

/// A row for each mesh: its colour, and how thick its lines and points are if that is said.
pub(crate) fn show(ui: &mut Ui, document: &mut Document) {
    let opened = &document.state().opened;
    let mut meshes = opened.scene.meshes.clone();
    let names: Vec<String> = opened.sources.meshes.iter().map(name_of).collect();
    let mut is_changed = false;
    for (mesh, name) in meshes.iter_mut().zip(names) {
        ui.horizontal(|ui| {
            is_changed |= look(ui, mesh);
            ui.label(name);
        });
    }
    if is_changed {
        document.change("meshes", |state| state.opened.scene.meshes = meshes);
    }
}

/// The controls of a mesh, and whether one was used.
fn look(ui: &mut Ui, mesh: &mut MeshLayer) -> bool {
    let chosen = colors::button(ui, mesh.color.unwrap_or(GRAY));
    mesh.color = chosen.or(mesh.color);
    let mut is_changed = chosen.is_some();
    let sizes =
        [(&mut mesh.line_width, "how thick lines are"), (&mut mesh.point_size, "of points")];
    for (size, help) in sizes {
        let Some(size) = size else { continue };
        let speed = 0.01 * size.max(1e-6);
        let drag = DragValue::new(size).range(1e-6..=f64::MAX).speed(speed);
        is_changed |= ui.add(drag).on_hover_text(help).changed();
    }
    is_changed
}

fn name_of(file: &MeshFile) -> String {
    let of_file = || file.path.file_name().unwrap_or(file.path.as_os_str()).to_string_lossy();
    file.name.clone().unwrap_or_else(|| of_file().into_owned())
}
