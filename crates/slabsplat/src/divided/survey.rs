//! What is looked at of a volume in boxes before it is drawn. It is what is looked at of one in memory, voxel
//! by voxel and in the same order, so that the same is found.
//!
//! ```text
//! look      some rows, evenly spread: 2²² voxels at most
//! values    all voxels, and only if a transfer function is stretched to them: at once if samples have 16
//!           bits, else as often as one in memory looks at them
//! camera    up to 3³ voxels of each of 96³ cells, and only if there is a camera to be found
//! ```
//!
//! Of several who share a scene each looks at a part, and all hear of it. Boxes are no larger than some
//! mebibytes, and lie so that those in a row meet the same chunks.

use super::{DividedError, Exchange};
use crate::automatic::LookedAt;
use crate::framing::{CellLayout, Cells};
use slabsplat_core::glam::{DAffine3, DMat3, DVec3};
use slabsplat_core::{Grid, Layer, Mode, Samples, Scaling, Volume, with_samples};
use slabsplat_io::{IoError, LabelBoxes, VolumeBoxes};
use std::cell::RefCell;
use std::ops::Range;

/// A volume that is looked at.
#[derive(Clone, Copy)]
pub(super) struct Survey<'a, 'e> {
    pub(super) source: &'a VolumeBoxes,
    pub(super) labels: Option<&'a LabelBoxes>,
    pub(super) others: &'a RefCell<&'e mut dyn Exchange>,
}

/// Voxels along x, y and z.
type VoxelBox = [Range<usize>; 3];

/// Voxels along the side of boxes that meet the same chunks.
const SIDE_OF_CHUNKS: usize = VolumeBoxes::SIDE_OF_CHUNKS;

/// Layers of cells that are summed at a time.
const MOST_LAYERS: usize = 16;

/// Rows that are looked at and so far apart are read one by one.
const FAR_APART: usize = 16;

impl Survey<'_, '_> {
    /// The pieces that are looked at here.
    pub(super) fn own_pieces(self) -> impl Iterator<Item = VoxelBox> {
        let (first, n) = self.share();
        self.source.pieces().into_iter().skip(first).step_by(n)
    }

    /// Which of how many this is.
    pub(super) fn share(self) -> (usize, usize) {
        let others = self.others.borrow();
        (others.share_idx(), others.n_shares())
    }

    /// Hands in samples, and takes those of all.
    pub(super) fn all(self, own: Result<Samples, IoError>) -> Result<Vec<Samples>, DividedError> {
        self.others.borrow_mut().all(own)
    }

    /// The rows of which the look of the volume is found, as a volume of one plane.
    pub(super) fn rows(self) -> Result<Volume, DividedError> {
        let looked_at = LookedAt::of(self.source.grid().dims());
        let all = self.all(self.own_rows(looked_at))?;
        let nx = self.source.grid().dims()[0];
        let samples = joined(all, (0..looked_at.n_rows).map(|_| nx))?;
        let grid = Grid::with_spacing([nx, looked_at.n_rows, 1], [1.0; 3]);
        let grid = grid.expect("it has no more voxels than the volume");
        let volume = Volume::new(grid, samples, self.source.first().volume.scaling());
        Ok(volume.expect("as many samples were joined as there are voxels"))
    }

    fn own_rows(self, LookedAt { stride, n_rows }: LookedAt) -> Result<Samples, IoError> {
        let ([nx, ny, _], (share_idx, n_shares)) = (self.source.grid().dims(), self.share());
        let n_own = (share_idx..n_rows).step_by(n_shares).len();
        let first = self.source.first().volume.samples();
        let mut rows: Samples = with_samples!(first, |s| vec![s[0]; nx * n_own].into());
        // Of rows from `first` on, which one is taken, of all that are looked at, and its number here.
        let own = |at: [usize; 2]| {
            let row = at[1] * ny + at[0];
            let is_own = row.is_multiple_of(stride) && row / stride % n_shares == share_idx;
            is_own.then_some(row / stride / n_shares)
        };
        let boxes: Vec<VoxelBox> = if stride < FAR_APART {
            self.source.pieces()
        } else {
            let own = (share_idx..n_rows).step_by(n_shares).map(|idx| idx * stride);
            let mut ats: Vec<[usize; 2]> = own.map(|row| [row % ny, row / ny]).collect();
            // Those that meet the same chunks.
            ats.sort_by_key(|[y, z]| [z / SIDE_OF_CHUNKS, y / SIDE_OF_CHUNKS, *z, *y]);
            ats.into_iter().map(|[y, z]| [0..nx, y..y + 1, z..z + 1]).collect()
        };
        for of in boxes {
            let read = self.source.read(of.clone())?.volume;
            let ats = of[2].clone().flat_map(|z| of[1].clone().map(move |y| [y, z]));
            for (idx, at) in ats.enumerate() {
                if let Some(own_idx) = own(at) {
                    copy(read.samples(), idx * nx..(idx + 1) * nx, &mut rows, own_idx * nx);
                }
            }
        }
        Ok(rows)
    }

