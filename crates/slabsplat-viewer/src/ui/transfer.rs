//! The editor of a transfer function: opacities over a histogram, colours below.

use super::colors::{self, shown};
use super::drag::{Drag, drag_of};
use crate::state::{Curve, Document, span, with_result};
use eframe::egui::{
    Align2, Color32, DragValue, FontId, Painter, Pos2, Rect, Response, Sense, Stroke, Ui, pos2,
    vec2,
};
use slabsplat::{TransferFunction, ValueCounts};

const PLOT_HEIGHT: f32 = 130.0;
const STRIP_HEIGHT: f32 = 18.0;
/// Of the values below the strip: points lie all over the plot.
const ENDS_HEIGHT: f32 = 13.0;
const POINT_RADIUS: f32 = 4.5;
/// How near to a point the pointer takes hold of it.
const REACH: f32 = 9.0;

/// What of the editor is no part of the scene.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Editor {
    /// The point whose numbers are shown.
    selected: Option<Selected>,
    /// What is dragged, if anything is: perhaps no point.
    held: Option<Option<Selected>>,
    /// The values that the plot goes over, if not all.
    shown: Option<[f64; 2]>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Selected {
    Opacity(usize),
    Color(usize),
}

/// The part of the window that is the plot, and the values that it goes over.
#[derive(Clone, Copy)]
struct Plot {
    rect: Rect,
    strip: Rect,
    values: [f64; 2],
}

impl Plot {
    /// Of all that is shown.
    const HEIGHT: f32 = PLOT_HEIGHT + STRIP_HEIGHT + ENDS_HEIGHT + 2.0;

    fn within(all: Rect, values: [f64; 2]) -> Self {
        let mut all = all.shrink2(vec2(6.0, 2.0));
        all.max.y -= ENDS_HEIGHT;
        Self {
            rect: Rect::from_min_size(all.min, vec2(all.width(), PLOT_HEIGHT - 4.0)),
            strip: Rect::from_min_max(pos2(all.left(), all.bottom() - STRIP_HEIGHT), all.max),
            values,
        }
    }

    fn x(&self, value: f64) -> f32 {
        let [lo, hi] = self.values;
        self.rect.left() + (((value - lo) / (hi - lo)) as f32) * self.rect.width()
    }

    fn at(&self, value: f64, opacity: f64) -> Pos2 {
        pos2(self.x(value), self.rect.bottom() - opacity as f32 * self.rect.height())
    }

    fn value(&self, x: f32) -> f64 {
        let [lo, hi] = self.values;
        lo + (hi - lo) * f64::from((x - self.rect.left()) / self.rect.width())
    }

    fn opacity(&self, y: f32) -> f64 {
        f64::from((self.rect.bottom() - y) / self.rect.height()).clamp(0.0, 1.0)
    }
}

impl Editor {
    /// Shows the transfer function of a layer and lets it be changed.
    pub(crate) fn show(&mut self, ui: &mut Ui, document: &mut Document, layer_idx: usize) {
        let layer = &document.state().opened.scene.layers[layer_idx];
        let transfer = layer.transfer.clone();
        let counts = document.counts_of(layer_idx).cloned();
        let values = self.shown.unwrap_or_else(|| all_values(&transfer, counts.as_ref()));
        let size = vec2(ui.available_width(), Plot::HEIGHT);
        let (response, painter) = ui.allocate_painter(size, Sense::click_and_drag());
        let plot = Plot::within(response.rect, values);
        self.paint(&painter, &plot, &transfer, counts.as_ref(), ui);
        let edited = match drag_of(ui, &response) {
            Some(drag) => self.dragged(drag, &plot, &transfer),
            None => {
                self.held = None;
                self.clicked(ui, &response, &plot, &transfer)
            }
        };
        if let Some(edited) = edited {
            set(document, layer_idx, "transfer function", edited);
        }
        self.zoom(ui, &response, &plot);
        self.selected_numbers(ui, document, layer_idx);
        if document.state().opened.scene.layers[layer_idx].colors.is_some() {
            let help = "the opacities count, and the colours do not";
            ui.weak("voxels have colours of their own").on_hover_text(help);
        }
    }

