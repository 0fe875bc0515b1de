//! A pane of the view: the picture that is there, and what mouse, touch and wheel do on it.

use super::drag::{Drag, drag_of};
use crate::frames::{Drawn, WindowTexture};
use crate::state::{self, Document, Picked, Touch, ViewPoint};
use eframe::egui::{
    Align2, Color32, ColorImage, Context, FontId, InputState, Key, MultiTouchInfo, Painter,
    PointerButton, Pos2, Rect, Response, Sense, TextureHandle, TextureId, TextureOptions, Ui, Vec2,
    pos2, vec2,
};
use slabsplat::glam::DVec2;
use slabsplat::{Image, Scene};

/// Where a view is in the window.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    /// The part of the window.
    pub(crate) rect: Rect,
}

impl Frame {
    /// Where a point of the view is on the screen.
    pub(crate) fn to_screen(self, at: ViewPoint) -> Pos2 {
        let offset = vec2(at.x as f32, -at.y as f32) * self.rect.height();
        self.rect.center() + offset
    }

    /// Which point of the view is there on the screen.
    pub(crate) fn to_view(self, at: Pos2) -> ViewPoint {
        self.drag(at - self.rect.center())
    }

    /// By how much a pointer moves, in parts of the view's height.
    pub(crate) fn drag(self, by: Vec2) -> DVec2 {
        let height = f64::from(self.rect.height()).max(1.0);
        DVec2::new(f64::from(by.x), f64::from(-by.y)) / height
    }
}

/// A picture that is shown.
#[derive(Default)]
pub(crate) struct Pane {
    /// The picture as it came.
    pub(crate) image: Option<Image>,
    texture: Option<TextureHandle>,
    /// What is shown instead while it moves, and was not read back.
    in_window: Option<(TextureId, WindowTexture)>,
    /// Why there is no picture of what is shown.
    pub(crate) error: Option<String>,
    overlay: Option<(u64, TextureHandle)>,
}

impl std::fmt::Debug for Pane {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Pane").field("error", &self.error).finish_non_exhaustive()
    }
}

/// What a pointer does in a pane.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Pointed {
    /// Where it is in the view, if it is there.
    pub(crate) at: Option<ViewPoint>,
    /// Where it was clicked.
    pub(crate) clicked: Option<ViewPoint>,
    /// Whether something is dragged.
    pub(crate) is_held: bool,
}

impl Pane {
    /// A picture has come.
    pub(crate) fn set(&mut self, context: &Context, pane: usize, drawn: Drawn) {
        set_texture(context, &mut self.texture, format!("pane {pane}"), &drawn.image);
        self.error = None;
        self.in_window = None;
        self.image = Some(drawn.image);
    }

    /// A picture has come in a texture of the window's, by the name that egui has for it.
    pub(crate) fn set_texture(&mut self, id: TextureId, texture: WindowTexture) {
        self.error = None;
        self.in_window = Some((id, texture));
        self.image = None;
    }

    /// Shows another picture than the one that came, as a difference.
    pub(crate) fn show_instead(&mut self, context: &Context, pane: usize, image: &Image) {
        set_texture(context, &mut self.texture, format!("pane {pane}"), image);
    }

    /// Paints the picture all over a rectangle.
    pub(crate) fn paint(&self, ui: &Ui, rect: Rect) {
        let painter = ui.painter_at(rect);
        let in_window = self.in_window.as_ref().map(|(id, _)| *id);
        if let Some(id) = in_window.or_else(|| self.texture.as_ref().map(TextureHandle::id)) {
            let all = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            painter.image(id, rect, all, Color32::WHITE);
        }
        if let Some(error) = &self.error {
            let font = FontId::proportional(15.0);
            let color = ui.visuals().error_fg_color;
            let galley = painter.layout(error.clone(), font, color, rect.width() * 0.8);
            let place = Align2::CENTER_CENTER.anchor_size(rect.center(), galley.size());
            painter.rect_filled(place.expand(8.0), 4.0, ui.visuals().window_fill);
            painter.galley(place.min, galley, color);
        }
    }

