//! What is dragged in the view, by the events of a frame and not by how it ends.
//!
//! egui asks once a frame what is dragged. Where frames take their time, a button may be pressed, the pointer
//! moved and the button released within one: to egui that is no drag, nor is what moves in the frame of the
//! release a part of one. Here both are, so that a drag goes as far as the pointer does, however slow frames
//! are. Where egui says that something else is dragged, that is.

use eframe::egui::{Event, Key, PointerButton, Pos2, Response, Ui, Vec2};

/// A drag, as far as it went in this frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Drag {
    /// Where the pointer was in the frame before, or when the button was pressed.
    pub(crate) from: Pos2,
    /// Where it is, or was when the button was released.
    pub(crate) to: Pos2,
    /// The button.
    pub(crate) button: PointerButton,
    /// Whether it goes on.
    pub(crate) is_held: bool,
}

impl Drag {
    /// By how much the pointer moved.
    pub(crate) fn by(self) -> Vec2 {
        self.to - self.from
    }
}

/// The drag of something that is shown, if it is dragged. It has to be asked in every frame. What senses
/// clicks, too, is dragged once the pointer has moved further than egui lets a click do.
pub(crate) fn drag_of(ui: &Ui, response: &Response) -> Option<Drag> {
    let context = ui.ctx();
    let is_elsewhere = context.dragged_id().is_some_and(|id| id != response.id);
    let (events, gives_up, is_down) = ui.input(|input| {
        let events: Vec<Event> =
            input.events.iter().filter(|event| is_of_pointer(event)).cloned().collect();
        (events, input.key_pressed(Key::Escape), input.pointer.any_down())
    });
    let click_dist = context.options(|options| options.input_options.max_click_dist);
    let slack = if response.sense.senses_click() { click_dist } else { 0.0 };
    let is_here = |at: Pos2| {
        let is_in_front = || context.layer_id_at(at).is_none_or(|id| id == response.layer_id);
        response.is_pointer_button_down_on() || response.interact_rect.contains(at) && is_in_front()
    };
    let before =
        context.data(|data| data.get_temp(response.id)).filter(|_| !is_elsewhere && !gives_up);
    let (press, drag) = followed(before, &events, slack, is_here);
    context.data_mut(|data| match press.filter(|_| is_down && !is_elsewhere) {
        Some(press) => _ = data.insert_temp(response.id, press),
        None => data.remove::<Press>(response.id),
    });
    drag.filter(|_| !is_elsewhere)
}

/// A button that is held.
#[derive(Clone, Copy, Debug)]
struct Press {
    button: PointerButton,
    /// Where it was pressed.
    origin: Pos2,
    /// Where the pointer is.
    at: Pos2,
    /// Up to where a drag was reported.
    reported: Pos2,
    is_drag: bool,
}

impl Press {
    fn move_to(&mut self, at: Pos2, slack: f32) {
        self.at = at;
        self.is_drag |= slack < self.origin.distance(at);
    }

    /// What of a drag was not reported.
    fn drag(self, is_held: bool) -> Option<Drag> {
        let Self { button, at: to, reported: from, .. } = self;
        self.is_drag.then_some(Drag { from, to, button, is_held })
    }
}

fn is_of_pointer(event: &Event) -> bool {
    matches!(event, Event::PointerMoved(_) | Event::PointerButton { .. })
}