    fn paint(
        &self,
        painter: &Painter,
        plot: &Plot,
        transfer: &TransferFunction,
        counts: Option<&ValueCounts>,
        ui: &Ui,
    ) {
        let visuals = ui.visuals();
        painter.rect_filled(plot.rect, 2.0, visuals.extreme_bg_color);
        if let Some(counts) = counts {
            histogram(painter, plot, counts, visuals.weak_text_color().gamma_multiply(0.45));
        }
        let clipped = painter.with_clip_rect(painter.clip_rect().intersect(plot.rect.expand(6.0)));
        let line = Stroke::new(1.5, visuals.strong_text_color());
        let points = transfer.opacity_points().points();
        let mut outline: Vec<Pos2> = points.iter().map(|&(v, [a])| plot.at(v, a)).collect();
        if let (Some(first), Some(last)) = (outline.first(), outline.last()) {
            let ends = [
                pos2(plot.rect.left().min(first.x), first.y),
                pos2(plot.rect.right().max(last.x), last.y),
            ];
            outline.insert(0, ends[0]);
            outline.push(ends[1]);
        }
        clipped.line(outline, line);
        for (idx, &(value, [opacity])) in points.iter().enumerate() {
            let fill = shown(transfer.color(value));
            let is_selected = self.selected == Some(Selected::Opacity(idx));
            let radius = radius(plot, points.len(), is_selected);
            point(&clipped, plot.at(value, opacity), radius, fill, is_selected, ui);
        }
        colors::strip(painter, plot.strip, transfer.color_points(), plot.values);
        let clipped = painter.with_clip_rect(painter.clip_rect().intersect(plot.strip.expand(6.0)));
        let points = transfer.color_points().points();
        for (idx, &(value, color)) in points.iter().enumerate() {
            let is_selected = self.selected == Some(Selected::Color(idx));
            let radius = radius(plot, points.len(), is_selected);
            let at = pos2(plot.x(value), plot.strip.center().y);
            point(&clipped, at, radius, shown(color), is_selected, ui);
        }
        ends(painter, plot, visuals.weak_text_color());
    }

    /// What a click does to points; the transfer function that comes of it, if it is another.
    fn clicked(
        &mut self,
        ui: &Ui,
        response: &Response,
        plot: &Plot,
        transfer: &TransferFunction,
    ) -> Option<TransferFunction> {
        let pointer = response.interact_pointer_pos()?;
        if response.clicked() || response.secondary_clicked() {
            let origin = ui.input(|input| input.pointer.press_origin()).unwrap_or(pointer);
            self.selected = nearest(plot, transfer, origin);
        }
        if response.secondary_clicked() {
            return self.remove(transfer);
        }
        if !response.double_clicked() || self.selected.is_some() {
            return None;
        }
        let (opacity, color) = (transfer.opacity_points(), transfer.color_points());
        let value = plot.value(pointer.x);
        if plot.strip.contains(pointer) {
            let (color, idx) = color.with_point(value);
            self.selected = Some(Selected::Color(idx));
            return Some(TransferFunction::of_curves(opacity.clone(), color));
        }
        let (opacity, idx) = opacity.with_point(value);
        self.selected = Some(Selected::Opacity(idx));
        let opacity = with_result(&opacity, idx, [plot.opacity(pointer.y)]);
        Some(TransferFunction::of_curves(opacity, color.clone()))
    }

    /// What a drag does to the point at which it began, if it began at one.
    fn dragged(
        &mut self,
        drag: Drag,
        plot: &Plot,
        transfer: &TransferFunction,
    ) -> Option<TransferFunction> {
        let held = *self.held.get_or_insert_with(|| nearest(plot, transfer, drag.from));
        self.selected = held;
        if !drag.is_held {
            self.held = None;
        }
        let (opacity, color) = (transfer.opacity_points(), transfer.color_points());
        let value = plot.value(drag.to.x);
        Some(match held? {
            Selected::Opacity(idx) => {
                let moved = opacity.point_moved(idx, value);
                let moved = with_result(&moved, idx, [plot.opacity(drag.to.y)]);
                TransferFunction::of_curves(moved, color.clone())
            }
            Selected::Color(idx) => {
                TransferFunction::of_curves(opacity.clone(), color.point_moved(idx, value))
            }
        })
    }

