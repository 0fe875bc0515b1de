//! What a scene says of labels, before there is a volume.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::{Path, PathBuf};

use slabsplat_core::glam::DVec3;
use slabsplat_core::{Grid, LabelError, LabelMap, LabelStyle, Labels};

use super::completed::DIFFERS;
use super::label_table::read_label_table;
use super::{LayerFile, VolumeBoxes, VolumeSource};
use crate::printable::shown_path;
use crate::{ContentHash, IoError, ScratchDesc, read_volume};

/// Labels of a layer, and how they look, as a scene file or flags say it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct LabelsFile {
    /// A volume of whole numbers, on the layer's grid or another.
    pub path: PathBuf,
    /// Of the labels that the scene was made of, on the layer's grid.
    pub hash: Option<ContentHash>,
    /// Where colours come from that no style says.
    pub colors: Option<LabelColors>,
    /// How labels look that look otherwise than the layer says.
    pub styles: BTreeMap<i64, LabelStyle>,
    /// The only labels that are visible, if not all are.
    pub only: Option<Vec<i64>>,
}

/// Where labels have their colours from.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LabelColors {
    /// Each label but 0 gets one, far from those of the numbers beside it.
    Automatic,
    /// No label has one but by its style.
    None,
    /// A table of FreeSurfer, 3D Slicer, ITK-SNAP or BIDS.
    Table(PathBuf),
}

impl LabelColors {
    /// `auto`, `none`, or the name of a table's file in `folder`.
    pub fn named(name: &Path, folder: &Path) -> Self {
        match name.to_str() {
            Some("auto") => Self::Automatic,
            Some("none") => Self::None,
            _ => Self::Table(folder.join(name)),
        }
    }

    /// As [`named`](Self::named) takes it, with an empty folder.
    pub(super) fn name(&self) -> PathBuf {
        match self {
            Self::Automatic => "auto".into(),
            Self::None => "none".into(),
            Self::Table(path) => path.clone(),
        }
    }
}

/// Labels that a warning lists.
const MAX_LISTED: usize = 8;

impl LabelsFile {
    /// Labels as they are in a file. Where nothing else is said, each has a colour.
    pub fn new(path: PathBuf) -> Self {
        Self { path, hash: None, colors: None, styles: BTreeMap::new(), only: None }
    }

    /// Reads the labels of a layer on `grid`, and returns them with warnings, one line each.
    ///
    /// # Errors
    /// If a file cannot be read, or is not of labels or their colours.
    pub fn load(&self, grid: &Grid) -> Result<(Labels, Vec<String>), IoError> {
        let unlabelled = |source: LabelError| IoError::Labels { path: self.path.clone(), source };
        let loaded = read_volume(&self.path)?;
        if loaded.colors.is_some() {
            let what = "labels are whole numbers, and its voxels are colours";
            return Err(IoError::unsupported(self.path.as_path(), what));
        }
        let map = LabelMap::new(&loaded.volume, grid).map_err(unlabelled)?;
        let mut styles = self.styles_of(map.labels())?;
        let mut warnings = loaded.warnings;
        if self.hash.is_some_and(|hash| hash != ContentHash::of_labels(&map)) {
            let path = shown_path(&self.path);
            let what = "does not hold the labels that the scene was made of";
            warnings.push(format!("{path} {what}: {DIFFERS}"));
        }
        warnings.extend(self.missing(map.labels()));
        warnings.extend(uncolored(map.labels(), &styles));
        retain_useful(&mut styles, map.labels());
        let labels = Labels::new(map, styles).map_err(unlabelled)?;
        warnings.extend(self.useless(&labels));
        Ok((labels, warnings))
    }

