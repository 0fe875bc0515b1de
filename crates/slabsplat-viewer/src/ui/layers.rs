//! What is shown of each layer: its light, its region, its labels, its isosurfaces.

use super::{colors, settings};
use crate::state::{Cut, Document};
use eframe::egui::{DragValue, Grid, ScrollArea, Slider, Ui};
use slabsplat::glam::DVec3;
use slabsplat::{Isosurface, LabelStyle, Layer, Phong, Plane, Shading};

/// Changes a layer.
fn change(document: &mut Document, layer_idx: usize, kind: &'static str, to: Layer) {
    document.change(kind, |state| state.opened.scene.layers[layer_idx] = to);
}

/// What light does to a layer.
pub(crate) fn shading(ui: &mut Ui, document: &mut Document, layer_idx: usize) {
    let layer = document.state().opened.scene.layers[layer_idx].clone();
    let mut is_lit = matches!(layer.shading, Shading::Phong(_));
    if ui.checkbox(&mut is_lit, "lit").changed() {
        let shading = if is_lit { Shading::Phong(Phong::default()) } else { Shading::None };
        change(document, layer_idx, "lit", layer.clone().shading(shading));
    }
    if let Shading::Phong(phong) = layer.shading
        && let Some((kind, phong)) = settings::rows(ui, &phong)
    {
        change(document, layer_idx, kind, layer.shading(Shading::Phong(phong)));
    }
}

/// The box along the grid's axes to which a layer is cropped, and planes that cut it.
pub(crate) fn region(ui: &mut Ui, document: &mut Document, layer_idx: usize) {
    let layer = document.state().opened.scene.layers[layer_idx].clone();
    let grid = *layer.volume.grid();
    let cut = Cut::of(&layer.region, &grid);
    let mut edited = cut.clone();
    Grid::new("crop").num_columns(3).show(ui, |ui| {
        for (axis, name) in ["i", "j", "k"].into_iter().enumerate() {
            let whole = [-0.5, grid.dims()[axis] as f64 - 0.5];
            let [lo, hi] = edited.ends[axis];
            ui.label(name).on_hover_text("where the box begins and ends, in voxels");
            for (side, range) in [whole[0]..=hi, lo..=whole[1]].into_iter().enumerate() {
                // A slider rounds what it shows, whether it is touched or not.
                let mut end = edited.ends[axis][side];
                if ui.add(Slider::new(&mut end, range).max_decimals(1)).changed() {
                    edited.ends[axis][side] = end;
                }
            }
            ui.end_row();
        }
    });
    planes(ui, &mut edited, document);
    ui.horizontal(|ui| {
        ui.checkbox(&mut edited.is_inverted, "inverted")
            .on_hover_text("cut off what would be left");
        ui.checkbox(&mut edited.is_lit, "lit faces").on_hover_text("light faces as surfaces");
        if ui.button("whole").on_hover_text("cut nothing off").clicked() {
            edited = Cut::of(&slabsplat::Region::default(), &grid);
        }
    });
    if edited != cut {
        change(document, layer_idx, "region", layer.region(edited.region(&grid)));
    }
}

/// Planes beside the box: where they are, and one more across the line of sight.
fn planes(ui: &mut Ui, cut: &mut Cut, document: &Document) {
    let scene = &document.state().opened.scene;
    let mut removed = None;
    for (idx, plane) in cut.planes.iter_mut().enumerate() {
        ui.horizontal(|ui| {
            ui.label("plane");
            let mut normal = plane.normal();
            let mut distance = plane.distance();
            let mut is_changed = false;
            for part in normal.as_mut() {
                is_changed |= ui.add(DragValue::new(part).speed(0.01).max_decimals(2)).changed();
            }
            is_changed |= ui.add(DragValue::new(&mut distance).max_decimals(2)).changed();
            if is_changed && let Ok(moved) = Plane::new(normal, distance) {
                *plane = moved;
            }
            if ui.small_button("turn round").clicked() {
                *plane = plane.reversed();
            }
            if ui.small_button("remove").clicked() {
                removed = Some(idx);
            }
        });
    }
    if let Some(idx) = removed {
        cut.planes.remove(idx);
    }
    let help = "cuts off what is before the middle of the view; drag its handle in the view";
    if ui.button("cut across the view").on_hover_text(help).clicked() {
        let towards_eye: DVec3 = -scene.camera.axes().forward;
        cut.planes.extend(Plane::new(towards_eye, towards_eye.dot(scene.camera.target())).ok());
    }
}

