//! What a file says of each of its frames, a frame a slice: the whole file of one image, or the functional
//! groups of one of many (PS3.3 §C.7.6.16).

use std::path::Path;

use slabsplat_core::glam::DVec3;

use super::dataset::Dataset;
use super::header::Header;
use super::syntax::Packing;
use super::tags::{self, Tag};
use crate::IoError;

/// Frames of one file; a hundred times as many as scanners write.
const MAX_FRAMES: usize = 1 << 20;

/// As many frames are believed before their pixels are looked for: a file that was cut off then says where.
const MAX_UNBACKED_FRAMES: u64 = 1024;

/// How the pixels of a frame are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Layout {
    pub(super) rows: usize,
    pub(super) columns: usize,
    /// Values of a pixel.
    pub(super) n_channels: usize,
    pub(super) colors: Colors,
    /// Whether each channel is an image of its own.
    pub(super) is_planar: bool,
    pub(super) bits_allocated: u32,
    pub(super) bits_stored: u32,
    pub(super) high_bit: u32,
    pub(super) is_signed: bool,
    pub(super) is_float: bool,
    /// Whether small values are meant to be bright.
    pub(super) is_inverse: bool,
}

/// What the values of a pixel are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Colors {
    Gray,
    Rgb,
    /// Luminance and two differences, of 8 bits.
    Ybr,
}

/// A slice: where it is, what its values mean, and where its pixels are.
#[derive(Clone, Debug)]
pub(super) struct Frame {
    /// Among the files of the series.
    pub(super) file_idx: usize,
    /// In its file.
    pub(super) frame_idx: usize,
    /// The middle of the first pixel, in LPS millimetres.
    pub(super) position: Option<DVec3>,
    /// The directions in which columns and rows are counted.
    pub(super) axes: Option<[DVec3; 2]>,
    /// Millimetres from column to column, and from row to row.
    pub(super) spacing: Option<[f64; 2]>,
    /// From slice to slice, where there is no other slice to tell; or else a slice's thickness.
    pub(super) slice_spacing: Option<f64>,
    pub(super) slope: f64,
    pub(super) intercept: f64,
    /// What tells frames at one place apart: kind, echo, segment.
    pub(super) kind: String,
    /// What orders frames of one kind at one place.
    pub(super) order: [i64; 4],
}

/// What a file is about.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct About {
    pub(super) series_uid: String,
    pub(super) modality: String,
    pub(super) number: Option<i64>,
    pub(super) description: String,
}

impl About {
    pub(super) fn of(dataset: &Dataset) -> Self {
        let text = |tag| dataset.text(tag).unwrap_or_default().to_owned();
        Self {
            series_uid: text(tags::SERIES_UID),
            modality: text(tags::MODALITY),
            number: dataset.whole(tags::SERIES_NUMBER),
            description: text(tags::SERIES_DESCRIPTION),
        }
    }
}

const OF_A_PALETTE: &str = "its pixels are numbers of a palette's colours, which cannot be read: `gdcmconv \
                            --apply-lut IN OUT` makes colours of them";

impl Colors {
    /// By the file's word for them (PS3.3 §C.7.6.3.1.2), which depends on how they are packed (PS3.5 §8.2).
    fn of(photometric: &str, n_channels: usize, packing: Packing) -> Result<Self, String> {
        match (n_channels, photometric, packing) {
            (1, "MONOCHROME1" | "MONOCHROME2", _) => Ok(Self::Gray),
            // What unpacks JPEG 2000 undoes the latter two.
            (3, "RGB", _) | (3, "YBR_RCT" | "YBR_ICT", Packing::Jpeg2000) => Ok(Self::Rgb),
            (3, "YBR_FULL", _) | (3, "YBR_FULL_422", Packing::Jpeg) => Ok(Self::Ybr),
            (1, "PALETTE COLOR", _) => Err(OF_A_PALETTE.to_owned()),
            _ => {
                let shown: String = photometric.chars().take(32).collect();
                let what = format!("pixels of {n_channels} values, {shown:?}, cannot be read");
                Err(format!("{what}: convert them to gray or RGB"))
            }
        }
    }
}

