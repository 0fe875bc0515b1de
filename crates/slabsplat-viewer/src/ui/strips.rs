//! Strips of colour maps and presets; a click takes one. Presets have small pictures of the volume, once they
//! are drawn.

use super::{colors, transfer};
use crate::state::{Document, THUMBNAIL_SIDE, Thumbnails, stretched};
use eframe::egui::{
    Align2, Color32, FontId, Rect, Response, ScrollArea, Sense, StrokeKind, TextureHandle, Ui,
    pos2, vec2,
};
use slabsplat::io::{COLORMAP_NAMES, PRESET_NAMES, colormap, preset};
use slabsplat::{PiecewiseLinear, TransferFunction};

/// Points of a tile: as wide as a small picture, and as high as that or a strip, with a name below.
const TILE_WIDTH: f32 = THUMBNAIL_SIDE as f32;
const STRIP_HEIGHT: f32 = 18.0;
const NAME_HEIGHT: f32 = 15.0;

/// Shows the strips of a layer. Returns why what was clicked cannot be taken.
pub(crate) fn show(
    ui: &mut Ui,
    document: &mut Document,
    layer_idx: usize,
    thumbnails: &Thumbnails<TextureHandle>,
    is_served: bool,
) -> Option<String> {
    ui.label("colour maps");
    let map = |ui: &mut Ui, idx: usize| {
        let map = colormap(COLORMAP_NAMES[idx]).ok()?;
        Some(tile(ui, COLORMAP_NAMES[idx], &map, STRIP_HEIGHT, None))
    };
    if let Some(idx) = strip_of(ui, "maps", COLORMAP_NAMES.len(), map) {
        take_map(document, layer_idx, COLORMAP_NAMES[idx]);
    }
    ui.label("presets");
    let volume = document.state().opened.scene.layers[layer_idx].volume.clone();
    let height = if is_served { STRIP_HEIGHT } else { TILE_WIDTH };
    let of_preset = |ui: &mut Ui, idx: usize| {
        let colors = preset(PRESET_NAMES[idx]).ok()?.source.transfer.color_points().clone();
        let picture = thumbnails.picture(&volume, idx);
        Some(tile(ui, PRESET_NAMES[idx], &colors, height, picture))
    };
    let taken = strip_of(ui, "presets", PRESET_NAMES.len(), of_preset)?;
    document.show_by(layer_idx, PRESET_NAMES[taken]).err()
}

/// Has a layer the colours of a map, over the values that its opacities go over.
fn take_map(document: &mut Document, layer_idx: usize, name: &str) {
    let transfer = &document.state().opened.scene.layers[layer_idx].transfer;
    let (range, opacity) = (transfer.opacity_points().span(), transfer.opacity_points().clone());
    if let Ok(map) = colormap(name) {
        let edited = TransferFunction::of_curves(opacity, stretched(&map, range));
        transfer::set(document, layer_idx, "colour map", edited);
    }
}

/// Tiles side by side. Which one was clicked.
fn strip_of(
    ui: &mut Ui,
    id: &str,
    n: usize,
    tile: impl Fn(&mut Ui, usize) -> Option<Response>,
) -> Option<usize> {
    let mut clicked = None;
    ScrollArea::horizontal().id_salt(id).show(ui, |ui| {
        ui.horizontal(|ui| {
            for idx in 0..n {
                if tile(ui, idx).is_some_and(|response| response.clicked()) {
                    clicked = Some(idx);
                }
            }
        });
    });
    clicked
}

/// A button that shows a picture, or until there is one colours, above a name.
fn tile(
    ui: &mut Ui,
    name: &str,
    colors: &PiecewiseLinear<3>,
    height: f32,
    picture: Option<&TextureHandle>,
) -> Response {
    let size = vec2(TILE_WIDTH, height + NAME_HEIGHT);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    let top = Rect::from_min_size(rect.min, vec2(TILE_WIDTH, height));
    match picture {
        Some(texture) => {
            let all = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            ui.painter().image(texture.id(), top, all, Color32::WHITE);
        }
        None => {
            let bar = Rect::from_center_size(top.center(), vec2(TILE_WIDTH, STRIP_HEIGHT));
            colors::strip(ui.painter(), bar, colors, colors.span());
        }
    }
    let stroke = ui.style().interact(&response).fg_stroke;
    ui.painter().rect_stroke(top, 2.0, stroke, StrokeKind::Inside);
    let below = pos2(rect.center().x, rect.bottom());
    let painter = ui.painter().with_clip_rect(ui.clip_rect().intersect(rect));
    let (font, color) = (FontId::proportional(9.0), ui.visuals().text_color());
    painter.text(below, Align2::CENTER_BOTTOM, name, font, color);
    response.on_hover_text(name)
}
