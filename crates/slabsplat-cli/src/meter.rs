//! The popping meter's readings for several methods: measured with a progress bar, printed as a table.

use crate::advice;
use crate::progress::Progress;
use anyhow::Result;
use slabsplat::{Method, PoppingReport, Renderer, Scene, Sweep, measure_popping};
use std::fmt::Write;

/// Measures one method after another over the same turn of the camera.
pub(crate) fn measure(
    renderer: &mut Renderer,
    scene: &Scene,
    methods: &[Method],
    sweep: Sweep,
) -> Result<Vec<PoppingReport>> {
    let progress = Progress::start("measuring", methods.len() * sweep.n_frames());
    let measure_one = |&method| {
        measure_popping(renderer, scene, method, sweep, || progress.step())
            .map_err(|error| advice::of(error, renderer.caps()))
    };
    methods.iter().map(measure_one).collect()
}

/// One line for each method.
pub(crate) fn table(reports: &[PoppingReport]) -> String {
    let mut text =
        "method           pop ratio  jitter  largest step  largest change  median change  between\n"
            .to_owned();
    for report in reports {
        let [ratio, jitter] = [report.pop_ratio, report.jitter]
            .map(|ratio| ratio.map_or("-".to_owned(), |ratio| format!("{ratio:.2}")));
        let [from, to] = report.at_degrees.map(degrees);
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{:<15}  {ratio:>9}  {jitter:>6}  {:>12.0}  {:>14.6}  {:>13.6}  {from} and {to} degrees",
            report.method.name(),
            255.0 * report.largest_step,
            report.largest,
            report.median,
        );
    }
    text
}

/// An angle without the digits that adding up steps leaves behind.
pub(crate) fn degrees(angle: f64) -> f64 {
    let rounded = (angle * 1e9).round() / 1e9;
    // Beyond 2⁵³ nanodegrees there is nothing to round.
    if rounded.is_finite() { rounded } else { angle }
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
        let sweep = Sweep::new(0.0, 2.0);
        let mut reports =
            measure(&mut renderer, &scene, &[Method::EverySample], sweep).expect("it is drawn");
        (reports[0].pop_ratio, reports[0].at_degrees) = (None, [0.1 + 0.2, 45.0]);
        let text = table(&reports);
        let (head, line) = text.split_once('\n').unwrap();
        assert!(line.ends_with("0.3 and 45 degrees\n"), "{line}");
        for word in ["pop ratio", "jitter", "largest step", "largest change", "median change"] {
            let end = head.find(word).unwrap() + word.len();
            assert_ne!(&line[end - 1..end], " ", "{word} ends over a digit: {line}");
            assert_eq!(&line[end..end + 1], " ", "{word} ends with its number: {line}");
        }
    }
}
