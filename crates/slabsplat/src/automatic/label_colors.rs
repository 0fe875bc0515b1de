//! Colours that tell labels apart.

use super::look::Curves;

/// Turns of the colour circle from a label to the next: by the golden ratio no two of the first few come near
/// each other, however many there are.
const HUE_STEP: f64 = 0.618_033_988_749_895;

/// The first label's hue, in turns from red: a calm blue, which is all that is seen of a mask.
const FIRST_HUE: f64 = 0.58;

/// Saturation and value, alternately, so that neighbours on the circle differ in more than the hue.
const TONES: [[f64; 2]; 3] = [[0.55, 0.95], [0.75, 0.85], [0.40, 1.0]];

/// Of what belongs to something.
const OPACITY: f64 = 0.9;

/// Each of `labels`, which rise, in its own colour; what has none, 0 or else the least, invisible.
pub(super) fn curves(labels: &[f64]) -> Curves {
    let nothing = if labels.contains(&0.0) { 0.0 } else { labels.first().copied().unwrap_or(0.0) };
    let (mut opacity, mut color) = (Vec::new(), Vec::new());
    let mut n_named = 0;
    for (idx, &label) in labels.iter().enumerate() {
        let is_named = label != nothing;
        let look = ([if is_named { OPACITY } else { 0.0 }], tone(n_named));
        n_named += usize::from(is_named);
        let half = |other: Option<&f64>| other.map(|other| label.midpoint(*other));
        let start = half(idx.checked_sub(1).and_then(|before| labels.get(before)));
        let end = half(labels.get(idx + 1));
        for at in [start.unwrap_or(label), end.unwrap_or(label)] {
            opacity.push((at, look.0));
            color.push((at, look.1));
        }
    }
    let what = match n_named {
        1 => "one, in a colour of its own".to_owned(),
        n => format!("{n} of them, each in its own colour"),
    };
    Curves { opacity, color, gradient_opacity: None, what }
}

/// The colour of the label with that number.
fn tone(idx: usize) -> [f64; 3] {
    let hue = (FIRST_HUE + HUE_STEP * idx as f64).fract();
    let [saturation, value] = TONES[idx % TONES.len()];
    // The distance of a channel's hue, in sixths of the circle.
    [0.0, 2.0, 4.0].map(|own: f64| {
        let sixths = (6.0 * hue - own).rem_euclid(6.0);
        let away = sixths.min(6.0 - sixths);
        value * (1.0 - saturation * (away - 1.0).clamp(0.0, 1.0))
    })
}
