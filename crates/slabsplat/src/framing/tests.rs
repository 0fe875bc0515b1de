//! What is on which side of a picture, and how much of the picture is filled.

use super::*;
use slabsplat_core::glam::{DAffine3, DMat3};
use slabsplat_core::{Grid, Orientation, TransferFunction, View, Volume};

/// A layer that shows what is not 0.
fn layer(grid: Grid, is_set: impl Fn([usize; 3]) -> bool) -> Layer {
    let volume = Volume::from_fn(grid, |voxel| u8::from(is_set(voxel)) * 255);
    let transfer = TransferFunction::new([(100.0, 0.0), (200.0, 0.9)], [(0.0, [1.0; 3])]).unwrap();
    Layer::new(volume, transfer)
}

/// Where a point of the world is in the picture, from −1 at its left and lower edges to 1.
fn seen(grid: &Grid, camera: &Camera, image: &ImageDesc, point: DVec3) -> [f64; 2] {
    let view = View::new(grid, camera, image).unwrap();
    let at = view.from_index(grid).transform(grid.index_from_world().transform_point3(point));
    let scale = view.pixels_per_world(at.z);
    [at.x * scale / (0.5 * f64::from(image.width)), at.y * scale / (0.5 * f64::from(image.height))]
}

const SQUARE: ImageDesc = ImageDesc::new(100, 100);

/// Corners of the world that are marked, and in which quarter of the picture each must be.
fn check_quarter(
    orientation: Orientation,
    viewpoint: Viewpoint,
    point: [f64; 3],
    quarter: [f64; 2],
) {
    // Stored as scanners store: x to the left, y to the back; the world is that of the orientation.
    let flip = DAffine3::from_mat3_translation(
        DMat3::from_diagonal(DVec3::new(-1.0, -1.0, 2.0)),
        DVec3::new(10.0, 12.0, -14.0),
    );
    let grid = Grid::new([21, 25, 15], flip).unwrap();
    let facing = Facing::of(orientation, &grid);
    let only = layer(grid, |_| true);
    let framing = Framing::new(&[only], &[], Mode::Extinction, facing);
    for is_perspective in [false, true] {
        let projection = usual_projection(is_perspective);
        let camera = framing.camera(Some(viewpoint), Fit::Visible, projection, &SQUARE).unwrap();
        let at = seen(&grid, &camera, &SQUARE, DVec3::from_array(point) * 8.0);
        let is_there = (0..2).all(|axis| 0.2 < at[axis] * quarter[axis]);
        assert!(is_there, "{orientation:?} {viewpoint} {is_perspective}: {point:?} at {at:?}");
    }
}

/// A body has its right, its front and its head at +x, +y and +z.
#[test]
fn framing_of_a_body_from_all_sides() {
    let body = Orientation::Anatomical;
    // The right of who looks at us is on our left.
    check_quarter(body, Viewpoint::Front, [1.0, 1.0, 1.0], [-1.0, 1.0]);
    check_quarter(body, Viewpoint::Back, [1.0, -1.0, 1.0], [1.0, 1.0]);
    // Who stands on its left sees its front on the left.
    check_quarter(body, Viewpoint::Left, [-1.0, 1.0, -1.0], [-1.0, -1.0]);
    check_quarter(body, Viewpoint::Right, [1.0, 1.0, 1.0], [1.0, 1.0]);
    check_quarter(body, Viewpoint::Top, [1.0, 1.0, 1.0], [1.0, 1.0]);
    check_quarter(body, Viewpoint::Bottom, [1.0, 1.0, -1.0], [-1.0, 1.0]);
}

/// Pictures lie one behind the other, with their rows from above to below.
#[test]
fn framing_of_pictures_from_all_sides() {
    let pictures = Orientation::Pictures;
    check_quarter(pictures, Viewpoint::Front, [1.0, 1.0, -1.0], [1.0, -1.0]);
    check_quarter(pictures, Viewpoint::Right, [1.0, 1.0, 1.0], [1.0, -1.0]);
    check_quarter(pictures, Viewpoint::Top, [1.0, -1.0, 1.0], [1.0, 1.0]);
}

