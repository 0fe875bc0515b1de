//! Handles in the view by which a layer's box and planes are dragged.

use super::drag::{Drag, drag_of};
use super::pane::Frame;
use crate::state::{Cut, Document, seen_at, slid};
use eframe::egui::{Color32, CursorIcon, Id, Pos2, Rect, Sense, Stroke, Ui, Vec2};
use slabsplat::Grid;
use slabsplat::glam::DVec3;

const RADIUS: f32 = 6.0;

/// Shows the box of a layer with a handle on each face, and one on each plane. How one is dragged, if one is.
pub(crate) fn show(
    ui: &Ui,
    frame: &Frame,
    document: &mut Document,
    layer_idx: usize,
) -> Option<Drag> {
    let scene = &document.state().opened.scene;
    let (camera, layer) = (scene.camera, &scene.layers[layer_idx]);
    let grid = *layer.volume.grid();
    let mut cut = Cut::of(&layer.region, &grid);
    outline(ui, frame, &camera, &cut, &grid);
    let mut dragged = None;
    let to_world = grid.world_from_index();
    for axis in 0..3 {
        let along = to_world.matrix3.col(axis);
        for side in 0..2 {
            let mut at = DVec3::from_array(cut.ends.map(|[lo, hi]| 0.5 * (lo + hi)));
            at[axis] = cut.ends[axis][side];
            let point = to_world.transform_point3(at);
            let Some(drag) = handle(ui, frame, &camera, point, ("face", axis, side)) else {
                continue;
            };
            dragged = Some(drag);
            let drag = frame.drag(drag.by());
            let voxels = slid(&camera, point, along.normalize(), drag) / along.length();
            let whole = [-0.5, grid.dims()[axis] as f64 - 0.5];
            let [lo, hi] = cut.ends[axis];
            let bounds = if side == 0 { [whole[0], hi] } else { [lo, whole[1]] };
            cut.ends[axis][side] = (at[axis] + voxels).clamp(bounds[0], bounds[1]);
        }
    }
    for (idx, plane) in cut.planes.iter_mut().enumerate() {
        let normal = plane.normal();
        let point = camera.target() - normal * plane.before(camera.target());
        let Some(drag) = handle(ui, frame, &camera, point, ("plane", idx, 0)) else { continue };
        dragged = Some(drag);
        let distance = plane.distance() + slid(&camera, point, normal, frame.drag(drag.by()));
        *plane = slabsplat::Plane::new(normal, distance).unwrap_or(*plane);
    }
    if dragged.is_some() {
        let region = cut.region(&grid);
        document.change("region", |state| state.opened.scene.layers[layer_idx].region = region);
    }
    dragged
}

/// A handle at a point of the world, and how it is dragged.
fn handle(
    ui: &Ui,
    frame: &Frame,
    camera: &slabsplat::Camera,
    point: DVec3,
    id: (&str, usize, usize),
) -> Option<Drag> {
    let at = frame.to_screen(seen_at(camera, point)?);
    if !frame.rect.contains(at) {
        return None;
    }
    let rect = Rect::from_center_size(at, Vec2::splat(2.0 * RADIUS + 4.0));
    let response = ui.interact(rect, Id::unique(("handle", id)), Sense::drag());
    let response = response.on_hover_cursor(CursorIcon::Grab);
    let drag = drag_of(ui, &response);
    let fill = if response.hovered() || drag.is_some() {
        Color32::WHITE
    } else {
        Color32::from_rgb(80, 160, 255)
    };
    ui.painter().circle(at, RADIUS, fill, Stroke::new(1.5, Color32::BLACK));
    drag
}

/// The edges of the box.
fn outline(ui: &Ui, frame: &Frame, camera: &slabsplat::Camera, cut: &Cut, grid: &Grid) {
    let corner = |idx: usize| {
        let at = [0, 1, 2].map(|axis| cut.ends[axis][idx >> axis & 1]);
        let point = grid.world_from_index().transform_point3(DVec3::from_array(at));
        seen_at(camera, point).map(|seen| frame.to_screen(seen))
    };
    let corners: [Option<Pos2>; 8] = std::array::from_fn(corner);
    let stroke = Stroke::new(1.0, Color32::from_rgb(80, 160, 255));
    for from in 0..8_usize {
        for axis in 0..3 {
            let to = from | 1 << axis;
            if let (true, Some(a), Some(b)) = (to != from, corners[from], corners[to]) {
                ui.painter().line_segment([a, b], stroke);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ui::{pointer, sensed};
    use eframe::egui::{Context, Event, Modifiers, PointerButton, RawInput, vec2};
    use slabsplat::io::{SceneFile, VolumeSource};

    /// Within one frame, too, what is pressed is dragged, and not what lies behind it.
    #[test]
    fn a_handle_is_dragged_and_the_camera_is_not() {
        let source = VolumeSource::Builtin { name: "sphere".to_owned(), size: Some(8) };
        let file = SceneFile::of_volume(source);
        let mut document = Document::open(&file, String::new(), [400, 300]).unwrap();
        let frame = Frame { rect: Rect::from_min_size(Pos2::ZERO, vec2(400.0, 300.0)) };
        let scene = document.state().opened.scene.clone();
        let grid = *scene.layers[0].volume.grid();
        let to_screen = |index: DVec3| {
            let point = grid.world_from_index().transform_point3(index);
            frame.to_screen(seen_at(&scene.camera, point).unwrap())
        };
        // That of the face where x is largest.
        let from = to_screen(DVec3::new(7.5, 3.5, 3.5));
        let to = to_screen(DVec3::new(5.5, 3.5, 3.5));
        let pressed = |pressed: bool, pos: Pos2| {
            let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
            Event::PointerButton { pos, button, pressed, modifiers }
        };
        let context = Context::default();
        for events in [vec![], vec![pressed(true, from), pressed(false, to)]] {
            let input = RawInput { screen_rect: Some(frame.rect), events, ..RawInput::default() };
            let mut output = context.run_ui(input, |ui| {
                let response = sensed(ui, frame.rect, 0);
                let handle = show(ui, &frame, &mut document, 0);
                pointer(ui, &frame, &response, &mut document, handle.is_some());
            });
            output.textures_delta.clear();
        }
        let after = &document.state().opened.scene;
        assert_eq!(after.camera, scene.camera);
        let [lo, hi] = Cut::of(&after.layers[0].region, &grid).ends[0];
        assert!(lo == -0.5 && (hi - 5.5).abs() < 0.01, "{lo} to {hi}");
    }
}
