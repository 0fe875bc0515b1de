//! Where slices lie, and in which order: by their positions alone, never by names of files or by how thick
//! a slice is said to be.

use slabsplat_core::glam::{DAffine3, DMat3, DVec3};

use super::super::choices::{Choice, Part, VolumeChoices};
use super::super::formats::Input;
use super::frame::Frame;
use super::line::{Line, Slice};
use super::scan::Series;
use crate::IoError;

/// Slices nearer to each other than this share of a pixel are at one place.
const SAME_PLACE: f64 = 0.01;

/// The slices of a volume, in order.
#[derive(Debug)]
pub(super) struct Stack {
    pub(super) slices: Vec<Slice>,
    /// What is stored: one of each place.
    pub(super) frames: Vec<Frame>,
    /// Index space to RAS+ millimetres.
    pub(super) world_from_index: DAffine3,
    pub(super) choices: VolumeChoices,
}

impl Stack {
    pub(super) fn of(
        input: &Input<'_>,
        series: &Series,
        warnings: &mut Vec<String>,
    ) -> Result<Self, IoError> {
        let first = &series.frames[0];
        let axes = first.axes.unwrap_or_else(|| {
            warnings.push("the files do not say how slices are turned: axial was assumed".into());
            [DVec3::X, DVec3::Y]
        });
        let spacing = first.spacing.unwrap_or_else(|| {
            warnings.push("the files do not say how large pixels are: 1 x 1 was assumed".into());
            [1.0; 2]
        });
        let normal = axes[0].cross(axes[1]).normalize();
        let places = places(&series.frames, normal, SAME_PLACE * spacing[0].min(spacing[1]));
        let has_colors = 1 < series.layout.n_channels;
        let (frames, choices) = one_of_each(input, places, has_colors, warnings)?;
        let line = Line::of(&frames, normal, warnings);
        let slices = line.slices(warnings);
        line.check_planes(&frames, spacing[0].min(spacing[1]), warnings);
        let [x, y] = [axes[0] * spacing[0], axes[1] * spacing[1]];
        let ras_from_lps = DVec3::new(-1.0, -1.0, 1.0);
        let columns = [x, y, line.step(slices.len())].map(|column| column * ras_from_lps);
        let matrix = DMat3::from_cols(columns[0], columns[1], columns[2]);
        let world_from_index = DAffine3::from_mat3_translation(matrix, line.origin * ras_from_lps);
        Ok(Self { slices, frames, world_from_index, choices })
    }
}

/// Frames by where they are, from below to above along the normal; those that do not say it by their numbers.
fn places(frames: &[Frame], normal: DVec3, tolerance: f64) -> Vec<Vec<Frame>> {
    let height = |frame: &Frame| frame.position.map(|position| position.dot(normal));
    let n_positions = frames.iter().filter(|frame| frame.position.is_some()).count();
    let is_still = frames.windows(2).all(|pair| pair[0].position == pair[1].position);
    let is_one_file = frames.iter().all(|frame| frame.file_idx == frames[0].file_idx);
    // A file of many frames that has one position for all says nothing of the others.
    if n_positions == 0 || (is_still && is_one_file) {
        let mut frames = frames.to_vec();
        frames.sort_by_key(|frame| frame.order);
        return frames.into_iter().map(|frame| vec![frame]).collect();
    }
    let mut with_height: Vec<(f64, &Frame)> =
        frames.iter().filter_map(|frame| Some((height(frame)?, frame))).collect();
    with_height.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let mut places: Vec<Vec<Frame>> = Vec::new();
    let mut last = f64::NEG_INFINITY;
    for (height, frame) in with_height {
        if tolerance < height - last {
            places.push(Vec::new());
            last = height;
        }
        if let Some(place) = places.last_mut() {
            place.push(frame.clone());
        }
    }
    for place in &mut places {
        place.sort_by(|a, b| (&a.kind, a.order).cmp(&(&b.kind, b.order)));
    }
    places
}

/// Where several frames are at each place, they are channels by their kind, and times beside that.
fn one_of_each(
    input: &Input<'_>,
    places: Vec<Vec<Frame>>,
    has_colors: bool,
    warnings: &mut Vec<String>,
) -> Result<(Vec<Frame>, VolumeChoices), IoError> {
    let n_each = places[0].len();
    if let Some(other) = places.iter().find(|place| place.len() != n_each) {
        let n = other.len();
        warnings.push(format!(
            "some places have {n_each} slices and others {n}: the first of each was taken"
        ));
        let first = |place: Vec<Frame>| place.into_iter().min_by_key(|frame| frame.order);
        return Ok((places.into_iter().filter_map(first).collect(), VolumeChoices::default()));
    }
    let kinds = |place: &[Frame]| {
        let mut kinds: Vec<String> = place.iter().map(|frame| frame.kind.clone()).collect();
        kinds.dedup();
        kinds
    };
    let names = kinds(&places[0]);
    let are_channels = 1 < names.len()
        && !has_colors
        && n_each.is_multiple_of(names.len())
        && places.iter().all(|place| kinds(place) == names);
    let n_channels = if are_channels { names.len() } else { 1 };
    let n_times = n_each / n_channels;
    let names = if are_channels { names } else { Vec::new() };
    let channels = Choice { n: n_channels, names, ..Choice::default() };
    let choices = VolumeChoices {
        channel: if are_channels { input.choose_of(Part::Channel, channels)? } else { channels },
        time: input.choose(Part::Time, n_times)?,
        ..VolumeChoices::default()
    };
    let idx = choices.channel.chosen * n_times + choices.time.chosen;
    let frames = places.into_iter().map(|mut place| place.swap_remove(idx)).collect();
    Ok((frames, choices))
}