    /// The transfer function without what is selected.
    fn remove(&mut self, transfer: &TransferFunction) -> Option<TransferFunction> {
        let (opacity, color) = (transfer.opacity_points(), transfer.color_points());
        Some(match self.selected.take()? {
            Selected::Opacity(idx) => {
                TransferFunction::of_curves(opacity.without(idx), color.clone())
            }
            Selected::Color(idx) => {
                TransferFunction::of_curves(opacity.clone(), color.without(idx))
            }
        })
    }

    /// The wheel looks closer at the values under the pointer.
    fn zoom(&mut self, ui: &Ui, response: &Response, plot: &Plot) {
        let Some(pointer) = response.hover_pos() else { return };
        let wheel = ui.input(|input| input.smooth_scroll_delta().y);
        if wheel == 0.0 {
            return;
        }
        let (at, shrunk) = (plot.value(pointer.x), f64::from(-wheel / 300.0).exp());
        let [lo, hi] = plot.values.map(|end| at + (end - at) * shrunk);
        if lo.is_finite() && hi.is_finite() && lo < hi {
            self.shown = Some([lo, hi]);
        }
    }

    /// The numbers of the point that is selected.
    fn selected_numbers(&mut self, ui: &mut Ui, document: &mut Document, layer_idx: usize) {
        let transfer = document.state().opened.scene.layers[layer_idx].transfer.clone();
        let (opacity, color) = (transfer.opacity_points(), transfer.color_points());
        let [lo, hi] = span(&transfer);
        let speed = ((hi - lo) / 400.0).max(1e-6);
        let mut edited = None;
        ui.horizontal(|ui| {
            match self.selected {
                Some(Selected::Opacity(idx)) if idx < opacity.points().len() => {
                    let (mut value, [mut alpha]) = opacity.points()[idx];
                    ui.label("value");
                    let is_moved = ui.add(DragValue::new(&mut value).speed(speed)).changed();
                    ui.label("opacity");
                    let drag = DragValue::new(&mut alpha).speed(0.002).range(0.0..=1.0);
                    if ui.add(drag.max_decimals(4)).changed() || is_moved {
                        let moved = with_result(&opacity.point_moved(idx, value), idx, [alpha]);
                        edited = Some(TransferFunction::of_curves(moved, color.clone()));
                    }
                }
                Some(Selected::Color(idx)) if idx < color.points().len() => {
                    let (mut value, rgb) = color.points()[idx];
                    ui.label("value");
                    let mut moved = color.clone();
                    let is_moved = ui.add(DragValue::new(&mut value).speed(speed)).changed();
                    if is_moved {
                        moved = moved.point_moved(idx, value);
                    }
                    let chosen = colors::button(ui, rgb);
                    if let Some(chosen) = chosen {
                        moved = with_result(&moved, idx, chosen);
                    }
                    if is_moved || chosen.is_some() {
                        edited = Some(TransferFunction::of_curves(opacity.clone(), moved));
                    }
                }
                _ => {
                    ui.weak("drag; double click adds, right click removes");
                }
            }
            if self.selected.is_some() && ui.small_button("remove").clicked() {
                edited = self.remove(&transfer);
            }
            if self.shown.is_some() && ui.small_button("all values").clicked() {
                self.shown = None;
            }
        });
        if let Some(edited) = edited {
            set(document, layer_idx, "point of a transfer function", edited);
        }
    }
}

/// Gives a layer another transfer function.
pub(super) fn set(
    document: &mut Document,
    layer_idx: usize,
    kind: &'static str,
    transfer: TransferFunction,
) {
    document.change(kind, |state| {
        state.opened.scene.layers[layer_idx].transfer = transfer;
    });
}