    /// Paints what is drawn on pictures of a scene, which pictures that move do not have.
    pub(crate) fn paint_annotations(
        &mut self,
        ui: &Ui,
        rect: Rect,
        revision: u64,
        scene: &Scene,
        acquisition: slabsplat::Acquisition,
    ) {
        if scene.finish.annotations.is_empty() {
            return;
        }
        if self.overlay.as_ref().is_none_or(|(of, _)| *of != revision) {
            let mut image = Image::filled(scene.image.width, scene.image.height, [0.0; 4]);
            // What has no room is told of with the whole picture.
            drop(slabsplat::annotations::annotate(&mut image, scene, acquisition));
            let mut texture = self.overlay.take().map(|(_, texture)| texture);
            set_texture(ui.ctx(), &mut texture, "annotations".to_owned(), &image);
            self.overlay = texture.map(|texture| (revision, texture));
        }
        if let Some((_, texture)) = &self.overlay {
            let all = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            ui.painter_at(rect).image(texture.id(), rect, all, Color32::WHITE);
        }
    }
}

fn set_texture(
    context: &Context,
    texture: &mut Option<TextureHandle>,
    name: String,
    image: &Image,
) {
    let size = [image.width() as usize, image.height() as usize];
    let pixels = image.pixels().iter().map(|pixel| {
        let [r, g, b, a] = pixel.map(|part| (255.0 * part + 0.5) as u8);
        Color32::from_rgba_premultiplied(r, g, b, a)
    });
    let image = ColorImage::new(size, pixels.collect());
    match texture {
        Some(texture) => texture.set(image, TextureOptions::LINEAR),
        None => *texture = Some(context.load_texture(name, image, TextureOptions::LINEAR)),
    }
}

/// The rectangles of so many panes.
pub(crate) fn rects(all: Rect, n_panes: usize) -> Vec<Rect> {
    const GAP: f32 = 2.0;
    // The rows by which the largest square fits into each.
    let square = |rows: usize| {
        let columns = n_panes.div_ceil(rows);
        (all.width() / columns as f32).min(all.height() / rows as f32)
    };
    let rows = (1..=n_panes).max_by(|&a, &b| square(a).total_cmp(&square(b)).then(b.cmp(&a)));
    let rows = rows.unwrap_or(1);
    let columns = n_panes.div_ceil(rows);
    let size = vec2(
        (all.width() - GAP * (columns - 1) as f32) / columns as f32,
        (all.height() - GAP * (rows - 1) as f32) / rows as f32,
    );
    let of = |idx: usize| {
        let place = vec2((idx % columns) as f32, (idx / columns) as f32);
        Rect::from_min_size(all.min + place * (size + Vec2::splat(GAP)), size)
    };
    (0..n_panes).map(of).collect()
}

/// What pointer, touch and wheel do to the camera. Nothing is dragged if that is taken by what
/// lies on the pane.
pub(crate) fn pointer(
    ui: &Ui,
    frame: &Frame,
    response: &Response,
    document: &mut Document,
    is_taken: bool,
) -> Pointed {
    let at = response.hover_pos().map(|at| frame.to_view(at));
    let (modifiers, wheel, pinch) =
        ui.input(|input| (input.modifiers, input.smooth_scroll_delta().y, input.zoom_delta()));
    let drag = drag_of(ui, response).filter(|_| !is_taken);
    let touch = ui.input(InputState::multi_touch);
    let touch = touch.filter(|touch| frame.rect.contains(touch.center_pos));
    if let Some(touch) = touch {
        document.move_camera(|camera| state::touched(camera, of_fingers(frame, &touch)));
        // What egui calls zoom and scrolling is the same fingers.
        return Pointed { at, clicked: None, is_held: true };
    }
    if let Some(drag) = drag.filter(|drag| drag.by() != Vec2::ZERO) {
        let by = frame.drag(drag.by());
        let pans = modifiers.shift || drag.button != PointerButton::Primary;
        document.move_camera(|camera| match (modifiers.command, pans) {
            (true, _) => state::rolled(camera, roll_of(frame, drag)),
            (_, true) => state::panned(camera, by),
            _ => state::orbited(camera, by),
        });
    }
    // Ctrl turns the wheel into a pinch.
    let factor = f64::from(wheel / 400.0).exp() * f64::from(pinch);
    if let Some(at) = at.filter(|_| factor != 1.0 && response.hovered()) {
        document.move_camera(|camera| state::zoomed(camera, at, factor));
    }
    if drag.is_some_and(|drag| !drag.is_held) {
        document.settle();
    }
    let clicked = at.filter(|_| response.clicked() && drag.is_none());
    Pointed { at, clicked, is_held: drag.is_some_and(|drag| drag.is_held) }
}

