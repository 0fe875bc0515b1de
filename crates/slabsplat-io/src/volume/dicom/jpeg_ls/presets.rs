//! What a scan is decoded by: the presets that a stream may have, and what follows from them and from how
//! many bits its samples have (T.87 §C.2.4.1, §A.2.1).

use super::super::segments::Broken;

/// As a stream has them; 0 is for the usual one.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Presets {
    max_value: i32,
    thresholds: [i32; 3],
    reset: i32,
}

/// What is known before the first sample.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Coding {
    /// How far off samples may be.
    pub(super) near: i32,
    /// The largest sample, MAXVAL.
    pub(super) max_value: i32,
    /// From which differences on they count as larger, T1, T2 and T3.
    pub(super) thresholds: [i32; 3],
    /// After how many samples of a kind what is known of them is halved.
    pub(super) reset: i64,
    /// Errors of prediction that differ, RANGE.
    pub(super) range: i32,
    /// Bits of an error that is written as it is, qbpp.
    pub(super) error_bits: u32,
    /// Bits of the longest code, LIMIT.
    pub(super) limit: u32,
}

impl Presets {
    /// Of the segment's data; mapping tables and sizes of more than 16 bits are refused.
    pub(super) fn of(data: &[u8]) -> Result<Self, Broken> {
        let [1, numbers @ ..] = data else { return Err("mapping tables cannot be read") };
        let (numbers, _) = numbers.as_chunks();
        let numbers: Vec<i32> =
            numbers.iter().map(|&pair| i32::from(u16::from_be_bytes(pair))).collect();
        let &[max_value, t1, t2, t3, reset] = numbers.as_slice() else {
            return Err("its presets are broken");
        };
        Ok(Self { max_value, thresholds: [t1, t2, t3], reset })
    }
}

impl Coding {
    /// Of a scan whose samples have so many bits and may be `near` off.
    pub(super) fn of(presets: &Presets, precision: u32, near: i32) -> Result<Self, Broken> {
        const BROKEN: Broken = "its presets are broken";
        let or = |preset: i32, usual: i32| if preset == 0 { usual } else { preset };
        if !(2..=16).contains(&precision) {
            return Err("its samples have fewer than 2 bits, or more than 16");
        }
        let largest = (1 << precision) - 1;
        let max_value = or(presets.max_value, largest);
        if !(1..=largest).contains(&max_value) || (max_value / 2).min(255) < near {
            return Err(BROKEN);
        }
        let usual = usual_thresholds(max_value, near);
        let thresholds = [0, 1, 2].map(|idx| or(presets.thresholds[idx], usual[idx]));
        let reset = or(presets.reset, 64);
        let are_sorted = [&[near + 1][..], &thresholds, &[max_value]].concat().is_sorted();
        if !are_sorted || reset < 3 {
            return Err(BROKEN);
        }
        let range = (max_value + 2 * near) / (2 * near + 1) + 1;
        let bits = |n_values: i32| (n_values - 1).checked_ilog2().map_or(0, |bits| bits + 1);
        let sample_bits = bits(max_value + 1).max(2);
        Ok(Self {
            near,
            max_value,
            thresholds,
            reset: reset.into(),
            range,
            error_bits: bits(range),
            limit: 2 * (sample_bits + sample_bits.max(8)),
        })
    }
}

/// §C.2.4.1.1: for 8 bits and no error they are 3, 7 and 21.
fn usual_thresholds(max_value: i32, near: i32) -> [i32; 3] {
    let mut least = near + 1;
    [(3, 2, 3), (7, 3, 5), (21, 4, 7)].map(|(basic, offset, per_near)| {
        let threshold = if 128 <= max_value {
            let factor = (max_value.min(4095) + 128) / 256;
            factor * (basic - offset) + offset + per_near * near
        } else {
            let factor = 256 / (max_value + 1);
            offset.max(basic / factor + per_near * near)
        };
        if (least..=max_value).contains(&threshold) {
            least = threshold;
        }
        least
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Table C.3 and its text: the usual presets of lossless coding.
    #[test]
    fn usual_presets() {
        let coding = |precision| Coding::of(&Presets::default(), precision, 0).unwrap();
        assert_eq!(coding(8).thresholds, [3, 7, 21]);
        assert_eq!(coding(12).thresholds, [18, 67, 276]);
        assert_eq!(coding(16).thresholds, [18, 67, 276]);
        let Coding { range, error_bits, limit, .. } = coding(8);
        assert_eq!((range, error_bits, limit), (256, 8, 32));
        assert_eq!((coding(16).range, coding(16).limit), (65536, 64));
    }

    #[test]
    fn presets_that_cannot_be() {
        let of = |numbers: [u16; 5]| {
            let data = [vec![1], numbers.map(u16::to_be_bytes).concat()].concat();
            Coding::of(&Presets::of(&data).unwrap(), 8, 0)
        };
        assert!(of([255, 3, 7, 21, 64]).is_ok());
        for numbers in
            [[256, 0, 0, 0, 0], [255, 9, 7, 21, 64], [255, 3, 7, 300, 64], [1, 0, 0, 9, 0]]
        {
            assert_eq!(of(numbers), Err("its presets are broken"), "{numbers:?}");
        }
        assert_eq!(of([255, 3, 7, 21, 2]), Err("its presets are broken"));
        assert!(Coding::of(&Presets::default(), 8, 128).is_err());
        assert!(Presets::of(&[2, 1, 1]).is_err());
        assert!(Presets::of(&[]).is_err());
    }
}