/// All values that there are, and that a transfer function speaks of.
fn all_values(transfer: &TransferFunction, counts: Option<&ValueCounts>) -> [f64; 2] {
    let of_points = span(transfer);
    let [lo, hi] = counts.map_or(of_points, |counts| {
        [counts.range[0].min(of_points[0]), counts.range[1].max(of_points[1])]
    });
    if lo < hi { [lo, hi] } else { [lo - 0.5, lo + 0.5] }
}

/// What the pointer would take hold of.
fn nearest(plot: &Plot, transfer: &TransferFunction, pointer: Pos2) -> Option<Selected> {
    let opacities = transfer.opacity_points().points().iter().enumerate();
    let opacities = opacities
        .map(|(idx, &(value, [opacity]))| (Selected::Opacity(idx), plot.at(value, opacity)));
    let colors = transfer.color_points().points().iter().enumerate();
    let colors = colors.map(|(idx, &(value, _))| {
        (Selected::Color(idx), pos2(plot.x(value), plot.strip.center().y))
    });
    let near = opacities.chain(colors).map(|(what, at)| (what, at.distance(pointer)));
    let near = near.filter(|(_, distance)| *distance < REACH);
    near.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(what, _)| what)
}

/// How large points are: of hundreds, as of labels, circles would cover all else.
fn radius(plot: &Plot, n_points: usize, is_selected: bool) -> f32 {
    let apart = plot.rect.width() / n_points.max(1) as f32;
    if is_selected { POINT_RADIUS } else { POINT_RADIUS.min(0.5 * apart).max(1.0) }
}

fn point(painter: &Painter, at: Pos2, radius: f32, fill: Color32, is_selected: bool, ui: &Ui) {
    let visuals = ui.visuals();
    let ring =
        if is_selected { visuals.selection.stroke.color } else { visuals.strong_text_color() };
    let width = if is_selected { 2.5 } else { 1.2_f32.min(0.3 * radius) };
    painter.circle(at, radius, fill, Stroke::new(width, ring));
}

/// Columns of a histogram, by the logarithm of what they count: a pixel wide each, as high as the highest of
/// the bins that are in it. Bars of bins would leave gaps where their edges fall between pixels.
fn histogram(painter: &Painter, plot: &Plot, counts: &ValueCounts, color: Color32) {
    let most = counts.counts.iter().copied().max().unwrap_or(0);
    let height_of = |n: u64| ((1 + n) as f32).ln() / ((1 + most) as f32).ln();
    let pixel = 1.0 / painter.pixels_per_point();
    let n_columns = (plot.rect.width() / pixel).round() as usize;
    let left = (plot.rect.left() / pixel).round() * pixel;
    for column in 0..n_columns {
        let x = [column, column + 1].map(|edge| left + edge as f32 * pixel);
        let n = most_within(counts, x.map(|x| plot.value(x)));
        if 0 < n {
            let top = plot.rect.bottom() - plot.rect.height() * height_of(n);
            let bar = Rect::from_min_max(pos2(x[0], top), pos2(x[1], plot.rect.bottom()));
            painter.rect_filled(bar, 0.0, color);
        }
    }
}

/// The highest of the bins that have a part of an interval of values; 0 if none has.
fn most_within(counts: &ValueCounts, values: [f64; 2]) -> u64 {
    let [lo, hi] = counts.range;
    let n_bins = counts.counts.len();
    // All of one value are where it is.
    let position = |value: f64| match (lo < hi, value <= lo) {
        (true, _) => (value - lo) / (hi - lo) * n_bins as f64,
        (false, true) => 0.0,
        (false, false) => n_bins as f64,
    };
    let [from, to] = values.map(position);
    let first = from.floor().max(0.0) as usize;
    let end = (to.ceil().max(0.0) as usize).min(n_bins);
    counts.counts.get(first..end).and_then(|bins| bins.iter().copied().max()).unwrap_or(0)
}

