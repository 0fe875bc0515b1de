//! The voxels around a box that a rank needs and has not: whoever owns them sends them.

use super::boxes::meets;
use super::field::{holds, volume};
use super::{Field, InSituError, VoxelBox};
use crate::collective::{agree, all_gather};
use crate::communicator::receive;
use crate::samples::{from_bytes, to_bytes};
use crate::{Communicator, MpiError, Tag};
use slabsplat::{Grid, Samples, Volume, with_samples};
use std::ops::Range;

/// A rank's box with all voxels around it that it needs; nothing if it has no box. `near` has what each rank
/// needs, `boxes` what each owns.
pub(super) fn exchange(
    comm: &dyn Communicator,
    field: &Field<'_>,
    (boxes, near): (&[VoxelBox], &[Option<VoxelBox>]),
    grid: &Grid,
) -> Result<Option<Volume>, InSituError> {
    let own = comm.rank();
    let lacks = near[own].as_ref().is_some_and(|near| !holds(field.held(), near));
    let all_lack = all_gather(comm, vec![u8::from(lacks)])?;
    let others = || (0..comm.n_ranks()).filter(|rank| *rank != own);
    for rank in others().filter(|rank| all_lack[*rank] == [1]) {
        if let Some(needed) = near[rank].as_ref().filter(|near| meets(near, &boxes[own])) {
            let part = field.part(&common(needed, &boxes[own]));
            comm.send(rank, Tag::Ghosts, to_bytes(&part))?;
        }
    }
    let Some(near) = &near[own] else {
        agree(comm, Ok::<_, MpiError>(()))?;
        return Ok(None);
    };
    let filled = if lacks {
        let mut filled = Filled::new(near, field);
        let senders = others().filter(|rank| meets(near, &boxes[*rank]));
        let received = senders.map(|rank| {
            let bytes = receive(comm, rank, Tag::Ghosts)?;
            let is_laid = from_bytes(&bytes)
                .is_some_and(|part| filled.lay(&part, &common(near, &boxes[rank])));
            let malformed = MpiError::Malformed { rank, what: "box of ghosts" };
            if is_laid { Ok(()) } else { Err(malformed) }
        });
        received.collect::<Result<(), MpiError>>()?;
        filled.samples
    } else {
        field.part(near)
    };
    let volume = volume(grid.cropped(near), filled);
    Ok(Some(agree(comm, volume)?))
}

fn common(a: &VoxelBox, b: &VoxelBox) -> VoxelBox {
    [0, 1, 2].map(|axis| a[axis].start.max(b[axis].start)..a[axis].end.min(b[axis].end))
}

/// A box that is being put together.
struct Filled<'a> {
    near: &'a VoxelBox,
    samples: Samples,
}

impl<'a> Filled<'a> {
    /// With what is held, and zeros elsewhere, which are all replaced, as boxes are all of the grid.
    fn new(near: &'a VoxelBox, field: &Field<'_>) -> Self {
        let held = common(near, field.held());
        let part = field.part(&held);
        let n_voxels = near.iter().map(Range::len).product();
        let samples = with_samples!(&part, |s| zeros(s, n_voxels));
        let mut filled = Self { near, samples };
        filled.lay(&part, &held);
        filled
    }

    /// Whether it is of the same type, and as many as the voxels.
    fn lay(&mut self, part: &Samples, voxels: &VoxelBox) -> bool {
        let dims = voxels.each_ref().map(Range::len);
        let [nx, ny, _] = self.near.each_ref().map(Range::len);
        let first = [0, 1, 2].map(|axis| voxels[axis].start - self.near[axis].start);
        if part.len() != dims.iter().product::<usize>() {
            return false;
        }
        let rows = (0..dims[2]).flat_map(|k| (0..dims[1]).map(move |j| (j, k)));
        let starts = rows.map(|(j, k)| ((first[2] + k) * ny + first[1] + j) * nx + first[0]);
        let starts: Vec<usize> = starts.collect();
        match (&mut self.samples, part) {
            (Samples::U8(all), Samples::U8(part)) => lay_rows(all, part, &starts),
            (Samples::U16(all), Samples::U16(part)) => lay_rows(all, part, &starts),
            (Samples::F32(all), Samples::F32(part)) => lay_rows(all, part, &starts),
            (Samples::F64(all), Samples::F64(part)) => lay_rows(all, part, &starts),
            _ => return false,
        }
        true
    }
}

fn zeros<T: slabsplat::Sample>(_: &[T], n: usize) -> Samples
where
    Samples: From<Vec<T>>,
{
    vec![T::zeroed(); n].into()
}

fn lay_rows<T: Copy>(all: &mut [T], part: &[T], starts: &[usize]) {
    let Some(n) = part.len().checked_div(starts.len()).filter(|n| 0 < *n) else { return };
    for (row, start) in part.chunks_exact(n).zip(starts) {
        all[*start..start + n].copy_from_slice(row);
    }
}
