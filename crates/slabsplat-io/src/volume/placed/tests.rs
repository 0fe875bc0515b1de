//! Against a loop over every item of an array.

use super::*;
use slabsplat_seeds::for_each_seed;

fn placed(stored: StoredType, axes: &[Axis], bytes: &[u8], n_voxels: usize) -> Samples {
    let mut samples = PlacedSamples::new(stored, Endian::Big, n_voxels).ok().unwrap();
    samples.place(&mut &bytes[..], axes, 0).ok().unwrap();
    samples.finish(&mut Vec::new())
}

/// Against a loop over every item of the array.
#[test]
fn placed_is_what_a_loop_does() {
    const TYPES: &[(StoredType, usize)] = &[
        (StoredType::Sample(SampleType::U8), 1),
        (StoredType::Sample(SampleType::I16), 2),
        (StoredType::I64, 8),
    ];
    for_each_seed(200, |mut rng| {
        let lens: Vec<usize> = (0..4).map(|_| rng.usize(1..6)).collect();
        let mut order = [0, 1, 2, 3];
        rng.shuffle(&mut order);
        let n_axes = rng.usize(0..=4);
        // The volume has some of the axes in an order of its own; of the others one item is taken.
        let mut axes: Vec<Axis> =
            lens.iter().map(|&len| Axis::one(len, rng.usize(0..len))).collect();
        let mut stride = 1;
        for &axis_idx in &order[..n_axes] {
            let len = lens[axis_idx];
            let start = rng.usize(0..len);
            let kept = start..rng.usize(start + 1..=len);
            axes[axis_idx] = Axis { len, kept: kept.clone(), stride };
            stride *= kept.len();
        }
        let n_items: usize = lens.iter().product();
        let values: Vec<u8> = (0..n_items).map(|_| rng.u8(..128)).collect();
        let mut expected = vec![0; stride];
        for (item, &value) in values.iter().enumerate() {
            let mut rest = item;
            let mut at = Some(0);
            for axis in &axes {
                let idx = rest % axis.len;
                rest /= axis.len;
                at = at.filter(|_| axis.kept.contains(&idx));
                at = at.map(|at| at + (idx - axis.kept.start) * axis.stride);
            }
            if let Some(at) = at {
                expected[at] = value;
            }
        }
        let (stored, n_bytes) = TYPES[rng.usize(0..TYPES.len())];
        let wide = |value: &u8| [vec![0; n_bytes - 1], vec![*value]].concat();
        let bytes: Vec<u8> = values.iter().flat_map(wide).collect();
        let samples = placed(stored, &axes, &bytes, stride);
        let got: Vec<u8> =
            with_samples!(&samples, |s| s.iter().map(|v| Sample::to_f64(*v) as u8).collect());
        assert_eq!(got, expected, "{axes:?}");
    });
}

#[test]
fn placed_reads_far_groups_and_long_runs() {
    let n_each = CHUNK_BYTES + 3;
    let bytes: Vec<u8> = (0..3 * n_each).map(|at| (at % 251) as u8).collect();
    let axes = [Axis::one(n_each, 5), Axis::whole(3, 1)];
    let expected = [5, n_each + 5, 2 * n_each + 5].map(|at| (at % 251) as u8);
    let u8 = StoredType::Sample(SampleType::U8);
    assert_eq!(placed(u8, &axes, &bytes, 3), Samples::U8(expected.to_vec()));
    let all = placed(u8, &[Axis::whole(3 * n_each, 1)], &bytes, 3 * n_each);
    assert_eq!(all, Samples::U8(bytes));
}

#[test]
fn placed_notices_the_end() {
    let mut samples = PlacedSamples::new(StoredType::F16, Endian::Little, 4).ok().unwrap();
    let failure = samples.place(&mut &[0; 7][..], &[Axis::whole(4, 1)], 0);
    assert!(matches!(failure, Err(ReadFailure::TooShort(7))));
}