    /// Opens the labels to read those of boxes, as volumes are opened by
    /// [`LayerFile::open_boxes`](crate::LayerFile::open_boxes); all of them are looked at once. Returns
    /// warnings, too, but for those of where voxels of the layer are.
    ///
    /// # Errors
    /// As [`load`](Self::load), and if no boxes can be read.
    pub fn open_boxes(&self, scratch: &ScratchDesc) -> Result<(LabelBoxes, Vec<String>), IoError> {
        let unlabelled = |source: LabelError| IoError::Labels { path: self.path.clone(), source };
        let layer = LayerFile::of_volume(VolumeSource::File(self.path.clone()));
        let boxes = layer.open_boxes(scratch)?;
        if boxes.first().colors.is_some() {
            let what = "labels are whole numbers, and its voxels are colours";
            return Err(IoError::unsupported(self.path.as_path(), what));
        }
        let mut numbers = BTreeSet::new();
        for voxels in boxes.pieces() {
            let piece = boxes.read(voxels)?.volume;
            let map = LabelMap::new(&piece, piece.grid()).map_err(unlabelled)?;
            numbers.extend(map.labels());
            if LabelMap::MAX_LABELS < numbers.len() {
                return Err(unlabelled(LabelError::TooMany));
            }
        }
        let numbers: Vec<i64> = numbers.into_iter().collect();
        let mut styles = self.styles_of(&numbers)?;
        let mut warnings = boxes.first().warnings.clone();
        warnings.extend(self.missing(&numbers));
        warnings.extend(uncolored(&numbers, &styles));
        retain_useful(&mut styles, &numbers);
        Ok((LabelBoxes { boxes, styles }, warnings))
    }

    /// The labels of voxels that are there already, as this file has them look; nothing is read.
    ///
    /// # Errors
    /// If their colours come from a table, or a style cannot be.
    pub fn styled(&self, labels: &Labels) -> Result<Labels, IoError> {
        if let Some(LabelColors::Table(path)) = &self.colors {
            let what = "a table of colours is not read again: give labels their colours by styles";
            return Err(IoError::unsupported(path.as_path(), what));
        }
        let styles = self.styles_of(labels.map().labels())?;
        let unlabelled = |source: LabelError| IoError::Labels { path: self.path.clone(), source };
        labels.with_styles(styles).map_err(unlabelled)
    }

    fn styles_of(&self, labels: &[i64]) -> Result<BTreeMap<i64, LabelStyle>, IoError> {
        let says_nothing = self.styles.is_empty() && self.only.is_none();
        let mut styles = match &self.colors {
            Some(LabelColors::Table(path)) => read_label_table(path)?,
            Some(LabelColors::Automatic) => automatic(labels),
            None if says_nothing => automatic(labels),
            Some(LabelColors::None) | None => BTreeMap::new(),
        };
        for (&label, style) in &self.styles {
            let mut style = style.clone();
            let of_table = styles.remove(&label).unwrap_or_default();
            // A transfer function has colours of its own.
            if style.transfer.is_none() {
                style.color = style.color.or(of_table.color);
            }
            style.opacity *= of_table.opacity;
            styles.insert(label, style);
        }
        if let Some(only) = &self.only {
            for &label in labels.iter().filter(|label| !only.contains(label)) {
                styles.entry(label).or_default().opacity = 0.0;
            }
        }
        Ok(styles)
    }

    /// Warns of labels that no voxel has, and of those that leave nothing visible.
    fn useless(&self, labels: &Labels) -> Option<String> {
        let (path, map) = (shown_path(&self.path), labels.map());
        let of_voxels = labels.of_voxels();
        if map.n_outside() == map.indices().len() {
            Some(format!("{path} lies beside the volume, so that no voxel has one of its labels"))
        } else if !labels.any_visible() {
            let of_voxels = listed(&of_voxels);
            Some(format!("no label of {path} that voxels have is visible: they have {of_voxels}"))
        } else if of_voxels == [0] {
            Some(format!("all voxels have the label 0 of {path}"))
        } else {
            None
        }
    }