/// As in drawings: from the front x goes to the right, from above y goes upwards.
#[test]
fn framing_of_the_unknown_from_all_sides() {
    let grid = Grid::centered([9, 9, 9], [1.0; 3]).unwrap();
    let facing = Facing::of(Orientation::Unknown, &grid);
    let check = |viewpoint, to_eye: [f64; 3], up: [f64; 3]| {
        let [eye, top] = facing.seen_from(viewpoint);
        let is_it = eye.abs_diff_eq(to_eye.into(), 1e-9) && top.abs_diff_eq(up.into(), 1e-9);
        assert!(is_it, "{viewpoint}: {eye}, {top}");
    };
    check(Viewpoint::Front, [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]);
    check(Viewpoint::Back, [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    check(Viewpoint::Right, [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    check(Viewpoint::Left, [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    check(Viewpoint::Top, [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]);
    check(Viewpoint::Bottom, [0.0, 0.0, -1.0], [0.0, -1.0, 0.0]);
    let third = 1.0 / 3_f64.sqrt();
    check(Viewpoint::Iso, [third, -third, third], [0.0, 0.0, 1.0]);
}

/// A cone that is cut off by the grid at its wide end stands on that end; a ball in the middle does not turn.
#[test]
fn framing_stands_things_on_the_end_that_is_cut() {
    let grid = Grid::centered([24, 24, 24], [1.0; 3]).unwrap();
    let facing = Facing::of(Orientation::Unknown, &grid);
    let top = |is_set: &dyn Fn([usize; 3]) -> bool| {
        let only = layer(grid, is_set);
        Framing::new(&[only], &[], Mode::Extinction, facing).facing().top()
    };
    let from_axis = |[x, y, _]: [usize; 3]| (x as f64 - 11.5).hypot(y as f64 - 11.5);
    assert_eq!(top(&|voxel| 2.0 * from_axis(voxel) < voxel[2] as f64), DVec3::NEG_Z);
    assert_eq!(top(&|voxel| 2.0 * from_axis(voxel) < 23.0 - voxel[2] as f64), DVec3::Z);
    assert_eq!(top(&|voxel| from_axis(voxel).hypot(voxel[2] as f64 - 11.5) < 7.0), DVec3::Z);
    let body = Facing::of(Orientation::Anatomical, &grid);
    let only = layer(grid, |voxel| 2.0 * from_axis(voxel) < voxel[2] as f64);
    let framing = Framing::new(&[only], &[], Mode::Extinction, body);
    assert_eq!(framing.facing().top(), DVec3::Z, "the file knows better");
}

/// What is visible is a small box in a corner of the grid: it fills 95 % of the side that is short for it.
#[test]
fn framing_fills_the_picture_with_what_is_visible() {
    let shear = DMat3::from_cols(DVec3::X, DVec3::new(0.3, 1.2, 0.0), DVec3::NEG_Z * 3.0);
    let grid = Grid::new([40, 30, 16], DAffine3::from_mat3(shear)).unwrap();
    let is_set = |[x, y, z]: [usize; 3]| x < 9 && (3..12).contains(&y) && 10 < z;
    let only = layer(grid, is_set);
    let set = (0..grid.n_voxels()).map(|idx| grid.voxel_coords(idx)).filter(|voxel| is_set(*voxel));
    let set: Vec<DVec3> = set
        .map(|voxel| DVec3::from_array(voxel.map(|c| c as f64)))
        .map(|voxel| grid.world_from_index().transform_point3(voxel))
        .collect();
    let facing = Facing::of(Orientation::Unknown, &grid);
    let framing = Framing::new(&[only], &[], Mode::Extinction, facing);
    for [width, height] in [[100, 100], [200, 50], [50, 200]] {
        let image = ImageDesc::new(width, height);
        for (is_perspective, viewpoint) in [
            (false, None),
            (true, None),
            (false, Some(Viewpoint::Left)),
            (true, Some(Viewpoint::Top)),
        ] {
            let projection = usual_projection(is_perspective);
            let camera = framing.camera(viewpoint, Fit::Visible, projection, &image).unwrap();
            let farthest = |fit: &Camera| {
                let at = set.iter().map(|&point| seen(&grid, fit, &image, point));
                at.fold(0.0, |far: f64, [x, y]| far.max(x.abs()).max(y.abs()))
            };
            let text = format!("{width}x{height} {is_perspective} {viewpoint:?}");
            // Kernels are seen half a voxel and a little beyond the last middle.
            let filled = farthest(&camera);
            assert!((0.7..0.95).contains(&filled), "{text}: {filled}");
            let whole = framing.camera(viewpoint, Fit::Volume, projection, &image).unwrap();
            let corners = grid.corners_in_world().map(|point| seen(&grid, &whole, &image, point));
            let filled = corners.fold(0.0, |far: f64, [x, y]| far.max(x.abs()).max(y.abs()));
            assert!((0.8..0.95).contains(&filled), "{text}, all of it: {filled}");
        }
    }
}

/// Haze that takes 2 % of the light from a ray is no reason to make what matters small.
#[test]
fn framing_passes_over_haze() {
    let grid = Grid::centered([40, 40, 40], [1.0; 3]).unwrap();
    let volume = Volume::from_fn(grid, |voxel| match voxel.iter().all(|c| (15..25).contains(c)) {
        true => 255,
        false => 1_u8,
    });
    let transfer =
        TransferFunction::new([(0.0, 0.0), (1.0, 5e-4), (255.0, 0.9)], [(0.0, [1.0; 3])]).unwrap();
    let only = Layer::new(volume, transfer);
    let framing = Framing::new(&[only], &[], Mode::Extinction, Facing::default());
    let projection = usual_projection(false);
    let camera = framing.camera(Some(Viewpoint::Front), Fit::Visible, projection, &SQUARE).unwrap();
    let Projection::Orthographic { view_height } = camera.projection() else { panic!("parallel") };
    assert!((10.0..13.0).contains(&view_height), "{view_height}");
}

#[test]
fn framing_of_nothing_is_that_of_the_grid() {
    let grid = Grid::centered([1, 1, 1], [1.0; 3]).unwrap();
    for is_set in [false, true] {
        let only = layer(grid, |_| is_set);
        let framing = Framing::new(&[only], &[], Mode::Extinction, Facing::default());
        for is_perspective in [false, true] {
            let projection = usual_projection(is_perspective);
            let camera = framing.camera(None, Fit::Visible, projection, &SQUARE).unwrap();
            let at = seen(&grid, &camera, &SQUARE, DVec3::ZERO);
            assert!(at[0].abs() < 1e-6 && at[1].abs() < 1e-6, "{is_set} {is_perspective}: {at:?}");
        }
    }
}

#[test]
fn framing_aims_anew_and_fills_the_picture_only_where_it_is_found() {
    let grid = Grid::centered([10, 20, 40], [1.0; 3]).unwrap();
    let only = layer(grid, |_| true);
    let framing = Framing::new(&[only], &[], Mode::Extinction, Facing::default());
    let given = Camera::new(
        DVec3::new(0.0, -90.0, 3.0),
        DVec3::new(0.0, 0.0, 3.0),
        DVec3::Z,
        Projection::Orthographic { view_height: 7.0 },
    )
    .unwrap();
    let height = |camera: &Camera| match camera.projection() {
        Projection::Orthographic { view_height } => view_height,
        Projection::Perspective { .. } => panic!("it is parallel"),
    };
    let turned = Aim::default().azimuth_degrees(90.0);
    let kept = framing.aimed(&given, &turned, false, &SQUARE).unwrap();
    assert_eq!((height(&kept), kept.target()), (7.0, given.target()));
    assert!(kept.eye().abs_diff_eq(DVec3::new(90.0, 0.0, 3.0), 1e-9), "{}", kept.eye());
    for (aim, refits) in [(turned, true), (turned.fit(Fit::Visible), false)] {
        let filled = framing.aimed(&given, &aim, refits, &SQUARE).unwrap();
        assert!((40.0..44.0).contains(&height(&filled)), "{}", height(&filled));
        assert!(filled.target().length() < 1.0, "{}", filled.target());
    }
    let top = Aim::default().viewpoint(Viewpoint::Top);
    let above = framing.aimed(&given, &top, false, &SQUARE).unwrap();
    assert_eq!((height(&above), above.eye()), (7.0, DVec3::new(0.0, 0.0, 93.0)));
    assert_eq!(framing.aimed(&given, &Aim::default(), true, &SQUARE), Ok(given));
}

/// A rod that is off the middle of its grid, seen from the side and a little from above while it turns.
#[test]
fn framing_around_holds_all_angles() {
    let grid = Grid::centered([40, 40, 20], [1.0; 3]).unwrap();
    let is_rod = |[x, y, z]: [usize; 3]| {
        (4..30).contains(&x) && (20..24).contains(&y) && (3..9).contains(&z)
    };
    let only = layer(grid, is_rod);
    let facing = Facing::of(Orientation::Unknown, &grid);
    let framing = Framing::new(&[only], &[], Mode::Extinction, facing);
    let ends = [0, 1].map(|end| {
        let voxel = |which: usize| [[4.0, 20.0, 3.0], [29.0, 23.0, 8.0]][end][which];
        grid.world_from_index().transform_point3(DVec3::from_array([0, 1, 2].map(voxel)))
    });
    let wide = ImageDesc::new(160, SQUARE.height);
    for (is_perspective, image) in [(false, SQUARE), (true, SQUARE), (false, wide), (true, wide)] {
        let found =
            framing.camera(None, Fit::Visible, usual_projection(is_perspective), &image).unwrap();
        let orbit = |camera: &Camera| {
            (0..48)
                .map(|step| camera.orbited(f64::from(step) * 7.5_f64.to_radians()))
                .collect::<Vec<_>>()
        };
        let camera = framing.aimed_around(&found, &Aim::default(), orbit, &image).unwrap();
        let mut largest = 0.0_f64;
        for degrees in 0..360 {
            let view = camera.orbited(f64::from(degrees).to_radians());
            let corners = (0..8).map(|corner: usize| {
                let pick = |axis: usize| ends[corner >> axis & 1][axis];
                seen(&grid, &view, &image, DVec3::new(pick(0), pick(1), pick(2)))
            });
            let most = corners.flatten().map(f64::abs).fold(0.0, f64::max);
            assert!(
                most < 1.0,
                "{is_perspective}, {} wide, {degrees} degrees: {most}",
                image.width
            );
            largest = largest.max(most);
        }
        assert!(0.7 < largest, "{is_perspective}, {} wide: {largest}", image.width);
        let centre = ends[0].midpoint(ends[1]);
        assert!(camera.target().distance(centre) < 2.0, "{} and not {centre}", camera.target());
    }
}

/// However a grid stands, and however wide the view: the box of axes is in the picture, beside what else is
/// drawn on it; and so it stays when the camera goes around.
#[cfg(all(feature = "annotations", feature = "film"))]
#[test]
fn framing_of_axes_leaves_room_for_annotations() {
    use crate::OpenScene;
    use slabsplat_core::TurnAxis;
    use slabsplat_film::Turn;
    use slabsplat_io::{LoadedVolume, parse_scene};

    slabsplat_seeds::for_each_seed(60, |mut rng| {
        let mut vector = || DVec3::from([0; 3].map(|_| rng.f64() - 0.5));
        let sides = vector() * 2.0;
        let shears =
            DMat3::from_cols(DVec3::X + vector(), DVec3::Y + vector(), DVec3::Z + vector());
        let steps = shears * DMat3::from_diagonal(sides + 0.05 * sides.signum());
        let world_from_index = DAffine3::from_mat3_translation(steps, vector() * 50.0);
        let Ok(grid) = Grid::new([12, 9, 15], world_from_index) else { return };
        let (width, height) = (rng.u32(200..900), rng.u32(200..900));
        let camera = match rng.u32(0..3) {
            0 => "projection = \"orthographic\"".to_owned(),
            1 => "projection = \"perspective\"".to_owned(),
            _ => format!("projection = \"perspective\"\nfov_y = {}", 20.0 + 100.0 * rng.f64()),
        };
        let scene = format!(
            "volume = {{ generate = \"cube\" }}\n[camera]\n{camera}\n[image]\nwidth = {width}\n\
             height = {height}\n[annotations]\naxes = true\ntitle = \"A\"\nscale_bar = {}\n\
             color_bar = {}\norientation_marker = {}\n",
            rng.bool(),
            rng.bool(),
            rng.bool(),
        );
        let file = parse_scene(&scene, "scene").unwrap();
        let volume = std::sync::Arc::new(Volume::from_fn(grid, |[x, y, z]| (x + y + z) as u8 * 7));
        let loaded = || vec![LoadedVolume::computed(volume.clone())];
        let check = |opened: &OpenScene, camera: &Camera, insets: slabsplat_annotations::Insets| {
            let [min, max] = slabsplat_annotations::axes_box(&opened.scene).unwrap();
            for corner in 0..8_u8 {
                let end = |axis: usize| if corner >> axis & 1 == 1 { max[axis] } else { min[axis] };
                let corner = DVec3::new(end(0), end(1), end(2));
                let [x, y] = seen(&grid, camera, &opened.scene.image, corner);
                let [x, y] =
                    [(0.5 + 0.5 * x) * f64::from(width), (0.5 - 0.5 * y) * f64::from(height)];
                let slack = 1e-6;
                let is_beside = insets.left - slack < x
                    && x < f64::from(width) - insets.right + slack
                    && insets.top - slack < y
                    && y < f64::from(height) - insets.bottom + slack;
                assert!(
                    is_beside,
                    "{corner} at {x}, {y} of {width} x {height}: {insets:?}\n{scene}"
                );
            }
        };
        let opened = OpenScene::with_volumes(loaded(), &file).unwrap();
        check(&opened, &opened.scene.camera, slabsplat_annotations::insets(&opened.scene));
        let turn = Turn::new(TurnAxis::Up, 360.0, 12);
        let mut around = OpenScene::unframed(loaded(), &file).unwrap();
        around.frame_around(&file, &Aim::default(), &|camera| turn.views(camera)).unwrap();
        // What stands in the middle has no more than a part of room at either side.
        let mut insets = slabsplat_annotations::insets(&around.scene);
        insets.left = insets.left.min(0.27 * f64::from(width));
        insets.right = insets.right.min(0.27 * f64::from(width));
        insets.bottom = insets.bottom.min(0.27 * f64::from(height));
        insets.top = insets.top.min(0.27 * f64::from(height));
        for frame_idx in 0..12 {
            let camera = turn.scene_at(&around.scene, frame_idx).unwrap().camera;
            check(&around, &camera, insets);
        }
    });
}

/// Of large volumes of small samples, each sample is looked up once.
#[test]
fn framing_is_of_values_whatever_their_type() {
    let grid = Grid::with_spacing([70, 50, 40], [1.0, 1.5, 0.7]).unwrap();
    let value = |[x, y, z]: [usize; 3]| (x * x + 3 * y + 7 * z * x) % 251;
    let look = |volume: Volume| {
        let curve = [(20.0, 0.0), (60.0, 0.4), (90.0, 0.1), (200.0, 0.0)];
        let transfer = TransferFunction::new(curve, [(0.0, [1.0; 3])]).unwrap();
        Cells::of_layer(&Layer::new(volume, transfer), Mode::Extinction)
    };
    let expected = look(Volume::from_fn(grid, |voxel| value(voxel) as f32));
    let same = [
        look(Volume::from_fn(grid, |voxel| value(voxel) as u8)),
        look(Volume::from_fn(grid, |voxel| value(voxel) as u16)),
        look(Volume::from_fn(grid, |voxel| value(voxel) as i16)),
    ];
    for cells in same {
        assert_eq!(cells.cells.len(), expected.cells.len());
        for (cell, expected) in cells.cells.iter().zip(&expected.cells) {
            assert_eq!((cell.middle, cell.weight), (expected.middle, expected.weight));
        }
    }
}