/// What fingers did in a frame, as the camera has it.
fn of_fingers(frame: &Frame, touch: &MultiTouchInfo) -> Touch {
    Touch {
        center: frame.to_view(touch.center_pos),
        moved: frame.drag(touch.translation_delta),
        spread: f64::from(touch.zoom_delta),
        // The window counts downwards.
        turned: -f64::from(touch.rotation_delta),
    }
}

/// The angle about the middle by which a pointer was dragged, counter-clockwise.
fn roll_of(frame: &Frame, drag: Drag) -> f64 {
    frame.to_view(drag.from).angle_to(frame.to_view(drag.to))
}

/// What is under a point of the view.
pub(crate) fn under(document: &Document, at: ViewPoint) -> Option<Picked> {
    let shown = document.shown().scene;
    let picked = state::picked(&shown, state::ray(&shown.camera, at))?;
    Some(Picked { layer_idx: document.layer_of_shown(picked.layer_idx), ..picked })
}

/// Senses a pane's pointer.
pub(crate) fn sensed(ui: &mut Ui, rect: Rect, pane: usize) -> Response {
    ui.interact(rect, ui.scope_id().with(("pane", pane)), Sense::click_and_drag())
}

/// By how much + and − magnify in this frame.
pub(crate) fn zoom_of_keys(context: &Context) -> f64 {
    let pressed =
        |keys: [Key; 2]| context.input(|input| keys.iter().any(|key| input.key_pressed(*key)));
    let larger = if pressed([Key::Plus, Key::Equals]) { 1.25 } else { 1.0 };
    if pressed([Key::Minus, Key::Minus]) { larger / 1.25 } else { larger }
}

