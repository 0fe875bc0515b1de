//! Simulations that ranks draw (`slabsplat-mpi`): boxes in memory, with ghosts or without, give the picture
//! of the whole, on scenes at random.

#![expect(clippy::unwrap_used, reason = "functions of tests are tests, too")]

use fastrand::Rng;
use slabsplat::backend::{Backend, FramePlan, Planner};
use slabsplat::{FrameHandle, Image, Method, Samples, Scaling, Scene, Volume};
use slabsplat_mpi::{Communicator, Field, InSitu, ThreadRank, Values, VoxelBox};
use slabsplat_seeds::for_each_numbered_seed;
use slabsplat_tests::random_scene::{SceneKind, random_scene};
use slabsplat_tests::render::open;
use std::ops::Range;
use std::time::Duration;

/// What a picture may differ by of which each part is rounded on its own.
const ROUNDED_TWICE: f32 = 1e-5;

const LIMIT: Duration = Duration::from_secs(60);

#[test]
fn in_situ_is_the_whole() {
    let mut worst = 0.0_f32;
    for_each_numbered_seed(2, |seed, mut rng| {
        let kinds = SceneKind::share(seed).filter(|kind| kind.method == Method::ImageAligned);
        for kind in kinds {
            let mut scene = random_scene(&mut rng, &kind);
            scene.settings.opacity_cutoff = 1.0;
            scene.settings.tolerance = [0.0, 0.0, 0.05][rng.usize(..3)];
            scene.layers[0].volume = in_doubles(&scene.layers[0].volume).into();
            let n_ranks = [1, 2, 3, 4, 5, 8][rng.usize(..6)];
            let boxes = random_boxes(&mut rng, scene.layers[0].volume.grid().dims(), n_ranks);
            let off = whole(&scene).max_difference(&by_ranks(&mut rng, &scene, &boxes));
            worst = worst.max(off);
            assert!(off < ROUNDED_TWICE, "{off}: {boxes:?}, {kind:?}");
        }
    });
    println!("off by {worst} at most");
}

/// The same values without a scaling, as simulations have them.
fn in_doubles(volume: &Volume) -> Volume {
    let values: Vec<f64> = (0..volume.grid().n_voxels()).map(|idx| volume.value(idx)).collect();
    Volume::new(*volume.grid(), values.into(), Scaling::IDENTITY).unwrap()
}

/// So many boxes, cut anywhere; some are empty where there are too few voxels.
fn random_boxes(rng: &mut Rng, dims: [usize; 3], n: usize) -> Vec<VoxelBox> {
    let mut boxes = vec![dims.map(|n| 0..n)];
    while boxes.len() < n {
        let idx = rng.usize(..boxes.len());
        let longer: Vec<usize> = (0..3).filter(|axis| 1 < boxes[idx][*axis].len()).collect();
        if longer.is_empty() {
            boxes.push([0..0, 0..0, 0..0]);
            continue;
        }
        let axis = longer[rng.usize(..longer.len())];
        let mut far = boxes[idx].clone();
        let at = rng.usize(far[axis].start + 1..far[axis].end);
        (boxes[idx][axis].end, far[axis].start) = (at, at);
        boxes.push(far);
    }
    rng.shuffle(&mut boxes);
    boxes
}

/// By voxels, as parts are drawn.
fn whole(scene: &Scene) -> Image {
    let mut planner = Planner::default();
    planner.plan_cells(false);
    let plan = planner.plan_for_frame(scene, &FrameHandle::new()).unwrap();
    drawn(&mut *open("cpu"), &plan)
}

fn drawn(backend: &mut dyn Backend, plan: &FramePlan<'_>) -> Image {
    let frame = FrameHandle::new();
    backend.submit(plan, &frame).unwrap();
    backend.wait_image(&frame).unwrap().image
}

/// Each rank has its own box, and around it some voxels more, or none.
fn by_ranks(rng: &mut Rng, scene: &Scene, boxes: &[VoxelBox]) -> Image {
    let volume = &scene.layers[0].volume;
    let grid = *volume.grid();
    let held: Vec<VoxelBox> = boxes
        .iter()
        .map(|own| {
            let n_ghosts = [0, 0, 2, 100][rng.usize(..4)];
            if own.iter().any(Range::is_empty) {
                return own.clone();
            }
            [0, 1, 2].map(|axis| {
                let end = (own[axis].end + n_ghosts).min(grid.dims()[axis]);
                own[axis].start.saturating_sub(n_ghosts)..end
            })
        })
        .collect();
    let pictures = ThreadRank::run(boxes.len(), LIMIT, |comm| {
        let (own, held) = (&boxes[comm.rank()], &held[comm.rank()]);
        let is_empty = held.iter().any(Range::is_empty);
        let samples = if is_empty {
            Vec::<f64>::new().into()
        } else {
            volume.cropped(held).samples().clone()
        };
        let Samples::F64(values) = samples else { panic!("they are doubles") };
        let in_situ = InSitu::new(comm, grid, own).unwrap();
        let field = Field::packed(Values::F64(&values), held.clone()).unwrap();
        let look = |volumes: Vec<_>| {
            let mut scene = scene.clone();
            scene.layers[0].volume = std::sync::Arc::clone(&volumes[0]);
            Ok(scene)
        };
        in_situ.picture(comm, &[field], look).unwrap()
    });
    let mut pictures = pictures.into_iter();
    let picture = pictures.next().flatten().expect("rank 0 has it");
    assert!(pictures.all(|other| other.is_none()));
    picture.frame.image
}
