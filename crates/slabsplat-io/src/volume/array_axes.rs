//! Arrays of NumPy and HDF5, which have axes without names: which of them are those of a volume.
//!
//! The last axis is x, as stacks of images have it, and those before it y and z. A fourth axis is time or
//! channel: in front, or at the end if it is short there.

use super::choices::{Part, VolumeChoices, VolumeOptions};
use super::colors::{Meaning, Values};
use super::formats::Input;
use super::placed::Axis;
use super::stored::StoredType;
use crate::IoError;

/// The axes of an array that a volume is made of.
#[derive(Debug, PartialEq)]
pub(super) struct VolumeAxes {
    /// Voxels along x, y and z.
    pub(super) dims: [usize; 3],
    /// All axes, the last first.
    pub(super) axes: Vec<Axis>,
    /// What else there is.
    pub(super) choices: VolumeChoices,
}

/// What an axis is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Role {
    X,
    Y,
    Z,
    Channel,
    Time,
    /// Of one item.
    Single,
}

/// No more colours than these; longer last axes are those of space.
const MAX_LAST_CHANNELS: usize = 4;

impl VolumeAxes {
    /// Of an array of this shape, the slowest axis first, and of such items.
    ///
    /// # Errors
    /// If it has too few axes, too many, or not what is asked for.
    pub(super) fn of(
        input: &Input<'_>,
        shape: &[usize],
        stored: StoredType,
    ) -> Result<Self, IoError> {
        let roles =
            roles(shape, input.options).map_err(|what| IoError::unsupported(input.path, what))?;
        let size = |role: Role| {
            let at = roles.iter().position(|r| *r == role);
            at.map_or(1, |at| shape[at])
        };
        let is_last = roles.last() == Some(&Role::Channel);
        let meaning = if is_last { Meaning::Unsaid } else { Meaning::Other };
        let values = Values { n: size(Role::Channel), stored, meaning };
        let time = input.choose(Part::Time, size(Role::Time))?;
        let choices = VolumeChoices { time, ..input.choose_values(&values)? };
        let dims = [Role::X, Role::Y, Role::Z].map(size);
        let each = choices.n_read();
        let axis = |(&len, role): (&usize, &Role)| match role {
            Role::X => Axis::whole(len, each),
            Role::Y => Axis::whole(len, each.saturating_mul(dims[0])),
            Role::Z => Axis::whole(len, each.saturating_mul(dims[0]).saturating_mul(dims[1])),
            Role::Channel => choices.axis_of_values(),
            Role::Time => Axis::one(len, choices.time.chosen),
            Role::Single => Axis::one(len, 0),
        };
        let axes = shape.iter().zip(&roles).rev().map(axis).collect();
        Ok(Self { dims, axes, choices })
    }

    /// Items of the whole array, of which the volume is a part; `None` if they cannot be counted.
    pub(super) fn n_items(&self) -> Option<u64> {
        self.axes.iter().try_fold(1_u64, |n, axis| n.checked_mul(axis.len as u64))
    }
}

fn roles(shape: &[usize], options: &VolumeOptions) -> Result<Vec<Role>, String> {
    use Role::{Channel, Time, X, Y, Z};
    let asks_for_colors = options.ask_for_colors();
    let asks_for_channel = options.channel.is_some() || asks_for_colors;
    let said = || shape.iter().map(usize::to_string).collect::<Vec<_>>().join(" x ");
    if shape.contains(&0) {
        return Err(format!("the array of {} is empty", said()));
    }
    // Axes in front that have one item, beyond those that have a meaning.
    let n_more = shape.len().saturating_sub(5);
    let n_single = shape.iter().take_while(|&&len| len == 1).count().min(n_more);
    let meant = &shape[n_single..];
    let has_colors = match meant {
        [.., _, _, 3..=MAX_LAST_CHANNELS] if asks_for_colors => true,
        [.., y, x, last] => (2..=MAX_LAST_CHANNELS).contains(last) && MAX_LAST_CHANNELS < *x.min(y),
        _ => false,
    };
    let roles = match (meant.len(), has_colors) {
        (2, _) => vec![Y, X],
        (3, true) if asks_for_channel => vec![Y, X, Channel],
        (3, _) => vec![Z, Y, X],
        (4, true) => vec![Z, Y, X, Channel],
        (4, false) if asks_for_channel => vec![Channel, Z, Y, X],
        (4, false) => vec![Time, Z, Y, X],
        (5, true) => vec![Time, Z, Y, X, Channel],
        (5, false) => vec![Time, Channel, Z, Y, X],
        (n_axes, _) => {
            return Err(format!(
                "an array of {n_axes} axes is no volume: it needs z, y and x, maybe after time and channel"
            ));
        }
    };
    Ok([vec![Role::Single; n_single], roles].concat())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::Store;
    use std::path::Path;

    fn check(
        shape: &[usize],
        channel: Option<usize>,
        time: Option<usize>,
    ) -> Result<String, String> {
        let mut options = VolumeOptions::default();
        (options.channel, options.time) = (channel, time);
        let path = Path::new("a.npy");
        let input = Input { store: Store::Disk, path, options: &options, spill: None };
        let axes =
            VolumeAxes::of(&input, shape, StoredType::F16).map_err(|error| error.to_string())?;
        let [x, y, z] = axes.dims;
        let picked = axes.axes.iter().filter(|axis| axis.kept.len() == 1 && axis.len != 1);
        let picked: String = picked.map(|axis| format!(" {}", axis.kept.start)).collect();
        let VolumeChoices { channel, time, .. } = axes.choices;
        Ok(format!("{x} {y} {z}{picked} of {} {}", channel.n, time.n))
    }

    #[test]
    fn array_axes_by_shape() {
        for (shape, channel, time, expected) in [
            (&[5, 6, 7][..], None, None, "7 6 5 of 1 1"),
            (&[6, 7], None, None, "7 6 1 of 1 1"),
            (&[9, 5, 6, 7], None, None, "7 6 5 0 of 1 9"),
            (&[9, 5, 6, 7], None, Some(8), "7 6 5 8 of 1 9"),
            (&[9, 5, 6, 7], Some(2), None, "7 6 5 2 of 9 1"),
            (&[5, 6, 7, 3], Some(2), None, "7 6 5 2 of 3 1"),
            (&[5, 6, 7, 3], None, None, "7 6 5 0 of 3 1"),
            (&[6, 7, 3], Some(1), None, "7 6 1 1 of 3 1"),
            (&[6, 7, 3], None, None, "3 7 6 of 1 1"),
            (&[2, 3, 5, 6, 7], Some(2), Some(1), "7 6 5 2 1 of 3 2"),
            (&[2, 5, 6, 7, 3], Some(2), Some(1), "7 6 5 2 1 of 3 2"),
            (&[1, 1, 1, 5, 6, 7], None, None, "7 6 5 of 1 1"),
        ] {
            assert_eq!(check(shape, channel, time).as_deref(), Ok(expected), "{shape:?}");
        }
    }

    #[test]
    fn array_axes_that_are_no_volume() {
        for (shape, channel, time, expected) in [
            (&[][..], None, None, "0 axes"),
            (&[8], None, None, "1 axes is no volume"),
            (&[2, 2, 2, 5, 6, 7], None, None, "6 axes"),
            (&[5, 0, 7], None, None, "empty"),
            (&[5, 6, 7], Some(1), None, "no channel 1"),
            (&[5, 6, 7], None, Some(3), "no time 3"),
            (&[9, 5, 6, 7], None, Some(9), "no time 9"),
        ] {
            let error = check(shape, channel, time).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
    }
}
