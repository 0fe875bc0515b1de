//! The stages before splatting, on a ball of noise in 128³ voxels of which 40 % are relevant.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use slabsplat_core::glam::DVec3;
use slabsplat_core::{
    BlinnPhong, Camera, Compositing, FrameHandle, Grid, ImageDesc, Light, Phong, Projection,
    Scaling, TransferFunction, View, Volume,
};
use slabsplat_traverse::{
    BlinnPhong8, BrickRanges, BrickView, Classification, DepthOrder, RelevantList, TileBuckets,
    TileGrid, TileRect, VoxelLighting, VoxelRules,
};

const SIDE: usize = 128;

fn noisy_ball() -> Volume {
    let mut rng = fastrand::Rng::with_seed(1);
    let grid = Grid::with_spacing([SIDE; 3], [1.0; 3]).expect("the grid is not empty");
    let center = grid.center_in_index();
    let samples: Vec<u8> = (0..grid.n_voxels())
        .map(|idx| {
            let at = DVec3::from_array(grid.voxel_coords(idx).map(|c| c as f64));
            let inside = at.distance(center) < 0.46 * SIDE as f64;
            if inside { rng.u8(100..) } else { rng.u8(..40) }
        })
        .collect();
    Volume::new(grid, samples.into(), Scaling::IDENTITY).expect("one sample a voxel")
}

fn stages(c: &mut Criterion) {
    let volume = noisy_ball();
    let grid = volume.grid();
    let transfer = TransferFunction::new(
        vec![(90.0, [0.0]), (255.0, [0.8])],
        vec![(0.0, [0.5; 3]), (255.0, [1.0; 3])],
    )
    .expect("the points are sorted");
    let brick_ranges = BrickRanges::new(&volume);
    let mut list = RelevantList::default();
    list.update(&volume, &brick_ranges, &transfer.iso_ranges(), None);

    let target = grid.center_in_world();
    let projection = Projection::Orthographic { view_height: 1.5 * SIDE as f64 };
    let eye = target + DVec3::new(300.0, 200.0, 100.0);
    let camera = Camera::new(eye, target, DVec3::Z, projection).expect("the eye is off the axis");
    let view = View::new(grid, &camera, &ImageDesc::default()).expect("the view fits");

    let mut group = c.benchmark_group("traverse");
    group.throughput(Throughput::Elements(grid.n_voxels() as u64));
    group.bench_function("brick_ranges", |b| b.iter(|| BrickRanges::new(&volume)));

    group.throughput(Throughput::Elements(list.len() as u64));
    group.bench_function("relevant_list", |b| {
        b.iter(|| {
            RelevantList::default().update(&volume, &brick_ranges, &transfer.iso_ranges(), None)
        });
    });
    let mut narrower = transfer.iso_ranges();
    narrower[0].lo += 10.0;
    group.bench_function("relevant_list_update", |b| {
        let mut list = list.clone();
        b.iter(|| {
            list.update(&volume, &brick_ranges, &narrower, None);
            list.update(&volume, &brick_ranges, &transfer.iso_ranges(), None)
        });
    });
    let rules = VoxelRules::by_value(&transfer);
    let classification = Classification::new(&rules, Compositing::Extinction, &volume);
    let light = BlinnPhong::new(Phong::default(), &[Light::default()], view.axes().forward);
    let light8 = BlinnPhong8::new(&light);
    let lighting = VoxelLighting::new(&classification, &volume, rules, Some(&light8));
    let mut colors = Vec::new();
    group.bench_function("shade", |b| b.iter(|| lighting.shade(&list, &mut colors)));
    let mut points = Vec::new();
    group.bench_function("project", |b| {
        b.iter(|| BrickView::new(grid, &view).project(&list, &mut points));
    });
    let mut order = DepthOrder::default();
    let frame = FrameHandle::new();
    group.bench_function("depth_order", |b| b.iter(|| order.update(grid, &view, &list, &frame)));

    let tiles = TileGrid::new(view.image_size(), 16, 0);
    let rect_of = |splat: usize| {
        let [right, up, _] = points[splat];
        let at = [256.0 + 2.6 * right, 256.0 - 2.6 * up];
        let pixels = tiles.pixels_within(at.map(|c| c - 5.2), at.map(|c| c + 5.2));
        pixels.map_or(TileRect::EMPTY, |pixels| tiles.tiles_of(&pixels))
    };
    let mut buckets = TileBuckets::default();
    group.bench_function("toss", |b| {
        b.iter(|| buckets.toss(&tiles, points.len(), rect_of, &frame));
    });
    group.finish();
}

criterion_group!(benches, stages);
criterion_main!(benches);