/// What a pane shows, where there are several.
pub(crate) fn title(painter: &Painter, rect: Rect, text: &str) {
    let at = rect.left_top() + vec2(8.0, 6.0);
    let font = FontId::proportional(13.0);
    painter.text(at + vec2(1.0, 1.0), Align2::LEFT_TOP, text, font.clone(), Color32::BLACK);
    painter.text(at, Align2::LEFT_TOP, text, font, Color32::WHITE);
}

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::egui::{Event, Modifiers, RawInput, TouchDeviceId, TouchId, TouchPhase};
    use slabsplat::io::{SceneFile, VolumeSource};

    #[test]
    fn panes_fill_the_view() {
        let wide = Rect::from_min_size(pos2(0.0, 20.0), vec2(1000.0, 800.0));
        assert_eq!(rects(wide, 1), [wide]);
        for n_panes in 1..=4 {
            for all in [wide, Rect::from_min_size(Pos2::ZERO, vec2(300.0, 1000.0))] {
                let rects = rects(all, n_panes);
                assert_eq!(rects.len(), n_panes);
                assert!(rects.iter().all(|rect| all.expand(0.5).contains_rect(*rect)), "{rects:?}");
                let apart = |a: &Rect, b: &Rect| a == b || !a.intersects(*b);
                assert!(rects.iter().all(|a| rects.iter().all(|b| apart(a, b))));
            }
        }
        assert!((rects(wide, 3)[0].width() - 499.0).abs() < 1.0, "two by two");
        assert!((rects(wide, 2)[0].height() - 800.0).abs() < 1.0, "side by side");
    }

    /// A window on a document, touched by two fingers that go from frame to frame.
    fn touched(document: &mut Document, fingers: &[[Pos2; 2]]) {
        let context = Context::default();
        let all = Rect::from_min_size(Pos2::ZERO, vec2(400.0, 300.0));
        let mut phase = TouchPhase::Start;
        for (frame_idx, positions) in fingers.iter().enumerate() {
            let touch = |idx: usize| Event::Touch {
                device_id: TouchDeviceId(1),
                id: TouchId(idx as u64),
                phase,
                pos: positions[idx],
                force: None,
            };
            // Systems have the pointer go with the first finger.
            let mut events = vec![touch(0), touch(1), Event::PointerMoved(positions[0])];
            if phase == TouchPhase::Start {
                let (pos, button) = (positions[0], PointerButton::Primary);
                let modifiers = Modifiers::NONE;
                events.push(Event::PointerButton { pos, button, pressed: true, modifiers });
            }
            let input = RawInput {
                screen_rect: Some(all),
                time: Some(frame_idx as f64 / 60.0),
                events,
                ..RawInput::default()
            };
            let mut output = context.run_ui(input, |ui| {
                let response = sensed(ui, all, 0);
                let pointed = pointer(ui, &Frame { rect: all }, &response, document, false);
                assert!(pointed.is_held || frame_idx < 2);
            });
            // Nobody shows what is painted.
            output.textures_delta.clear();
            phase = TouchPhase::Move;
        }
    }

    /// All that egui makes of fingers, zoom and scrolling too, is one move and not several.
    #[test]
    fn two_fingers_move_what_they_touch_once() {
        let source = VolumeSource::Builtin { name: "sphere".to_owned(), size: Some(8) };
        let file = SceneFile::of_volume(source);
        let frame = Frame { rect: Rect::from_min_size(Pos2::ZERO, vec2(400.0, 300.0)) };
        let fingers = [
            // They have to be known before they go.
            [[100.0, 100.0], [200.0, 150.0]],
            [[100.0, 100.0], [200.0, 150.0]],
            [[95.0, 100.0], [230.0, 160.0]],
            [[80.0, 120.0], [260.0, 150.0]],
            [[70.0, 140.0], [300.0, 100.0]],
        ];
        let fingers = fingers.map(|pair| pair.map(|[x, y]| pos2(x, y)));
        let mut document = Document::open(&file, String::new(), [400, 300]).unwrap();
        let camera = document.state().opened.scene.camera;
        let axes = camera.axes();
        let in_world = |at: Pos2| {
            let at = frame.to_view(at) * state::height_at_target(&camera);
            camera.target() + axes.right * at.x + axes.up * at.y
        };
        touched(&mut document, &fingers);
        let moved = document.state().opened.scene.camera;
        for (first, last) in fingers[0].into_iter().zip(fingers[4]) {
            let seen = frame.to_screen(state::seen_at(&moved, in_world(first)).unwrap());
            assert!(seen.distance(last) < 0.1, "{last} has it at {seen}");
        }
        document.settle();
        document.undo();
        assert_eq!(document.state().opened.scene.camera, camera, "it is one step");
    }

    /// A drag in a window whose frames show these events each; where it was clicked.
    fn dragged(document: &mut Document, frames: &[&[Event]]) -> Vec<ViewPoint> {
        let context = Context::default();
        let all = Rect::from_min_size(Pos2::ZERO, vec2(400.0, 300.0));
        let mut clicked = Vec::new();
        for (frame_idx, events) in [&[][..]].iter().chain(frames).enumerate() {
            let input = RawInput {
                screen_rect: Some(all),
                time: Some(frame_idx as f64),
                events: events.to_vec(),
                ..RawInput::default()
            };
            let mut output = context.run_ui(input, |ui| {
                let response = sensed(ui, all, 0);
                let pointed = pointer(ui, &Frame { rect: all }, &response, document, false);
                clicked.extend(pointed.clicked);
            });
            output.textures_delta.clear();
        }
        clicked
    }

    /// In a frame that takes longer than press, way and release, which egui takes for a click.
    #[test]
    fn a_drag_within_a_frame_turns_as_any_other() {
        let source = VolumeSource::Builtin { name: "sphere".to_owned(), size: Some(8) };
        let file = SceneFile::of_volume(source);
        let pressed = |pressed: bool, pos: Pos2| {
            let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
            Event::PointerButton { pos, button, pressed, modifiers }
        };
        let (from, to) = (pos2(100.0, 100.0), pos2(220.0, 160.0));
        let all = [pressed(true, from), pressed(false, to)];
        let mut cameras = Vec::new();
        for frames in [&[&all[..]][..], &[&all[..1], &all[1..]]] {
            let mut document = Document::open(&file, String::new(), [400, 300]).unwrap();
            let before = document.state().opened.scene.camera;
            assert_eq!(dragged(&mut document, frames), []);
            let after = document.state().opened.scene.camera;
            assert!(1.0 < after.eye().distance(before.eye()), "{frames:?}");
            cameras.push(after);
            document.undo();
            assert_eq!(document.state().opened.scene.camera, before, "it is one step");
            let click = [pressed(true, from), pressed(false, from)];
            assert_eq!(dragged(&mut document, &[&click]).len(), 1);
        }
        assert_eq!(cameras[0], cameras[1]);
    }

    #[test]
    fn points_of_the_view_are_where_they_are_seen() {
        let frame = Frame { rect: Rect::from_min_size(pos2(10.0, 20.0), vec2(300.0, 200.0)) };
        assert_eq!(frame.to_view(pos2(160.0, 20.0)), DVec2::new(0.0, 0.5));
        assert_eq!(frame.to_screen(DVec2::new(0.25, -0.5)), pos2(210.0, 220.0));
        assert_eq!(frame.drag(vec2(20.0, 20.0)), DVec2::new(0.1, -0.1));
    }
}