impl Layout {
    /// `None` if the file holds no image.
    pub(super) fn of(path: &Path, header: &Header) -> Result<Option<Self>, IoError> {
        let dataset = &header.dataset;
        let number = |tag: Tag| dataset.unsigned(tag);
        let (Some(pixels), Some(rows), Some(columns)) =
            (header.pixels, number(tags::ROWS), number(tags::COLUMNS))
        else {
            return Ok(None);
        };
        let bits_allocated = match pixels.tag {
            tags::FLOAT_PIXEL_DATA => 32,
            tags::DOUBLE_PIXEL_DATA => 64,
            _ => number(tags::BITS_ALLOCATED).unwrap_or(16),
        };
        let is_float = pixels.tag != tags::PIXEL_DATA;
        let bits_stored = number(tags::BITS_STORED).filter(|_| !is_float).unwrap_or(bits_allocated);
        let high_bit = number(tags::HIGH_BIT).unwrap_or(bits_stored.saturating_sub(1));
        let photometric = dataset.text(tags::PHOTOMETRIC).unwrap_or("MONOCHROME2");
        let n_channels = number(tags::SAMPLES_PER_PIXEL).unwrap_or(1) as usize;
        let packing = header.syntax.packing;
        let colors = Colors::of(photometric, n_channels, packing)
            .map_err(|what| IoError::unsupported(path, what))?;
        let layout = Self {
            rows: rows as usize,
            columns: columns as usize,
            n_channels,
            colors,
            // However the values of a pixel are packed, they are unpacked together.
            is_planar: number(tags::PLANAR) == Some(1) && packing == Packing::None,
            bits_allocated,
            bits_stored,
            high_bit: if is_float { bits_allocated - 1 } else { high_bit },
            is_signed: number(tags::PIXEL_REPRESENTATION) == Some(1),
            is_float,
            is_inverse: photometric == "MONOCHROME1",
        };
        layout.check(path)?;
        Ok(Some(layout))
    }

    fn check(&self, path: &Path) -> Result<(), IoError> {
        let is_byte = matches!(self.bits_allocated, 8 | 16 | 32) || self.is_float;
        if !is_byte {
            let what = format!("pixels of {} bits cannot be read", self.bits_allocated);
            return Err(IoError::unsupported(path, what));
        }
        let are_within =
            self.high_bit < self.bits_allocated && self.bits_stored <= self.high_bit + 1;
        if self.bits_stored == 0 || !are_within {
            let what = format!(
                "{} bits up to bit {} do not fit into pixels of {}",
                self.bits_stored, self.high_bit, self.bits_allocated
            );
            return Err(IoError::malformed(path, what));
        }
        if self.colors == Colors::Ybr && (self.bits_allocated, self.bits_stored) != (8, 8) {
            let what = format!("YBR_FULL of {} bits cannot be read", self.bits_stored);
            return Err(IoError::unsupported(path, format!("{what}: convert it to RGB")));
        }
        Ok(())
    }

    pub(super) fn n_pixels(&self) -> usize {
        self.rows.saturating_mul(self.columns)
    }

    /// Of one frame, unpacked.
    pub(super) fn frame_bytes(&self) -> u64 {
        let pixel_bytes = self.n_channels as u64 * u64::from(self.bits_allocated / 8);
        (self.n_pixels() as u64).saturating_mul(pixel_bytes)
    }
}

/// The frames of a file, of which there are `n_backed` at most.
pub(super) fn frames(
    path: &Path,
    dataset: &Dataset,
    file_idx: usize,
    n_backed: u64,
) -> Result<Vec<Frame>, IoError> {
    let shared = dataset.items(tags::SHARED_GROUPS).first();
    let per_frame = dataset.items(tags::PER_FRAME_GROUPS);
    let n_frames = dataset.whole(tags::N_FRAMES).unwrap_or(1).max(1);
    let n_frames = usize::try_from(n_frames).unwrap_or(usize::MAX);
    if MAX_FRAMES < n_frames || (!per_frame.is_empty() && per_frame.len() < n_frames) {
        let what = format!("it says to have {n_frames} frames, and tells of {}", per_frame.len());
        return Err(IoError::malformed(path, what));
    }
    if MAX_UNBACKED_FRAMES.max(n_backed) < n_frames as u64 {
        let what = format!("it says to have {n_frames} frames, and has room for {n_backed}");
        return Err(IoError::malformed(path, what));
    }
    let frame = |frame_idx| {
        let groups = Groups { dataset, shared, own: per_frame.get(frame_idx) };
        groups.frame(file_idx, frame_idx)
    };
    Ok((0..n_frames).map(frame).collect())
}