    /// Names labels that are asked for, and that the file lacks.
    fn missing(&self, labels: &[i64]) -> Option<String> {
        let is_missing = |label: &i64| labels.binary_search(label).is_err();
        let asked = self.only.iter().flatten().chain(self.styles.keys()).copied();
        let mut missing: Vec<i64> = asked.filter(is_missing).collect();
        missing.sort_unstable();
        missing.dedup();
        let path = shown_path(&self.path);
        (!missing.is_empty()).then(|| format!("{path} has no such labels: {}", listed(&missing)))
    }
}

/// Labels of a volume that are read for some of its voxels at a time.
#[derive(Clone, Debug)]
pub struct LabelBoxes {
    boxes: VolumeBoxes,
    styles: BTreeMap<i64, LabelStyle>,
}

impl LabelBoxes {
    /// The labels of all voxels of a grid, as [`LabelMap::new`] has them; of the file no more is read than
    /// lies around that.
    ///
    /// # Errors
    /// If they cannot be read any more.
    pub fn on(&self, grid: &Grid) -> Result<Labels, IoError> {
        let path = || self.boxes.path().to_owned();
        let part = self.boxes.read(self.around(grid))?.volume;
        let map = LabelMap::new(&part, grid);
        let labels = map.and_then(|map| Labels::new(map, self.styles.clone()));
        labels.map_err(|source| IoError::Labels { path: path(), source })
    }

    /// The voxels of the file that are nearest to any of a grid's, and some around them.
    fn around(&self, grid: &Grid) -> [Range<usize>; 3] {
        let whole = self.boxes.grid();
        let index_from_world = whole.index_from_world();
        let corners = grid.corners_in_world().map(|at| index_from_world.transform_point3(at));
        let ends = corners.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[min, max], at| {
            [min.min(at), max.max(at)]
        });
        [0, 1, 2].map(|axis| {
            let last = whole.dims()[axis] - 1;
            let at = |index: f64| index.clamp(0.0, last as f64) as usize;
            at(ends[0][axis].floor() - 1.0)..at(ends[1][axis].ceil() + 1.0) + 1
        })
    }

    /// As [`VolumeBoxes::scratch_handle`].
    ///
    /// # Errors
    /// As there.
    pub fn scratch_handle(&self) -> Result<Option<Vec<u8>>, IoError> {
        self.boxes.scratch_handle()
    }

    /// Bytes that labels take for each voxel of a grid while they are read.
    pub fn voxel_bytes(&self, grid: &Grid) -> u64 {
        let whole = self.boxes.grid();
        let volume = |of: &Grid| of.world_from_index().matrix3.determinant().abs();
        let n_each = volume(grid) / volume(&whole);
        // Its own index, and what it is found from.
        2 + (n_each * self.boxes.voxel_bytes() as f64).ceil() as u64
    }
}

/// Tables are of more labels than most volumes have.
fn retain_useful(styles: &mut BTreeMap<i64, LabelStyle>, labels: &[i64]) {
    styles.retain(|label, style| {
        labels.binary_search(label).is_ok() && *style != LabelStyle::default()
    });
}

/// Lists visible labels that have no colour, where others have one.
fn uncolored(labels: &[i64], styles: &BTreeMap<i64, LabelStyle>) -> Option<String> {
    let has_color = |style: &LabelStyle| style.color.is_some() || style.transfer.is_some();
    if !styles.values().any(|style| style.color.is_some()) {
        return None;
    }
    let needs_one = |label: &i64| {
        *label != 0
            && styles.get(label).is_none_or(|style| 0.0 < style.opacity && !has_color(style))
    };
    let uncolored: Vec<i64> = labels.iter().copied().filter(needs_one).collect();
    let what = "labels without a colour, drawn as the transfer function says";
    (!uncolored.is_empty()).then(|| format!("{what}: {}", listed(&uncolored)))
}

fn listed(labels: &[i64]) -> String {
    let first = labels.iter().take(MAX_LISTED).map(i64::to_string).collect::<Vec<_>>().join(", ");
    match labels.len().saturating_sub(MAX_LISTED) {
        0 => first,
        n_more => format!("{first} and {n_more} more"),
    }
}