/// What is held after some events, and how it was dragged. Of several drags it is the last.
fn followed(
    mut press: Option<Press>,
    events: &[Event],
    slack: f32,
    is_here: impl Fn(Pos2) -> bool,
) -> (Option<Press>, Option<Drag>) {
    let mut ended = None;
    for event in events {
        match (event, &mut press) {
            (&Event::PointerMoved(at), Some(press)) => press.move_to(at, slack),
            (&Event::PointerButton { pos: at, button, pressed: true, .. }, None) if is_here(at) => {
                let is_drag = slack == 0.0;
                press = Some(Press { button, origin: at, at, reported: at, is_drag });
            }
            (&Event::PointerButton { pos, button, pressed: false, .. }, Some(held))
                if button == held.button =>
            {
                held.move_to(pos, slack);
                ended = held.drag(false);
                press = None;
            }
            _ => {}
        }
    }
    let goes_on = press.and_then(|press| press.drag(true));
    let press = press.map(|press| match goes_on {
        Some(drag) => Press { reported: drag.to, ..press },
        None => press,
    });
    (press, goes_on.or(ended))
}

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::egui::{Context, Modifiers, RawInput, Rect, Sense, pos2, vec2};

    const ALL: Rect = Rect::from_min_max(pos2(0.0, 0.0), pos2(400.0, 300.0));
    const KNOB: Rect = Rect::from_min_max(pos2(100.0, 100.0), pos2(116.0, 116.0));

    fn moved(x: f32, y: f32) -> Event {
        Event::PointerMoved(pos2(x, y))
    }

    fn button(pressed: bool, x: f32, y: f32) -> Event {
        let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
        Event::PointerButton { pos: pos2(x, y), button, pressed, modifiers }
    }

    /// What of a field is dragged, and of a knob on it, frame by frame.
    fn dragged(frames: &[&[Event]]) -> Vec<[Option<Drag>; 2]> {
        let context = Context::default();
        let mut drags = Vec::new();
        // They are known before anything is pressed on them.
        for (idx, events) in [&[][..]].iter().chain(frames).enumerate() {
            let input = RawInput {
                screen_rect: Some(ALL),
                time: Some(idx as f64 / 2.0),
                events: events.to_vec(),
                ..RawInput::default()
            };
            let mut output = context.run_ui(input, |ui| {
                let field = ui.interact(ALL, ui.scope_id().with("field"), Sense::click_and_drag());
                let knob = ui.interact(KNOB, ui.scope_id().with("knob"), Sense::drag());
                drags.push([drag_of(ui, &field), drag_of(ui, &knob)]);
            });
            output.textures_delta.clear();
        }
        drags.split_off(1)
    }

    fn by(drags: &[[Option<Drag>; 2]], idx: usize) -> Vec2 {
        drags.iter().filter_map(|drags| drags[idx]).map(Drag::by).fold(Vec2::ZERO, |a, b| a + b)
    }

    /// However events fall into frames, a drag is as long as the pointer's way.
    #[test]
    fn a_drag_is_the_same_in_any_frames() {
        let events = [
            moved(20.0, 30.0),
            button(true, 20.0, 30.0),
            moved(24.0, 30.0),
            moved(60.0, 80.0),
            moved(120.0, 130.0),
            button(false, 120.0, 130.0),
            moved(300.0, 200.0),
        ];
        for cuts in 0..1_u32 << (events.len() - 1) {
            let mut frames = vec![vec![]];
            for (idx, event) in events.iter().enumerate() {
                frames.last_mut().unwrap().push(event.clone());
                if cuts >> idx & 1 != 0 {
                    frames.push(Vec::new());
                }
            }
            let frames: Vec<&[Event]> = frames.iter().map(|frame| &frame[..]).collect();
            let drags = dragged(&frames);
            assert_eq!(by(&drags, 0), vec2(100.0, 100.0), "{frames:?}");
            let ends = drags.iter().filter(|[drag, _]| drag.is_some_and(|drag| !drag.is_held));
            assert_eq!(ends.count(), 1, "{frames:?}");
        }
    }

    #[test]
    fn a_click_is_no_drag() {
        let events = [moved(20.0, 30.0), button(true, 20.0, 30.0), button(false, 22.0, 31.0)];
        assert_eq!(dragged(&[&events]), [[None, None]]);
        assert_eq!(dragged(&[&events[..2], &events[2..]]), [[None, None]; 2]);
    }
}
