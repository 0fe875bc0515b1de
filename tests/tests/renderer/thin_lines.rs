//! Thin structures do not bead: a line as wide as a voxel, at any angle and from any side, is as opaque and
//! as bright all along.

use slabsplat::glam::DVec3;
use slabsplat::{
    Camera, Grid, ImageDesc, Layer, Method, Phong, Projection, RenderSettings, Samples, Scaling,
    Scene, Shading, TransferFunction, Volume,
};
use slabsplat_seeds::for_each_seed;
use slabsplat_tests::render::render;

/// Voxels along a side of the volume.
const N_VOXELS: usize = 40;

/// Pixels to a voxel.
const ZOOM: f64 = 8.0;

/// Of the picture: 28 voxels, so that no end of the line is in it.
const SIDE: u32 = 224;

/// How a line of the width of a voxel looks, in voxels: a variance of 1/16, blurred by half a voxel. Samples
/// of what is thinner do not say what lies between them.
const SIGMA: f64 = 0.56;

/// By how much of its mean the extinction of a line may be more or less along it.
const MOST_UNEVEN: f64 = 0.03;

/// The same of its light, which follows gradients: between samples they are known less well than values.
const MOST_UNEVEN_LIGHT: f64 = 0.15;

#[test]
fn lines_do_not_bead() {
    for_each_seed(1, |mut rng| {
        let mut worst = [0.0_f64; 2];
        for _ in 0..20 {
            let along = direction(&mut rng);
            let volume = line(along, [0; 3].map(|_| rng.f64()).into());
            let from = along.cross(direction(&mut rng)).normalize();
            let slab_width = [0.6, 1.0, 1.5][rng.usize(..3)];
            let settings =
                RenderSettings::default().method(Method::PostClassified).slab_width(slab_width);
            let of_line = unevenness(volume, along, from, settings);
            println!("{along:.2} from {from:.2}, w {slab_width}: {of_line:.3?}");
            let [extinction, light] = of_line;
            assert!(extinction < MOST_UNEVEN && light < MOST_UNEVEN_LIGHT, "{of_line:?}");
            worst = [0, 1].map(|idx| worst[idx].max(of_line[idx]));
        }
        println!("extinction and light differ by up to {worst:.3?} along lines");
    });
}

/// A line of density that goes past the middle of the volume.
fn line(along: DVec3, offset: DVec3) -> Volume {
    let grid = Grid::with_spacing([N_VOXELS; 3], [1.0; 3]).expect("the grid is not empty");
    let value = |idx: usize| {
        let at = DVec3::from_array(grid.voxel_coords(idx).map(|c| c as f64)) - middle() - offset;
        let squared = at.length_squared() - at.dot(along).powi(2);
        (200.0 * (-squared / (2.0 * SIGMA * SIGMA)).exp()) as f32
    };
    let samples = Samples::F32((0..grid.n_voxels()).map(value).collect());
    Volume::new(grid, samples, Scaling::IDENTITY).expect("one sample a voxel")
}

fn middle() -> DVec3 {
    DVec3::splat(0.5 * (N_VOXELS - 1) as f64)
}

fn direction(rng: &mut fastrand::Rng) -> DVec3 {
    loop {
        let at = DVec3::from([0; 3].map(|_| 2.0 * rng.f64() - 1.0));
        if (0.1..1.0).contains(&at.length()) {
            return at.normalize();
        }
    }
}

/// By how much of their mean the sums of extinction and of light across the line differ along it, which runs
/// upwards in the picture.
fn unevenness(volume: Volume, along: DVec3, from: DVec3, settings: RenderSettings) -> [f64; 2] {
    let projection = Projection::Orthographic { view_height: f64::from(SIDE) / ZOOM };
    let camera = Camera::new(middle() + 100.0 * from, middle(), along, projection);
    let opacity = vec![(10.0, [0.0]), (200.0, [0.6])];
    let transfer = TransferFunction::new(opacity, vec![(0.0, [1.0; 3])]).expect("it rises");
    let layer = Layer::new(volume, transfer).shading(Shading::Phong(Phong::default()));
    let scene = Scene::new(layer, camera.expect("it looks across the line"))
        .image(ImageDesc::new(SIDE, SIDE))
        .settings(settings);
    let image = render("cpu", &scene);
    let sum = |of: &dyn Fn([f32; 4]) -> f64, y: u32| -> f64 {
        (0..SIDE).map(|x| of(image.pixel(x, y))).sum()
    };
    let uneven = |of: &dyn Fn([f32; 4]) -> f64| {
        let rows = (0..SIDE).map(|y| sum(of, y));
        let [lo, hi] = rows.fold([f64::INFINITY, 0.0], |[lo, hi], row| [row.min(lo), row.max(hi)]);
        (hi - lo) / (hi + lo)
    };
    [uneven(&|pixel| -f64::from(1.0 - pixel[3]).ln()), uneven(&|pixel| pixel[0].into())]
}
