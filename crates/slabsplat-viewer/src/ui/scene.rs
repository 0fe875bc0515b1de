//! What is not of a layer: lights, background, what is drawn on the picture, how it is made.

use super::{colors, settings};
use crate::state::Document;
use eframe::egui::{DragValue, Ui};
use slabsplat::{Light, LightSource};

/// Method, mode, kernel, slabs and the rest of how frames are made.
pub(crate) fn rendering(ui: &mut Ui, document: &mut Document) {
    let settings = document.state().opened.scene.settings.clone();
    if let Some((kind, edited)) = settings::rows(ui, &settings) {
        document.change(kind, |state| state.opened.scene.settings = edited);
    }
}

/// What shines.
pub(crate) fn lights(ui: &mut Ui, document: &mut Document) {
    let (lights, camera) = {
        let scene = &document.state().opened.scene;
        (scene.lights.clone(), scene.camera)
    };
    let axes = camera.axes();
    let mut edited = lights.clone();
    let mut removed = None;
    for (idx, light) in edited.iter_mut().enumerate() {
        ui.horizontal(|ui| {
            let is_headlight = matches!(light.source, LightSource::Headlight);
            let color = light.color;
            if ui.selectable_label(is_headlight, "with the camera").clicked() && !is_headlight {
                *light = Light::default().color(color);
            }
            if ui.selectable_label(!is_headlight, "from a side").clicked() && is_headlight {
                let from_above = axes.up + 0.7 * axes.right - axes.forward;
                *light = Light::towards(from_above).unwrap_or(*light).color(color);
            }
            if let Some(color) = colors::button(ui, light.color) {
                light.color = color;
            }
            if ui.small_button("remove").clicked() {
                removed = Some(idx);
            }
        });
        if let LightSource::Direction(direction) = light.source {
            ui.horizontal(|ui| {
                ui.weak("from");
                let mut towards = direction.get();
                let mut is_changed = false;
                for part in towards.as_mut() {
                    let drag = DragValue::new(part).speed(0.01).max_decimals(2);
                    is_changed |= ui.add(drag).changed();
                }
                if is_changed && let Ok(moved) = Light::towards(towards) {
                    *light = moved.color(light.color);
                }
            });
        }
    }
    if let Some(idx) = removed {
        edited.remove(idx);
    }
    if edited.len() < Light::MAX_LIGHTS && ui.button("add a light").clicked() {
        edited.push(Light::default());
    }
    if edited != lights {
        document.change("lights", |state| state.opened.scene.lights = edited);
    }
}

/// What is behind it all.
pub(crate) fn background(ui: &mut Ui, document: &mut Document) {
    let scene = &document.state().opened.scene;
    let (mut above, mut below) = (scene.image.background, scene.finish.background_below);
    ui.horizontal(|ui| {
        ui.label("above");
        color(ui, &mut above);
        let mut is_gradient = below.is_some();
        if ui.checkbox(&mut is_gradient, "another below").changed() {
            below = is_gradient.then_some(above);
        }
        if let Some(below) = &mut below {
            color(ui, below);
        }
    });
    if (above, below) != (scene.image.background, scene.finish.background_below) {
        document.change("background", |state| {
            state.opened.scene.image.background = above;
            state.opened.scene.finish.background_below = below;
        });
    }
}

/// A colour that becomes opaque when it is chosen.
fn color(ui: &mut Ui, color: &mut [f32; 4]) {
    let [r, g, b, _] = color.map(f64::from);
    if let Some([r, g, b]) = colors::button(ui, [r, g, b]) {
        *color = [r as f32, g as f32, b as f32, 1.0];
    }
}

/// What is drawn on the picture.
pub(crate) fn annotations(ui: &mut Ui, document: &mut Document) {
    let before = document.state().opened.scene.finish.annotations.clone();
    let mut edited = before.clone();
    ui.checkbox(&mut edited.scale_bar, "scale bar");
    ui.checkbox(&mut edited.color_bar, "colour bar");
    ui.checkbox(&mut edited.orientation_marker, "orientation");
    ui.checkbox(&mut edited.axes, "axes");
    ui.horizontal(|ui| {
        ui.label("title");
        let mut title = edited.title.take().unwrap_or_default();
        ui.text_edit_singleline(&mut title);
        edited.title = Some(title).filter(|title| !title.is_empty());
    });
    if edited != before {
        document.change("annotations", |state| state.opened.scene.finish.annotations = edited);
    }
}