    /// What of a layer is visible, whose volume this is.
    pub(super) fn cells(self, layer: &Layer, mode: Mode) -> Result<Cells, DividedError> {
        let layout = CellLayout::new(layer, &self.source.grid(), mode);
        let (first, n_shares) = self.share();
        let groups = self.groups(&layout);
        let own = groups.iter().skip(first).step_by(n_shares);
        let own = own.map(|group| self.extinctions(&layout, group.clone()));
        let own = own.collect::<Result<Vec<_>, _>>().map(|own| Samples::F64(own.concat()));
        let all = self.all(own)?;
        let n_in_group = |group: &Range<usize>| group.len() * layout.n_in_layer();
        let Samples::F64(extinctions) = joined(all, groups.iter().map(n_in_group))? else {
            return Err(DividedError::Differing);
        };
        Ok(layout.cells(&extinctions))
    }

    /// Layers of cells that are summed together: one, or those that meet the same chunks.
    fn groups(self, layout: &CellLayout<'_>) -> Vec<Range<usize>> {
        let depth = layout.depth();
        let n_together = match self.source.is_in_chunks() {
            true => (SIDE_OF_CHUNKS / depth).clamp(1, MOST_LAYERS),
            false => 1,
        };
        let n_layers = layout.n_layers();
        let starts = (0..n_layers).step_by(n_together);
        starts.map(|first| first..(first + n_together).min(n_layers)).collect()
    }

    fn extinctions(
        self,
        layout: &CellLayout<'_>,
        group: Range<usize>,
    ) -> Result<Vec<f64>, IoError> {
        let planes: Vec<(usize, usize)> = group
            .clone()
            .flat_map(|cell_z| layout.planes(cell_z).map(move |z| (cell_z, z)))
            .collect();
        let (Some((_, first)), Some((_, last))) = (planes.first(), planes.last()) else {
            return Ok(Vec::new());
        };
        let boxes: Vec<VoxelBox> = match self.source.is_in_chunks() {
            true => self.source.strips(&(*first..last + 1)),
            false => planes.iter().flat_map(|(_, z)| self.source.strips(&(*z..z + 1))).collect(),
        };
        let mut sums = vec![layout.sums(); group.len()];
        for [columns, rows, depths] in boxes {
            let n_in_plane = columns.len() * rows.len();
            let read = self.source.read([columns, rows.clone(), depths.clone()])?.volume;
            let labels = self.labels.map(|labels| labels.on(read.grid())).transpose()?;
            for (cell_z, z) in planes.iter().filter(|(_, z)| depths.contains(z)) {
                let at = (z - depths.start) * n_in_plane;
                let labels = labels.as_ref().map(|labels| (labels.map(), at));
                with_samples!(read.samples(), |samples| {
                    let samples = &samples[at..at + n_in_plane];
                    layout.add(&mut sums[cell_z - group.start], &rows, samples, labels);
                });
            }
        }
        Ok(sums.iter().flat_map(|sums| layout.extinctions(sums)).collect())
    }
}

fn copy(from: &Samples, range: Range<usize>, to: &mut Samples, at: usize) {
    macro_rules! same {
        ($($Type:ident),+) => {
            match (from, to) {
                $((Samples::$Type(from), Samples::$Type(to)) => {
                    to[at..at + range.len()].copy_from_slice(&from[range]);
                })+
                _ => unreachable!("all boxes of a volume are of one type"),
            }
        };
    }
    same!(U8, I8, U16, I16, U32, I32, F32, F64);
}

/// What shares handed in, each every so manieth item, in the order of items, of which the lengths are given;
/// if they are of one type and all there.
pub(super) fn joined(
    mut all: Vec<Samples>,
    lens: impl Iterator<Item = usize>,
) -> Result<Samples, DividedError> {
    if all.len() == 1 {
        let is_all = lens.sum::<usize>() == all[0].len();
        return all.pop().filter(|_| is_all).ok_or(DividedError::Differing);
    }
    let mut starts = vec![0; all.len()];
    let mut joined: Option<Samples> = None;
    for (idx, len) in lens.enumerate() {
        let share = idx % all.len();
        let item = starts[share]..starts[share] + len;
        starts[share] = item.end;
        let of_share = &all[share];
        if of_share.len() < item.end || of_share.sample_type() != all[0].sample_type() {
            return Err(DividedError::Differing);
        }
        let item: Samples = with_samples!(of_share, |s| s[item].to_vec().into());
        match &mut joined {
            None => joined = Some(item),
            Some(joined) => joined.append(&item),
        }
    }
    joined.ok_or(DividedError::Differing)
}

/// The scene as annotations see it: volumes that end where the whole ones do, of their least and their
/// largest value.
pub(super) fn outline(grid: &Grid, range: Option<[f64; 2]>) -> Volume {
    let dims = DVec3::from_array(grid.dims().map(|n| n as f64));
    let steps = dims * DVec3::new(0.5, 1.0, 1.0);
    let first = 0.5 * steps - 0.5;
    let index_from_index = DAffine3::from_mat3_translation(DMat3::from_diagonal(steps), first);
    let of_two = Grid::new([2, 1, 1], grid.world_from_index() * index_from_index);
    let of_two = of_two.expect("it is as large as a grid that there is");
    let samples = Samples::F64(range.unwrap_or([f64::NAN; 2]).to_vec());
    Volume::new(of_two, samples, Scaling::IDENTITY).expect("there are two")
}