fn automatic(labels: &[i64]) -> BTreeMap<i64, LabelStyle> {
    let style = |&label: &i64| (label, LabelStyle::default().color(automatic_color(label)));
    labels.iter().filter(|&&label| label != 0).map(style).collect()
}

/// Hues go round by the golden ratio, so that any few numbers in a row lie far apart.
fn automatic_color(label: i64) -> [f64; 3] {
    const GOLDEN_RATIO: f64 = 0.618_033_988_749_894_9;
    let hue = 6.0 * (label as f64 * GOLDEN_RATIO).rem_euclid(1.0);
    let [paler, darker] = [label.rem_euclid(3) as f64, label.rem_euclid(2) as f64];
    let (saturation, value) = (0.75 - 0.15 * paler, 1.0 - 0.15 * darker);
    [5.0, 3.0, 1.0].map(|offset| {
        let at = (offset + hue) % 6.0;
        value * (1.0 - saturation * at.min(4.0 - at).clamp(0.0, 1.0))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::TransferFunction;

    fn style(color: Option<[f64; 3]>, opacity: f64) -> LabelStyle {
        let style = LabelStyle::default().opacity(opacity);
        color.into_iter().fold(style, LabelStyle::color)
    }

    #[test]
    fn labels_get_colors_that_differ() {
        let colors: Vec<[f64; 3]> = (1..60).map(automatic_color).collect();
        assert!(colors.iter().flatten().all(|channel| (0.0..=1.0).contains(channel)));
        for (idx, a) in colors.iter().enumerate() {
            for b in colors.iter().skip(idx + 1).take(5) {
                let distance: f64 = a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum();
                assert!(0.25 < distance, "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn labels_without_a_word_are_colored() {
        let file = LabelsFile::new("a.nii".into());
        let styles = file.styles_of(&[0, 1, 2]).unwrap();
        assert_eq!(styles.keys().copied().collect::<Vec<_>>(), [1, 2]);
        let only = LabelsFile { only: Some(vec![2]), ..file };
        let expected = [(0, style(None, 0.0)), (1, style(None, 0.0))];
        assert_eq!(only.styles_of(&[0, 1, 2]).unwrap(), expected.into());
    }

    #[test]
    fn styles_are_laid_over_a_table() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("labels.ctbl");
        std::fs::write(&path, "1 a 255 0 0 255\n2 b 0 255 0 51\n3 c 0 0 255 255\n").unwrap();
        let transfer = TransferFunction::new(vec![(0.0, [1.0])], vec![(0.0, [0.5; 3])]).unwrap();
        let own = LabelStyle::default().transfer(transfer);
        let said = [(2, style(None, 0.5)), (3, own.clone()), (4, style(Some([1.0; 3]), 1.0))];
        let file = LabelsFile {
            colors: Some(LabelColors::Table(path)),
            styles: said.into(),
            ..LabelsFile::new("a.nii".into())
        };
        let expected = [
            (1, style(Some([1.0, 0.0, 0.0]), 1.0)),
            (2, style(Some([0.0, 1.0, 0.0]), 0.1)),
            (3, own),
            (4, style(Some([1.0; 3]), 1.0)),
        ];
        let styles = file.styles_of(&[0, 1, 2, 3, 4, 5]).unwrap();
        assert_eq!(styles, expected.into());
        let warning = uncolored(&[0, 1, 2, 3, 4, 5], &styles).unwrap();
        assert!(warning.ends_with("function says: 5"), "{warning}");
        assert_eq!(file.missing(&[1, 2, 3]).unwrap(), "a.nii has no such labels: 4");
    }

    #[test]
    fn warnings_list_few_labels() {
        assert_eq!(listed(&[1, 2]), "1, 2");
        assert_eq!(listed(&(0..11).collect::<Vec<_>>()), "0, 1, 2, 3, 4, 5, 6, 7 and 3 more");
    }
}