/// The values at the ends of the plot, below it.
fn ends(painter: &Painter, plot: &Plot, color: Color32) {
    let font = FontId::proportional(10.0);
    let sides = [
        (Align2::LEFT_TOP, plot.strip.left_bottom()),
        (Align2::RIGHT_TOP, plot.strip.right_bottom()),
    ];
    for ((align, at), value) in sides.into_iter().zip(plot.values) {
        painter.text(at + vec2(0.0, 2.0), align, super::number(value), font.clone(), color);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::egui::{Context, Event, Modifiers, PointerButton, RawInput};
    use slabsplat::io::{SceneFile, VolumeSource};

    fn button(pressed: bool, pos: Pos2) -> Event {
        let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
        Event::PointerButton { pos, button, pressed, modifiers }
    }

    /// The transfer functions after frames of these events each, and the editor's plot.
    fn edited(document: &mut Document, frames: &[&[Event]]) -> (Vec<TransferFunction>, Plot) {
        let (context, mut editor) = (Context::default(), Editor::default());
        let all = Rect::from_min_size(Pos2::ZERO, vec2(400.0, 300.0));
        let (mut transfers, mut plot) = (Vec::new(), None);
        for (idx, events) in [&[][..]].iter().chain(frames).enumerate() {
            let input = RawInput {
                screen_rect: Some(all),
                time: Some(idx as f64),
                events: events.to_vec(),
                ..RawInput::default()
            };
            let mut output = context.run_ui(input, |ui| {
                let size = vec2(ui.available_width(), Plot::HEIGHT);
                let transfer = &document.state().opened.scene.layers[0].transfer;
                let values = all_values(transfer, document.counts_of(0));
                plot = Some(Plot::within(Rect::from_min_size(ui.cursor().min, size), values));
                editor.show(ui, document, 0);
            });
            output.textures_delta.clear();
            transfers.push(document.state().opened.scene.layers[0].transfer.clone());
        }
        (transfers, plot.expect("it was shown"))
    }

    /// A point goes where the pointer does, however much of its way falls into a frame.
    #[test]
    fn points_are_dragged_within_a_frame() {
        let source = VolumeSource::Builtin { name: "sphere".to_owned(), size: Some(8) };
        let file = SceneFile::of_volume(source);
        let open = || Document::open(&file, String::new(), [400, 300]).unwrap();
        let (before, plot) = edited(&mut open(), &[]);
        let (value, [opacity]) = before[0].opacity_points().points()[1];
        let from = plot.at(value, opacity);
        // No further than its neighbours are.
        let to = pos2(from.x + 2.0, plot.rect.center().y);
        let moved = Event::PointerMoved(from.lerp(to, 0.5));
        let all = [button(true, from), moved, button(false, to)];
        for frames in [&[&all[..]][..], &[&all[..1], &all[1..]], &[&all[..2], &all[2..]]] {
            let mut document = open();
            let (transfers, _) = edited(&mut document, frames);
            let after = transfers.last().unwrap();
            let (value, [opacity]) = after.opacity_points().points()[1];
            assert!(plot.at(value, opacity).distance(to) < 0.01, "{frames:?}");
            assert_eq!(after.color_points(), before[0].color_points());
            document.settle();
            document.undo();
            let undone = &document.state().opened.scene.layers[0].transfer;
            assert_eq!(*undone, before[0], "it is one step");
        }
        // Beside all points nothing is dragged.
        let beside = [button(true, plot.rect.left_top()), button(false, to)];
        assert_eq!(edited(&mut open(), &[&beside]).0[1], before[0]);
    }

    #[test]
    fn columns_are_as_high_as_their_highest_bin() {
        let counts = ValueCounts::of_counts([0.0, 8.0], vec![5, 0, 2, 9]);
        for (values, expected) in [
            ([0.0, 0.5], 5),
            ([2.0, 4.0], 0),
            ([3.5, 4.5], 2),
            ([-1.0, 20.0], 9),
            ([-3.0, 0.0], 0),
            ([8.0, 9.0], 0),
            ([7.9, 9.0], 9),
        ] {
            assert_eq!(most_within(&counts, values), expected, "{values:?}");
        }
        let one = ValueCounts::of_counts([3.0, 3.0], vec![7]);
        assert_eq!([[2.5, 3.0], [3.0, 3.5], [3.2, 4.0]].map(|it| most_within(&one, it)), [0, 7, 0]);
    }
}
