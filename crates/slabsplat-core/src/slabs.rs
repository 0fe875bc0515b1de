//! Slabs parallel to the image plane (paper §3.2, model §3).

use thiserror::Error;

/// The slabs that the kernels of what is seen meet.
///
/// Slab `n` lies between the depths `n·thickness` and `(n + 1)·thickness` from the centre of what is seen.
/// Slabs are named by their *index*, counted from the first one that any kernel meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlabGrid {
    thickness: f64,
    first: i64,
    n_slabs: usize,
}

/// The slabs are so thin that there are too many of them.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("slabs {thickness} thick cut the volume into {n_slabs:.0} sheets, more than {MAX_SLABS}")]
#[non_exhaustive]
pub struct TooManySlabs {
    /// Thickness asked for, in world units.
    pub thickness: f64,
    /// How many slabs that would be.
    pub n_slabs: f64,
}

/// Slab numbers up to here are exact in 32-bit floats.
const MAX_SLABS: u32 = 1 << 22;

impl SlabGrid {
    /// The slabs of `thickness` world units that meet the depths `near ..= far`.
    ///
    /// # Errors
    /// If there are more than 2²² of them.
    pub fn covering([near, far]: [f64; 2], thickness: f64) -> Result<Self, TooManySlabs> {
        let first = (near / thickness).floor();
        let n_slabs = (far / thickness).ceil() - first;
        if f64::from(MAX_SLABS) < n_slabs.max(first.abs()) {
            return Err(TooManySlabs { thickness, n_slabs });
        }
        Ok(Self { thickness, first: first as i64, n_slabs: n_slabs as usize })
    }

    /// Thickness of a slab in world units.
    pub fn thickness(&self) -> f64 {
        self.thickness
    }

    /// How many slabs there are.
    pub fn n_slabs(&self) -> usize {
        self.n_slabs
    }

    /// Depth of a slab's front face from the centre of what is seen, in world units.
    #[inline]
    pub fn front(&self, slab_idx: usize) -> f64 {
        (self.first + slab_idx as i64) as f64 * self.thickness
    }

    /// Depths of a slab's faces from the centre of what is seen, in world units.
    #[inline]
    pub fn faces(&self, slab_idx: usize) -> [f64; 2] {
        [self.front(slab_idx), self.front(slab_idx + 1)]
    }

    /// Depth of a slab's middle from the centre of what is seen, in world units.
    #[inline]
    pub fn middle(&self, slab_idx: usize) -> f64 {
        self.front(slab_idx) + 0.5 * self.thickness
    }

    /// The first and the last slab that meet the depths `near < far`.
    #[inline]
    pub fn meeting(&self, near: f64, far: f64) -> [usize; 2] {
        let at = |n: i64| (n - self.first).clamp(0, self.n_slabs as i64 - 1) as usize;
        let first = at(floor(near / self.thickness));
        let last = at(-floor(-far / self.thickness) - 1);
        [first, last.max(first)]
    }
}

/// Rounds down. `f64::floor` is a call where the baseline instruction set lacks it.
#[inline]
fn floor(value: f64) -> i64 {
    let towards_zero = value as i64;
    towards_zero - i64::from(value < towards_zero as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slabs_have_a_face_at_the_center() {
        let slabs = SlabGrid::covering([-3.2, 3.2], 0.5).unwrap();
        assert_eq!(slabs.n_slabs(), 14);
        assert_eq!(slabs.front(7), 0.0);
        assert_eq!(slabs.middle(0), -3.25);
    }

    #[test]
    fn slabs_meeting_a_kernel() {
        let slabs = SlabGrid::covering([-4.0, 4.0], 1.0).unwrap();
        assert_eq!(slabs.meeting(-2.0, 2.0), [2, 5], "a voxel on a face");
        assert_eq!(slabs.meeting(-1.5, 2.5), [2, 6]);
        assert_eq!(slabs.meeting(-4.0, 4.0), [0, 7]);
        assert_eq!(
            slabs.meeting(-9.0, 9.0),
            [0, 7],
            "what lies before or behind counts as the ends"
        );
    }

    #[test]
    fn slabs_meet_depths_between_their_faces() {
        for thickness in [0.3, 0.5, 2.0] {
            let slabs = SlabGrid::covering([-7.1, 9.2], thickness).unwrap();
            for slab_idx in 0..slabs.n_slabs() {
                let [front, back] = slabs.faces(slab_idx);
                assert!((back - front - slabs.thickness()).abs() < 1e-12, "{slab_idx}");
            }
            for [near, far] in [[-7.1, 9.2], [-3.3, -0.7], [0.1, 0.2], [1.1, 5.3]] {
                let is_met = |&slab_idx: &usize| {
                    let [front, back] = slabs.faces(slab_idx);
                    front < far && near < back
                };
                let met: Vec<usize> = (0..slabs.n_slabs()).filter(is_met).collect();
                let [first, last] = slabs.meeting(near, far);
                assert_eq!(met, (first..=last).collect::<Vec<_>>(), "{thickness} {near} {far}");
            }
        }
    }

    #[test]
    fn slabs_too_thin_are_refused() {
        let err = SlabGrid::covering([-100.0, 100.0], 1e-9).unwrap_err();
        assert!(err.to_string().contains("more than 4194304"), "{err}");
        let half = f64::from(MAX_SLABS / 2);
        let n_slabs =
            |near: f64| SlabGrid::covering([near, half], 1.0).map(|slabs| slabs.n_slabs());
        assert_eq!(n_slabs(-half), Ok(4_194_304));
        assert!(n_slabs(-half - 1.0).is_err());
        assert!(SlabGrid::covering([-100.0, 100.0], 1e9).is_ok());
    }
}
