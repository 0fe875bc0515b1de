//! Which annotations have room in a picture, and which part of it is left for what the scene shows.
//!
//! Each wants so much at the edges of a picture. They are taken in the order of what a picture is worth
//! without them, the least wanting first; what would leave too little of the picture is left out and told of.

use slabsplat_core::Scene;
use slabsplat_core::glam::DVec2;

use crate::axes::axes_insets;
use crate::color_bar::key_width;
use crate::orientation_marker::marker_side;
use crate::scale_bar::scale_bar_height;
use crate::text::text_size;

/// Pixels at the edges of a picture that annotations take.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[expect(clippy::exhaustive_structs, reason = "a picture has four edges")]
pub struct Insets {
    /// At the left.
    pub left: f64,
    /// At the right.
    pub right: f64,
    /// At the top.
    pub top: f64,
    /// At the bottom.
    pub bottom: f64,
}

/// What is drawn of a scene's annotations.
#[derive(Clone, Debug, Default)]
pub(crate) struct Room {
    pub(crate) has_title: bool,
    pub(crate) has_scale_bar: bool,
    pub(crate) has_color_bar: bool,
    pub(crate) has_marker: bool,
    pub(crate) has_axes: bool,
    /// For people: what is left out.
    pub(crate) notes: Vec<String>,
}

/// Height of a title's line, and what is above it, in ems.
const TITLE_EMS: f64 = 2.4;

/// Parts of width and height that are left, at least, for what the scene shows.
const LEAST_LEFT: f64 = 0.4;

/// The part of a picture, in a found view of which the scene is not covered by its annotations: a title, axes
/// and colour bars have it beside them, and with axes so have the scale bar and the orientation marker, which
/// otherwise are in corners where seldom anything is.
pub fn insets(scene: &Scene) -> Insets {
    claims(scene).1
}

impl Room {
    pub(crate) fn of(scene: &Scene) -> Self {
        claims(scene).0
    }
}

impl Insets {
    fn and(self, other: Self) -> Self {
        Self {
            left: self.left + other.left,
            right: self.right + other.right,
            top: self.top + other.top,
            bottom: self.bottom + other.bottom,
        }
    }

    /// Whether enough of a picture is left.
    fn fit(self, size: DVec2) -> bool {
        let left = size - DVec2::new(self.left + self.right, self.top + self.bottom);
        left.cmpge(size * LEAST_LEFT).all()
    }
}

fn claims(scene: &Scene) -> (Room, Insets) {
    let [width, height] = [scene.image.width, scene.image.height];
    let size = DVec2::new(f64::from(width), f64::from(height));
    let em = f64::from(text_size(width, height));
    let wanted = &scene.finish.annotations;
    let mut room = Room::default();
    let mut taken = Insets::default();
    let mut claim = |is_wanted: bool, what: &str, insets: Insets| {
        let has_room = is_wanted && taken.and(insets).fit(size);
        if has_room {
            taken = taken.and(insets);
        } else if is_wanted {
            let note = format!("{what} has no room in a picture of {width} x {height} pixels");
            room.notes.push(note);
        }
        has_room
    };
    let none = Insets::default();
    let has_title =
        claim(wanted.title.is_some(), "the title", Insets { top: TITLE_EMS * em, ..none });
    let bar = Insets { bottom: scale_bar_height(em), ..none };
    let has_scale_bar = claim(wanted.scale_bar, "the scale bar", bar);
    let key = key_width(scene, em).filter(|_| wanted.color_bar);
    let has_color_bar =
        claim(key.is_some(), "the colour bar", Insets { right: key.unwrap_or(0.0), ..none });
    // In a corner it is beside what is seen or below it, whichever a picture has more room for.
    let side = marker_side(em);
    let marker = match width > height {
        true => Insets { left: side, ..none },
        false => Insets {
            bottom: (side - if has_scale_bar { bar.bottom } else { 0.0 }).max(0.0),
            ..none
        },
    };
    let has_marker = claim(wanted.orientation_marker, "the orientation marker", marker);
    let has_axes = claim(wanted.axes, "the box of axes", axes_insets(scene, em));
    if !has_axes {
        // These lie on corners.
        let over_all = |is_drawn: bool, insets: Insets| if is_drawn { insets } else { none };
        let corners = over_all(has_scale_bar, bar).and(over_all(has_marker, marker));
        taken.left -= corners.left;
        taken.bottom -= corners.bottom;
    }
    // What is wanted and is none, the colours of what has no bar, says why when it is drawn.
    let has_color_bar = has_color_bar || wanted.color_bar && key.is_none();
    (
        Room { has_title, has_scale_bar, has_color_bar, has_marker, has_axes, notes: room.notes },
        taken,
    )
}
