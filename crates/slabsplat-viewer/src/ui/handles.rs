//! Handles in the view by which a layer's box and planes are dragged.

use super::pane::Frame;
use crate::state::{Cut, Document, seen_at, slid};
use eframe::egui::{Color32, CursorIcon, Id, Pos2, Rect, Sense, Stroke, Ui, Vec2};
use slabsplat::Grid;
use slabsplat::glam::DVec3;

const RADIUS: f32 = 6.0;

/// Shows the box of a layer with a handle on each face, and one on each plane. Whether one is dragged.
pub(crate) fn show(ui: &Ui, frame: &Frame, document: &mut Document, layer_idx: usize) -> bool {
    let scene = &document.state().opened.scene;
    let (camera, layer) = (scene.camera, &scene.layers[layer_idx]);
    let grid = *layer.volume.grid();
    let mut cut = Cut::of(&layer.region, &grid);
    outline(ui, frame, &camera, &cut, &grid);
    let mut is_dragged = false;
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
            is_dragged = true;
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
        is_dragged = true;
        let distance = plane.distance() + slid(&camera, point, normal, drag);
        *plane = slabsplat::Plane::new(normal, distance).unwrap_or(*plane);
    }
    if is_dragged {
        let region = cut.region(&grid);
        document.change("region", |state| state.opened.scene.layers[layer_idx].region = region);
    }
    is_dragged
}

/// A handle at a point of the world. By how much it is dragged, in parts of the view's height.
fn handle(
    ui: &Ui,
    frame: &Frame,
    camera: &slabsplat::Camera,
    point: DVec3,
    id: (&str, usize, usize),
) -> Option<slabsplat::glam::DVec2> {
    let at = frame.to_screen(seen_at(camera, point)?);
    if !frame.rect.contains(at) {
        return None;
    }
    let rect = Rect::from_center_size(at, Vec2::splat(2.0 * RADIUS + 4.0));
    let response = ui.interact(rect, Id::unique(("handle", id)), Sense::drag());
    let response = response.on_hover_cursor(CursorIcon::Grab);
    let fill = if response.hovered() || response.dragged() {
        Color32::WHITE
    } else {
        Color32::from_rgb(80, 160, 255)
    };
    ui.painter().circle(at, RADIUS, fill, Stroke::new(1.5, Color32::BLACK));
    response.dragged().then(|| frame.drag(response.drag_delta()))
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