/// Which labels are visible, and how.
pub(crate) fn labels(ui: &mut Ui, document: &mut Document, layer_idx: usize) {
    let layer = document.state().opened.scene.layers[layer_idx].clone();
    let Some(labels) = layer.labels.clone() else { return };
    let mut styles = labels.styles().clone();
    let mut is_changed = false;
    let names = document.labels_of(layer_idx).to_vec();
    ui.horizontal(|ui| {
        for (text, opacity) in [("all", 1.0), ("none", 0.0)] {
            if ui.small_button(text).clicked() {
                for &label in &names {
                    let style = styles.entry(label).or_insert_with(LabelStyle::default);
                    style.opacity = opacity;
                }
                is_changed = true;
            }
        }
    });
    let row_height = ui.spacing().interact_size.y;
    let list = ScrollArea::vertical().max_height(180.0);
    list.show_rows(ui, row_height, names.len(), |ui, rows| {
        for &label in &names[rows] {
            let mut style = labels.style(label).clone();
            ui.horizontal(|ui| {
                let mut is_visible = 0.0 < style.opacity;
                if ui.checkbox(&mut is_visible, label.to_string()).changed() {
                    style.opacity = f64::from(u8::from(is_visible));
                }
                let drag = DragValue::new(&mut style.opacity).speed(0.01).range(0.0..=1.0);
                ui.add(drag).on_hover_text("what opacities are multiplied with");
                if let Some(color) = colors::button(ui, style.color.unwrap_or([1.0; 3])) {
                    style.color = Some(color);
                }
            });
            if style != *labels.style(label) {
                styles.insert(label, style);
                is_changed = true;
            }
        }
    });
    if is_changed && let Ok(labels) = labels.with_styles(styles) {
        change(document, layer_idx, "labels", layer.labels(labels));
    }
}

/// The surfaces that the mode `isosurfaces` shows.
pub(crate) fn isosurfaces(ui: &mut Ui, document: &mut Document, layer_idx: usize) {
    let layer = document.state().opened.scene.layers[layer_idx].clone();
    // Not the volume's summary, which looks at all voxels, in every frame of the window.
    let range = document.counts_of(layer_idx).map_or([0.0, 1.0], |counts| counts.range);
    let mut edited = layer.isosurfaces.clone();
    let mut removed = None;
    for (idx, surface) in edited.iter_mut().enumerate() {
        ui.horizontal(|ui| {
            let (mut value, mut opacity) = (surface.value(), surface.opacity());
            let mut color = surface.color();
            let speed = (range[1] - range[0]) / 400.0;
            ui.add(DragValue::new(&mut value).speed(speed)).on_hover_text("value");
            let drag = DragValue::new(&mut opacity).speed(0.01).range(0.0..=1.0);
            ui.add(drag).on_hover_text("opacity");
            let shown = color.unwrap_or_else(|| layer.transfer.color(value));
            color = colors::button(ui, shown).or(color);
            if let Ok(other) = Isosurface::new(value, opacity, color) {
                *surface = other;
            }
            if ui.small_button("remove").clicked() {
                removed = Some(idx);
            }
        });
    }
    if let Some(idx) = removed {
        edited.remove(idx);
    }
    if ui.button("add a surface").clicked() {
        edited.extend(Isosurface::new(0.5 * (range[0] + range[1]), 1.0, None).ok());
    }
    if edited != layer.isosurfaces {
        change(document, layer_idx, "isosurfaces", layer.isosurfaces(edited));
    }
}