/// Where what is said of a frame is looked for: in its own groups, in those of all, in the file.
struct Groups<'d> {
    dataset: &'d Dataset,
    shared: Option<&'d Dataset>,
    own: Option<&'d Dataset>,
}

impl<'d> Groups<'d> {
    /// The item of a group, or the file as a whole if there is no such group.
    fn group(&self, sequence: Tag) -> &'d Dataset {
        let in_groups = |groups: Option<&'d Dataset>| groups?.items(sequence).first();
        in_groups(self.own).or_else(|| in_groups(self.shared)).unwrap_or(self.dataset)
    }

    fn frame(&self, file_idx: usize, frame_idx: usize) -> Frame {
        let dataset = self.dataset;
        let position = self.group(tags::PLANE_POSITION).decimals(tags::IMAGE_POSITION);
        let orientation = self.group(tags::PLANE_ORIENTATION).decimals(tags::IMAGE_ORIENTATION);
        let axes = orientation
            .map(|[a, b, c, d, e, f]: [f64; 6]| [DVec3::new(a, b, c), DVec3::new(d, e, f)]);
        let measures = self.group(tags::PIXEL_MEASURES);
        let spacing: Option<[f64; 2]> = measures
            .decimals(tags::PIXEL_SPACING)
            .or_else(|| dataset.decimals(tags::IMAGER_PIXEL_SPACING));
        let slice_spacing = measures
            .decimal(tags::SLICE_SPACING)
            .or_else(|| measures.decimal(tags::SLICE_THICKNESS));
        let transformation = self.group(tags::PIXEL_TRANSFORMATION);
        let slope = transformation.decimal(tags::SLOPE).filter(|slope| *slope != 0.0);
        Frame {
            file_idx,
            frame_idx,
            position: position.map(DVec3::from_array),
            axes: axes.filter(are_axes).map(|axes| axes.map(DVec3::normalize)),
            // Rows first in the file.
            spacing: spacing.map(|[y, x]| [x, y]).filter(|s| s.iter().all(|&s| 0.0 < s)),
            slice_spacing: slice_spacing.map(f64::abs).filter(|s| s.is_normal()),
            slope: slope.unwrap_or(1.0),
            intercept: transformation.decimal(tags::INTERCEPT).unwrap_or(0.0),
            kind: self.kind(),
            order: self.order(frame_idx),
        }
    }

    fn kind(&self) -> String {
        let dataset = self.dataset;
        let echo = self.group(tags::MR_ECHO).double(tags::EFFECTIVE_ECHO_TIME);
        let echo = echo.map(|ms| format!("echo at {ms} ms")).or_else(|| {
            let number = dataset.whole(tags::ECHO_NUMBER)?;
            Some(format!("echo {number}"))
        });
        let segment = self.group(tags::SEGMENT_IDENTIFICATION).unsigned(tags::SEGMENT_NUMBER);
        let segment = segment.map(|number| format!("segment {number}"));
        // The first two words say whether the image is original, the others what it shows.
        let image_type = dataset.text(tags::IMAGE_TYPE).unwrap_or_default();
        let shown = image_type.split('\\').skip(2).collect::<Vec<_>>().join(" ");
        let parts = [Some(shown).filter(|shown| !shown.is_empty()), echo, segment];
        parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
    }

    fn order(&self, frame_idx: usize) -> [i64; 4] {
        let dataset = self.dataset;
        let content = self.group(tags::FRAME_CONTENT);
        let temporal = content.unsigned(tags::TEMPORAL_INDEX).map(i64::from);
        let temporal = temporal.or_else(|| dataset.whole(tags::TEMPORAL_POSITION)).unwrap_or(0);
        let trigger = dataset.decimal(tags::TRIGGER_TIME).unwrap_or(0.0);
        let acquisition = dataset.whole(tags::ACQUISITION_NUMBER).unwrap_or(0);
        let instance = dataset.whole(tags::INSTANCE_NUMBER).unwrap_or(0);
        let instance = instance.saturating_add(frame_idx as i64);
        [temporal, (trigger * 1e3) as i64, acquisition, instance]
    }
}

/// Whether two directions span a plane.
fn are_axes([x, y]: &[DVec3; 2]) -> bool {
    let [x_length, y_length] = [x.length(), y.length()];
    x_length.is_normal()
        && y_length.is_normal()
        && 1e-3 < x.cross(*y).length() / (x_length * y_length)
}
