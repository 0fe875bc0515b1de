//! Controls of settings, of the rows that core has of them: a new setting is here without a word.

use eframe::egui::{ComboBox, DragValue, Grid, Ui};
use slabsplat::{Field, KERNEL_NAMES, KernelName, Setting, Settings};

/// Controls of all settings of a table. Returns what was changed, with the name of what it was.
pub(crate) fn rows<S: Settings>(ui: &mut Ui, settings: &S) -> Option<(&'static str, S)> {
    let mut changed = None;
    Grid::new(std::any::type_name::<S>()).num_columns(2).show(ui, |ui| {
        for row in S::ROWS {
            ui.label(row.name.replace('_', " ")).on_hover_text(row.help);
            let mut edited = settings.clone();
            if control(ui, row, &mut edited) && edited.check_ranges().is_ok() {
                changed = Some((row.name, edited));
            }
            ui.end_row();
        }
    });
    changed
}

/// The control of a setting, and whether it was changed.
fn control<S: Settings>(ui: &mut Ui, row: &Setting<S>, settings: &mut S) -> bool {
    match &row.field {
        Field::Choice { names, get, set } => {
            let chosen = choice(ui, row.name, names, get(settings));
            chosen.is_some_and(|name| set(settings, name).is_ok())
        }
        Field::Kernel(access) => {
            let kernel = (access.get)(settings);
            let Some(name) = choice(ui, row.name, KERNEL_NAMES, &kernel.0) else { return false };
            (access.set)(settings, KernelName::from(name));
            true
        }
        Field::Number { access, .. } => {
            let mut number = (access.get)(settings);
            let speed = 0.01 * number.abs().max(0.1);
            let drag = DragValue::new(&mut number).speed(speed).max_decimals(4);
            let is_changed = ui.add(drag).on_hover_text(row.help).changed();
            (access.set)(settings, number);
            is_changed
        }
        Field::Count { access, .. } => {
            let mut count = (access.get)(settings);
            let is_changed = ui.add(DragValue::new(&mut count)).on_hover_text(row.help).changed();
            (access.set)(settings, count);
            is_changed
        }
        Field::Switch(access) => {
            let mut is_on = (access.get)(settings);
            let is_changed = ui.checkbox(&mut is_on, "").on_hover_text(row.help).changed();
            (access.set)(settings, is_on);
            is_changed
        }
    }
}

/// One of several names, if another was chosen.
pub(crate) fn choice(
    ui: &mut Ui,
    id: &str,
    names: &[&'static str],
    chosen: &str,
) -> Option<&'static str> {
    let mut other = None;
    ComboBox::from_id_salt(id).selected_text(chosen.to_owned()).show_ui(ui, |ui| {
        for name in names {
            if ui.selectable_label(*name == chosen, *name).clicked() && *name != chosen {
                other = Some(*name);
            }
        }
    });
    other
}
