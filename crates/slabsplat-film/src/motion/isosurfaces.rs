//! Isosurfaces over time: each goes from where it is in one key to where it is in the next.

use super::MotionError;
use super::track::{Moment, Track};
use slabsplat_core::Isosurface;

#[derive(Clone, Debug, PartialEq)]
pub(super) struct IsosurfacePath {
    track: Track,
    /// Of each key, as many, each with a colour in all keys or in none.
    keys: Vec<Vec<Isosurface>>,
}

impl IsosurfacePath {
    /// # Errors
    /// If keys have more surfaces than others, or a colour is in some of them only.
    pub(super) fn new(
        track: Track,
        keys: Vec<Vec<Isosurface>>,
        layer_idx: usize,
    ) -> Result<Self, MotionError> {
        let shape = |key: &Vec<Isosurface>| -> Vec<bool> {
            key.iter().map(|surface| surface.color().is_some()).collect()
        };
        if keys.windows(2).any(|pair| shape(&pair[0]) != shape(&pair[1])) {
            return Err(MotionError::OtherIsosurfaces { layer_idx });
        }
        Ok(Self { track, keys })
    }

    /// # Errors
    /// If numbers do not suffice.
    pub(super) fn at(&self, seconds: f64) -> Result<Vec<Isosurface>, MotionError> {
        let moment = self.track.at(seconds);
        (0..self.keys[0].len()).map(|idx| self.surface(moment, idx)).collect()
    }

    fn surface(&self, moment: Moment, idx: usize) -> Result<Isosurface, MotionError> {
        let number = |of: &dyn Fn(&Isosurface) -> f64| {
            self.track.number(moment, |key| of(&self.keys[key][idx]))
        };
        let has_color = self.keys[0][idx].color().is_some();
        let channel =
            |channel: usize| number(&|surface| surface.color().map_or(0.0, |color| color[channel]));
        let color = has_color.then(|| [0, 1, 2].map(channel));
        Ok(Isosurface::new(number(&Isosurface::value), number(&Isosurface::opacity), color)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::Easing;

    fn path(keys: Vec<Vec<Isosurface>>) -> Result<IsosurfacePath, MotionError> {
        let times = (0..keys.len()).map(|idx| (idx as f64, Easing::Linear));
        IsosurfacePath::new(Track::new(times, false), keys, 0)
    }

    fn surface(value: f64, opacity: f64, color: Option<[f64; 3]>) -> Isosurface {
        Isosurface::new(value, opacity, color).unwrap()
    }

    /// Two that pass each other, and of which one fades.
    #[test]
    fn isosurfaces_move() {
        let first = vec![surface(10.0, 1.0, Some([1.0, 0.0, 0.5])), surface(50.0, 0.5, None)];
        let last = vec![surface(90.0, 0.0, Some([0.0, 1.0, 0.5])), surface(30.0, 0.5, None)];
        let there = path(vec![first.clone(), last.clone()]).unwrap();
        assert_eq!([0.0, 1.0].map(|at| there.at(at).unwrap()), [first, last]);
        let half = vec![surface(50.0, 0.5, Some([0.5; 3])), surface(40.0, 0.5, None)];
        assert_eq!(there.at(0.5).unwrap(), half);
    }

    #[test]
    fn isosurfaces_are_as_many_in_all_keys() {
        let [plain, colored] = [None, Some([0.5; 3])].map(|color| surface(1.0, 1.0, color));
        for other in [vec![], vec![plain, plain], vec![colored]] {
            let error = path(vec![vec![plain], other]).unwrap_err();
            assert_eq!(error, MotionError::OtherIsosurfaces { layer_idx: 0 });
        }
    }
}
