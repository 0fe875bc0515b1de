//! Colours of the scene as colours of the window.

use eframe::egui::{Color32, Mesh, Painter, Rect, Ui, pos2};
use slabsplat::PiecewiseLinear;

/// A colour on the screen. Ours are display-referred, as the screen's are.
pub(crate) fn shown(color: [f64; 3]) -> Color32 {
    let [r, g, b] = bytes(color);
    Color32::from_rgb(r, g, b)
}

/// A button that shows a colour and lets another be chosen, if it is.
pub(crate) fn button(ui: &mut Ui, color: [f64; 3]) -> Option<[f64; 3]> {
    let mut edited = bytes(color);
    let is_changed = ui.color_edit_button_srgb(&mut edited).changed();
    is_changed.then(|| edited.map(|byte| f64::from(byte) / 255.0))
}

fn bytes(color: [f64; 3]) -> [u8; 3] {
    color.map(|part| (255.0 * part).round().clamp(0.0, 255.0) as u8)
}

/// Colours of values from the left to the right of a rectangle.
pub(crate) fn strip(
    painter: &Painter,
    rect: Rect,
    colors: &PiecewiseLinear<3>,
    [lo, hi]: [f64; 2],
) {
    const N_STEPS: u32 = 64;
    let mut mesh = Mesh::default();
    for step in 0..=N_STEPS {
        let part = f64::from(step) / f64::from(N_STEPS);
        let color = shown(colors.at(lo + (hi - lo) * part));
        let x = rect.left() + rect.width() * part as f32;
        mesh.colored_vertex(pos2(x, rect.top()), color);
        mesh.colored_vertex(pos2(x, rect.bottom()), color);
        if 0 < step {
            let first = 2 * (step - 1);
            mesh.add_triangle(first, first + 1, first + 2);
            mesh.add_triangle(first + 1, first + 2, first + 3);
        }
    }
    painter.add(mesh);
}
