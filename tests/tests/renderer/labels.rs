//! Labels (model §13), opacities by gradients and two-dimensional transfer functions (§6): scenes at random
//! by every backend against the float64 reference and against the CPU, at the tolerances of model §9; and
//! labels of another grid, one by one.

use fastrand::Rng;
use slabsplat::glam::DVec3;
use slabsplat::{Compositing, LabelMap, Method, Region, Renderer, Scaling, Scene, Volume};
use slabsplat_seeds::{for_each_numbered_seed, for_each_seed};
use slabsplat_tests::parity::Parity;
use slabsplat_tests::random_scene::{
    SceneKind, add_gradient_opacity, add_labels, add_transfer_2d, random_layers, random_scene,
};
use slabsplat_tests::render::{backends_in_turn, open, render};

/// Of one layer or several, by every method that has labels; some with opacities by gradients or
/// two-dimensional transfer functions, too, and some layers with none of these.
#[test]
fn parity_of_labels() {
    let mut parity = Parity::default();
    for_each_numbered_seed(SceneKind::SHARES, |seed, mut rng| {
        let has_labels = |kind: &SceneKind| kind.method != Method::PostClassified;
        for kind in SceneKind::share(seed).filter(has_labels).step_by(2) {
            // A region's faces decide pixels by their rounding where sums cannot be split.
            let mut scene = random_scene(&mut rng, &kind);
            if kind.method == Method::ImageAligned {
                scene.layers = random_layers(&mut rng, &kind).layers;
                scene.layers.iter_mut().for_each(|layer| layer.region = Region::default());
            }
            if rng.u32(..3) != 0 {
                add_labels(&mut rng, &mut scene);
            }
            if rng.bool() {
                add_gradient_opacity(&mut rng, &mut scene);
            }
            if rng.bool() {
                add_transfer_2d(&mut rng, &mut scene);
            }
            leave_some_by_value(&mut rng, &mut scene);
            parity.check(&mut rng, &kind, &scene);
        }
    });
    println!("{parity}");
}

/// Takes from layers behind the first what makes their voxels differ beside values.
fn leave_some_by_value(rng: &mut Rng, scene: &mut Scene) {
    for layer in &mut scene.layers[1..] {
        if rng.u32(..3) == 0 {
            (layer.labels, layer.gradient_opacity, layer.transfer_2d) = (None, None, None);
        }
    }
}

/// What is cached of labels, of their looks, of a transfer function and of how sheets are summed does not
/// show in the next frame.
#[test]
fn labels_take_turns() {
    for_each_seed(1, |mut rng| {
        let kinds = SceneKind::all().into_iter().filter(|kind| kind.method == Method::ImageAligned);
        for (number, kind) in kinds.step_by(11).enumerate() {
            let plain = random_scene(&mut rng, &kind);
            let mut scenes = vec![plain.clone(), plain.clone(), plain.clone(), plain];
            let [_, labelled, others, restyled] = scenes.as_mut_slice() else { unreachable!() };
            add_labels(&mut rng, labelled);
            add_labels(&mut rng, others);
            let labels = labelled.layers[0].labels.clone().expect("they were added");
            let mut styles = labels.styles().clone();
            styles.values_mut().for_each(|style| style.opacity = 0.0);
            restyled.layers[0].labels = labels.with_styles(styles).ok();
            let mut lighter = scenes[1].clone();
            lighter.layers[0].transfer = random_scene(&mut rng, &kind).layers.remove(0).transfer;
            scenes.push(lighter);
            let mut borders = scenes[rng.usize(..scenes.len())].clone();
            add_gradient_opacity(&mut rng, &mut borders);
            borders.camera = borders.camera.orbited(0.3);
            scenes.push(borders);
            let mut by_both = scenes[rng.usize(..scenes.len())].clone();
            add_transfer_2d(&mut rng, &mut by_both);
            scenes.push(by_both);
            let mut summed = scenes[1].clone();
            summed.settings.mode = Compositing::ALL[rng.usize(..Compositing::ALL.len())].into();
            scenes.push(summed);
            let mut layered = random_layers(&mut rng, &kind);
            add_labels(&mut rng, &mut layered);
            leave_some_by_value(&mut rng, &mut layered);
            scenes.push(layered);
            // The CPU first; the others take longer, where a driver plays them.
            let n_backends = if number % 9 == 0 { 2 } else { 1 };
            for backend in backends_in_turn(kind.method, number / 9).take(n_backends) {
                check_turns(&mut rng, backend, &scenes);
            }
        }
    });
}

/// Draws scenes in any order by one renderer.
fn check_turns(rng: &mut Rng, backend: &str, scenes: &[Scene]) {
    let fresh: Vec<_> = scenes.iter().map(|scene| render(backend, scene)).collect();
    let mut renderer = Renderer::new(open(backend));
    for _ in 0..2 * scenes.len() {
        let turn = rng.usize(..scenes.len());
        let image = renderer.render(&scenes[turn]).expect("the scene is valid").image;
        assert!(image == fresh[turn], "{backend}, turn {turn}");
    }
}

/// A voxel has the label whose voxel is nearest to it, counted in steps along the axes of the labels' grid.
#[test]
fn labels_of_another_grid_are_the_nearest() {
    for_each_seed(20, |mut rng| {
        let kinds = SceneKind::all();
        let [scene, other] = [0; 2].map(|_| {
            let kind = kinds[rng.usize(..kinds.len())];
            random_scene(&mut rng, &kind)
        });
        let (grid, of_labels) = (scene.layers[0].volume.grid(), other.layers[0].volume.grid());
        let labels = (0..of_labels.n_voxels()).map(|idx| idx as u16 + 1).collect::<Vec<_>>();
        let labels = Volume::new(*of_labels, labels.into(), Scaling::IDENTITY).expect("one each");
        let map = LabelMap::new(&labels, grid).expect("labels are whole numbers");
        for voxel_idx in 0..grid.n_voxels() {
            let coords = DVec3::from_array(grid.voxel_coords(voxel_idx).map(|c| c as f64));
            let in_world = grid.world_from_index().transform_point3(coords);
            let point = of_labels.index_from_world().transform_point3(in_world);
            let distance = |idx: usize| {
                let at = DVec3::from_array(of_labels.voxel_coords(idx).map(|c| c as f64));
                (point - at).abs().max_element()
            };
            let all = 0..of_labels.n_voxels();
            let nearest = all.min_by(|&a, &b| distance(a).total_cmp(&distance(b)));
            let nearest = nearest.expect("no grid is empty");
            let expected = if distance(nearest) <= 0.5 { nearest as i64 + 1 } else { 0 };
            let label = map.labels()[usize::from(map.indices()[voxel_idx])];
            assert_eq!(label, expected, "{point}");
        }
    });
}
