//! The popping meter's readings for several methods: measured with a progress bar, printed as a table.

use crate::advice;
use crate::progress::Progress;
use anyhow::Result;
use slabsplat::{Method, Motion, PoppingReport, Renderer, Scene, Sweep};
use std::fmt::Write;

/// Measures one method after another over the same motion of the camera.
pub(crate) fn measure(
    renderer: &mut Renderer,
    scene: &Scene,
    methods: &[Method],
    sweep: Sweep,
) -> Result<Vec<PoppingReport>> {
    let progress = Progress::start("measuring", methods.len() * sweep.n_frames());
    let measure_one = |&method| advice::popping(renderer, scene, method, sweep, || progress.step());
    methods.iter().map(measure_one).collect()
}

/// One line for each method.
pub(crate) fn table(motion: Motion, reports: &[PoppingReport]) -> String {
    let mut text =
        "method           pop ratio  spike  jitter  largest step  largest change  median change  \
                    between\n"
            .to_owned();
    for report in reports {
        let [ratio, spike, jitter] = [report.pop_ratio, report.spike, report.jitter]
            .map(|ratio| ratio.map_or("-".to_owned(), |ratio| format!("{ratio:.2}")));
        let [from, to] = report.at.map(rounded);
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{:<15}  {ratio:>9}  {spike:>5}  {jitter:>6}  {:>12.0}  {:>14.6}  {:>13.6}  {from} and {to} {}",
            report.method.name(),
            255.0 * report.largest_step,
            report.largest,
            report.median,
            unit(motion),
        );
    }
    text
}

fn unit(motion: Motion) -> &'static str {
    match motion {
        Motion::Zoom => "times",
        _ => "degrees",
    }
}

/// The name of a motion in JSON.
pub(crate) fn name(motion: Motion) -> &'static str {
    match motion {
        Motion::Zoom => "zoom",
        _ => "turn",
    }
}

/// An angle or a factor without the digits that adding up steps leaves behind.
pub(crate) fn rounded(at: f64) -> f64 {
    let rounded = (at * 1e9).round() / 1e9;
    // Beyond 2⁵³ billionths there is nothing to round.
    if rounded.is_finite() { rounded } else { at }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat::{Automatic, ImageDesc, RenderSettings, io};

    #[test]
    fn meter_table_is_aligned() {
        let volume = io::builtin_volume("cube", Some(4)).unwrap();
        let scene = Automatic::new(volume).scene(ImageDesc::new(8, 8), RenderSettings::default());
        let mut renderer = Renderer::open("cpu", |_| ()).unwrap();
        let sweep = Sweep::turn(0.0, 2.0);
        let mut reports =
            measure(&mut renderer, &scene, &[Method::EverySample], sweep).expect("it is drawn");
        (reports[0].pop_ratio, reports[0].at) = (None, [0.1 + 0.2, 45.0]);
        let text = table(sweep.motion, &reports);
        let (head, line) = text.split_once('\n').unwrap();
        assert!(line.ends_with("0.3 and 45 degrees\n"), "{line}");
        for word in
            ["pop ratio", "spike", "jitter", "largest step", "largest change", "median change"]
        {
            let end = head.find(word).unwrap() + word.len();
            assert_ne!(&line[end - 1..end], " ", "{word} ends over a digit: {line}");
            assert_eq!(&line[end..end + 1], " ", "{word} ends with its number: {line}");
        }
    }
}
