//! Rows of bits, and which voxels rules leave visible, against the definition a voxel at a time.

use super::*;
use crate::naive_normals::naive_gradient;
use slabsplat_core::{
    Grid, LabelMap, LabelStyle, Labels, PiecewiseLinear, Samples, Scaling, TransferBox,
    TransferFunction, TransferFunction2d,
};
use slabsplat_seeds::for_each_seed;

const DIMS: [usize; 3] = [13, 9, 10];

fn grid() -> Grid {
    Grid::with_spacing(DIMS, [0.8, 1.5, 1.1]).unwrap()
}

fn random_volume(rng: &mut fastrand::Rng) -> Volume {
    let samples: Vec<f64> = (0..grid().n_voxels()).map(|_| 100.0 * rng.f64()).collect();
    Volume::new(grid(), Samples::F64(samples), Scaling { slope: -0.5, intercept: 80.0 }).unwrap()
}

/// Between two values.
fn showing([lo, hi]: [f64; 2]) -> TransferFunction {
    let opacity = [(lo, 0.0), (0.5 * (lo + hi), 0.6), (hi, 0.0)];
    TransferFunction::new(opacity, [(0.0, [1.0; 3])]).unwrap()
}

/// Label 1 is invisible, 2 has a transfer function of its own, and 0 and 3 show what the layer does.
fn labels(rng: &mut fastrand::Rng, own: &TransferFunction) -> Labels {
    let of_voxels: Vec<u8> = (0..grid().n_voxels()).map(|_| rng.u8(..4)).collect();
    let of_voxels = Volume::new(grid(), Samples::U8(of_voxels), Scaling::IDENTITY).unwrap();
    let map = LabelMap::new(&of_voxels, &grid()).unwrap();
    let invisible = LabelStyle::default().opacity(0.0);
    let other = LabelStyle::default().transfer(own.clone());
    Labels::new(map, [(1, invisible), (2, other)]).unwrap()
}

/// model §§6, 13, a voxel at a time.
fn is_visible(rules: &VoxelRules<'_>, volume: &Volume, voxel_idx: usize) -> bool {
    let value = volume.value(voxel_idx);
    let gradient = naive_gradient(volume, voxel_idx).length() * volume.grid().unit();
    let style = rules.labels.map(|labels| {
        let label = labels.map().labels()[usize::from(labels.map().indices()[voxel_idx])];
        labels.style(label)
    });
    if style.is_some_and(|style| style.opacity == 0.0) {
        return false;
    }
    let opacity = match (style.and_then(|style| style.transfer.as_ref()), rules.transfer_2d) {
        (Some(own), _) => own.opacity(value),
        (None, Some(transfer_2d)) => transfer_2d.opacity(value, gradient),
        (None, None) => rules.transfer.opacity(value),
    };
    0.0 < opacity && rules.gradient_opacity.is_none_or(|factor| 0.0 < factor.at(gradient)[0])
}

#[test]
fn visible_voxels_are_those_of_the_rules() {
    for_each_seed(20, |mut rng| {
        let volume = random_volume(&mut rng);
        let [transfer, own] = [showing([40.0, 62.0]), showing([55.0, 75.0])];
        let labels = labels(&mut rng, &own);
        let box_of = TransferBox::new([45.0, 70.0], [8.0, 20.0]).unwrap().opacity(0.4);
        let transfer_2d = TransferFunction2d::Boxes(vec![box_of.unwrap()]);
        let factor = PiecewiseLinear::new("gradient", [(9.0, 0.0), (30.0, 1.0)]).unwrap();
        let by_value = VoxelRules::by_value(&transfer);
        for rules in [
            VoxelRules { labels: Some(&labels), ..by_value },
            VoxelRules { transfer_2d: Some(&transfer_2d), ..by_value },
            VoxelRules { gradient_opacity: Some(&factor), ..by_value },
            VoxelRules {
                labels: Some(&labels),
                transfer_2d: Some(&transfer_2d),
                gradient_opacity: Some(&factor),
                ..by_value
            },
        ] {
            check_bricks(&volume, &rules);
        }
    });
}

fn check_bricks(volume: &Volume, rules: &VoxelRules<'_>) {
    let Samples::F64(samples) = volume.samples() else { unreachable!() };
    let grid = BrickGrid::new(volume.grid());
    // With labels of several transfer functions, what is left to them.
    let ranges = match (rules.labels, rules.transfer_2d) {
        (Some(_), _) => vec![IsoRange { lo: f64::NEG_INFINITY, hi: f64::INFINITY }],
        (None, Some(transfer_2d)) => transfer_2d.iso_ranges(),
        (None, None) => rules.transfer.iso_ranges(),
    };
    let membership = Membership::new(volume, samples, grid, &ranges, Some(rules));
    let mut n_visible = 0;
    for brick_idx in 0..grid.n_bricks() as u32 {
        let mask = membership.of_brick(brick_idx, 0..ranges.len());
        let origin = grid.origin(brick_idx);
        let [x_size, y_size, z_size] = grid.size_at(origin);
        for slot in 0..BRICK_SIDE.pow(3) {
            let [x, y, z] =
                [slot % BRICK_SIDE, slot / BRICK_SIDE % BRICK_SIDE, slot / BRICK_SIDE.pow(2)];
            let is_there = x < x_size && y < y_size && z < z_size;
            let coords = [origin[0] + x, origin[1] + y, origin[2] + z];
            let expected = is_there && is_visible(rules, volume, volume.grid().voxel_idx(coords));
            assert_eq!(mask.has(slot as u16), expected, "{coords:?} by {rules:?}");
            n_visible += usize::from(expected);
        }
    }
    assert!((20..1000).contains(&n_visible), "{n_visible} of 1,170 by {rules:?}");
}

#[test]
fn row_mask_has_a_bit_a_voxel() {
    let row = [9_u8, 1, 5, 200, 5, 0, 77, 6];
    let ranges = [[5, 9], [77, 255]];
    assert_eq!(row_mask(&row, &ranges), 0b1101_1101);
    assert_eq!(short_row_mask(&row[..4], &ranges), 0b1101);
    assert_eq!(row_mask(&[f32::NAN; 8], &[[f32::NEG_INFINITY, f32::INFINITY]]), 0);
}

#[test]
fn brick_mask_has_the_places_of_records() {
    let slots = [0, 1, 9, 63, 64, 510, 511];
    let records = slots.map(|slot| VoxelRecord { slot, ..VoxelRecord::default() });
    let mask = BrickMask::of_records(&records);
    assert!((0..512).filter(|&slot| mask.has(slot)).eq(slots));
    assert_eq!((mask.count(), BrickMask::ALL.count()), (7, 512));
}
