//! Axes of random boxes before random cameras, and as things turn.

use std::collections::BTreeMap;

use slabsplat_core::glam::{DVec2, DVec3};
use slabsplat_core::{
    Acquisition, Camera, Grid, Image, ImageDesc, Layer, Orientation, Projection, Scaling, Scene,
    TransferFunction, Volume,
};
use slabsplat_seeds::for_each_seed;

use super::bounds::Bounds;
use super::coordinates::{Labelled, lay_out, name};
use super::scale::{Axis, Placed};
use crate::lengths::Unit;
use crate::orientation_marker::marker_bounds;
use crate::screen::Screen;
use crate::sheet::Sheet;

const PARALLEL: Projection = Projection::Orthographic { view_height: 90.0 };

fn camera(eye: [f64; 3], projection: Projection) -> Camera {
    let up = if eye[0] == 0.0 && eye[1] == 0.0 { DVec3::Y } else { DVec3::Z };
    Camera::new(eye, DVec3::ZERO, up, projection).unwrap()
}

fn screen(eye: [f64; 3], projection: Projection) -> Screen {
    let image = ImageDesc::new(300, 300);
    Screen::new(&camera(eye, projection), &image)
}

const BOX: Bounds = Bounds([DVec3::new(-20.0, -10.0, -15.0), DVec3::new(20.0, 10.0, 15.0)]);

#[test]
fn axes_box_is_around_all_voxels() {
    let grid = Grid::centered([4, 2, 3], [1.0, 2.0, 5.0]).unwrap();
    let volume = Volume::new(grid, vec![0_u8; 24].into(), Scaling::IDENTITY).unwrap();
    let transfer = TransferFunction::new([(0.0, 0.0)], [(0.0, [1.0; 3])]).unwrap();
    let camera = camera([9.0, 0.0, 0.0], PARALLEL);
    let scene = Scene::new(Layer::new(volume, transfer), camera);
    let expected = DVec3::new(2.0, 2.0, 7.5);
    assert_eq!(Bounds::of(&scene), Some(Bounds([-expected, expected])));
    assert_eq!(Bounds::of(&Scene::of_meshes(Vec::new(), camera)), None);
}

/// Of a corner seen from afar three edges lie before the volume, and six are its outline.
#[test]
fn axes_edges_by_how_they_are_seen() {
    let counts = |eye, projection| {
        let edges = BOX.edges(&screen(eye, projection));
        assert_eq!(edges.len(), 12);
        [0, 1, 2].map(|n| edges.iter().filter(|edge| edge.n_front == n).count())
    };
    let perspective = Projection::Perspective { fov_y_radians: 0.6 };
    assert_eq!(counts([90.0, 80.0, 70.0], PARALLEL), [3, 6, 3]);
    assert_eq!(counts([90.0, 80.0, 70.0], perspective), [3, 6, 3]);
    assert_eq!(counts([0.0, 90.0, 0.0], PARALLEL), [8, 4, 0], "a face from before it");
    assert_eq!(counts([0.0, 1.0, 0.0], perspective), [12, 0, 0], "from within");
}

#[test]
fn axes_are_named_by_what_is_known() {
    assert_eq!([0, 1, 2].map(|axis| name(axis, Orientation::Anatomical)), ["R", "A", "S"]);
    assert_eq!([0, 1, 2].map(|axis| name(axis, Orientation::Pictures)), ["x", "y", "z"]);
}

/// A picture of a box, with a marker in it.
struct View {
    bounds: Bounds,
    screen: Screen,
    scene: Scene,
}

/// What stands along an axis.
struct Along {
    axis: usize,
    outwards: DVec2,
    line: [DVec2; 2],
    /// The ends of the edge in the world.
    ends: [DVec3; 2],
    /// Its name first.
    texts: Vec<Placed>,
    step: f64,
}

impl View {
    fn new(bounds: Bounds, camera: Camera, [width, height]: [u32; 2]) -> Self {
        let image = ImageDesc::new(width, height);
        let scene = Scene::of_meshes(Vec::new(), camera).image(image);
        Self { bounds, screen: Screen::new(&camera, &image), scene }
    }

    fn em(&self) -> f64 {
        let ImageDesc { width, height, .. } = self.scene.image;
        f64::from(crate::text_size(width, height))
    }

    fn marker(&self) -> [DVec2; 2] {
        marker_bounds(self.screen.size(), self.em())
    }

    /// Whether all of the box is in the picture, with room for what is written around it.
    fn leaves_room(&self) -> bool {
        let margin = DVec2::splat(4.0 * self.em());
        let corners = (0..8).filter_map(|corner: u8| {
            let end = |axis: usize| self.bounds.0[usize::from(corner >> axis & 1)][axis];
            self.screen.point(DVec3::new(end(0), end(1), end(2)))
        });
        let [min, max] = [margin, self.screen.size() - margin];
        corners.filter(|at| at.cmpge(min).all() && at.cmple(max).all()).count() == 8
    }

    /// The edge that is seen there.
    fn edge_at(&self, axis: usize, [from, to]: [DVec2; 2]) -> [DVec3; 2] {
        let of_axis = self.bounds.edges(&self.screen).into_iter().filter(|edge| edge.axis == axis);
        let distance = |ends: [DVec3; 2]| {
            let seen = self.screen.line(ends).map(|[a, b]| a.distance(from) + b.distance(to));
            seen.unwrap_or(f64::INFINITY)
        };
        let ends = of_axis.map(|edge| edge.ends);
        ends.min_by(|a, b| distance(*a).total_cmp(&distance(*b))).unwrap()
    }

    /// What is written, and which axes have no room.
    fn laid_out(&self) -> (Vec<Along>, Vec<usize>) {
        let ImageDesc { width, height, .. } = self.scene.image;
        let mut image = Image::filled(width, height, [0.0; 4]);
        let mut sheet = Sheet::new(&mut image, &self.scene);
        sheet.take(self.marker());
        let unit = self.bounds.unit(true);
        let axes = [0, 1, 2].map(|idx| Axis::of(&self.bounds, idx, unit, &self.screen, self.em()));
        let names = ["R (mm)", "A (mm)", "S (mm)"].map(str::to_owned);
        let (all, missing) = lay_out(&mut sheet, &self.bounds, &axes, &names, &self.screen);
        let along = |Labelled { scale, name, numbers }: Labelled<'_>| Along {
            axis: scale.axis.idx,
            outwards: scale.outwards,
            line: scale.line,
            ends: self.edge_at(scale.axis.idx, scale.line),
            texts: std::iter::once(name).chain(numbers).collect(),
            step: scale.axis.step(),
        };
        (all.into_iter().map(along).collect(), missing)
    }
}

fn overlap([a, b]: [DVec2; 2], [c, d]: [DVec2; 2]) -> bool {
    a.cmplt(d).all() && c.cmplt(b).all()
}

/// What must hold of every picture.
fn check_all(view: &View, all: &[Along]) {
    let texts: Vec<&Placed> = all.iter().flat_map(|along| &along.texts).collect();
    for (idx, text) in texts.iter().enumerate() {
        let [min, max] = text.bounds();
        let is_inside =
            min.cmpge(DVec2::splat(-1e-6)).all() && max.cmple(view.screen.size() + 1e-6).all();
        assert!(is_inside, "{text:?} is outside of {}", view.screen.size());
        assert!(!overlap(text.bounds(), view.marker()), "{text:?} is on the marker");
        for other in &texts[..idx] {
            assert!(!overlap(text.bounds(), other.bounds()), "{text:?} is on {other:?}");
        }
    }
    for along in all {
        assert!(3 <= along.texts.len(), "one number alone is no scale");
        for text in &along.texts {
            let own = text.distance_to(along.line);
            for other in all.iter().filter(|other| other.axis != along.axis) {
                let distance = text.distance_to(other.line);
                assert!(own <= distance + 1e-5, "{text:?}: {own} from its axis, {distance}");
            }
        }
    }
}

fn random_box(rng: &mut fastrand::Rng) -> Bounds {
    let size = DVec3::from([0; 3].map(|_| 10.0_f64.powf(1.0 + rng.f64())));
    let middle = DVec3::from([0; 3].map(|_| 200.0 * (rng.f64() - 0.5)));
    Bounds([middle - 0.5 * size, middle + 0.5 * size])
}

fn direction(rng: &mut fastrand::Rng) -> DVec3 {
    let point = DVec3::from([0; 3].map(|_| rng.f64() - 0.5));
    point.try_normalize().unwrap_or(DVec3::X)
}

/// From any side, by either projection, far away, zoomed in, and from within.
#[test]
fn axes_lie_in_the_picture_and_on_nothing() {
    let (mut n_axes, mut n_missing) = (0, 0);
    for_each_seed(600, |mut rng| {
        let bounds = random_box(&mut rng);
        let size = bounds.size().length();
        let zoom = 10.0_f64.powf(0.8 * (rng.f64() - 0.4));
        let fov_y_radians = 0.2 + 1.8 * rng.f64();
        let (projection, distance) = match rng.bool() {
            true => (Projection::Orthographic { view_height: 1.4 * size / zoom }, size),
            false => {
                let fitting = 0.6 * size / (0.5 * fov_y_radians).tan();
                (Projection::Perspective { fov_y_radians }, fitting.max(0.2 * size) / zoom)
            }
        };
        let target = bounds.middle() + direction(&mut rng) * (0.2 * size * rng.f64());
        let up = if rng.bool() { DVec3::Z } else { direction(&mut rng) };
        let eye = target + direction(&mut rng) * distance;
        let camera = Camera::new(eye, target, up, projection).unwrap();
        let sides = [rng.u32(60..1200), rng.u32(60..1200)];
        let view = View::new(bounds, camera, sides);
        let (all, missing) = view.laid_out();
        check_all(&view, &all);
        // What is not seen as a whole may have no coordinates in the picture, and no room for them beside it.
        if view.leaves_room() {
            n_axes += all.len();
            n_missing += missing.len();
        }
    });
    println!("{n_missing} whole axes have no room, and {n_axes} have");
    assert!(8 * n_missing < n_axes, "{n_missing} have no room, and {n_axes} have");
    assert!(200 < n_axes, "few boxes are seen as a whole");
}

/// How far a text may move when the camera turns by half a degree, in parts of the picture.
const LARGEST_STEP: f64 = 0.03;

/// Texts that may come or go in a whole turn.
const MOST_CHANGES: usize = 120;

/// How often another edge may have an axis' coordinates in a whole turn. Of the two upright faces beside a
/// level axis each comes to the front once and goes behind once, and twice the axis is seen end on, where its
/// outer edges change sides. Each of the four upright edges is the left one once.
const MOST_SWITCHES: [usize; 3] = [6, 6, 4];

/// Names may move along their edge this often in a whole turn.
const MOST_NAME_JUMPS: usize = 8;

/// Steps of a turn before which no edge is taken again that was left: nothing flickers.
const STEPS_AWAY: u32 = 10;

/// As a thing turns what is written on its axes moves along, and jumps only where another edge comes to the
/// outside, or where numbers would touch.
#[test]
fn axes_are_steady_in_a_turntable() {
    const N_STEPS: u32 = 720;
    for_each_seed(24, |mut rng| {
        let bounds = random_box(&mut rng);
        let size = bounds.size().length();
        let elevation = (rng.f64() - 0.3) * 1.2;
        let fov_y_radians = 0.3 + 0.9 * rng.f64();
        let distance = 0.8 * size / (0.5 * fov_y_radians).sin();
        let projection = match rng.bool() {
            true => Projection::Orthographic { view_height: 1.6 * size },
            false => Projection::Perspective { fov_y_radians },
        };
        let away = DVec3::new(elevation.cos(), 0.0, elevation.sin()) * distance;
        let middle = bounds.middle();
        let first = Camera::new(middle + away, middle, DVec3::Z, projection).unwrap();
        let mut before: BTreeMap<(usize, String), (DVec2, [DVec3; 2])> = BTreeMap::new();
        let mut steps = BTreeMap::new();
        let mut edges: [Vec<(u32, [DVec3; 2])>; 3] = Default::default();
        let (mut n_changes, mut n_name_jumps, mut n_seen) = (0, 0, 0);
        for step in 0..=N_STEPS {
            let angle = std::f64::consts::TAU * f64::from(step) / f64::from(N_STEPS) + 0.001;
            let view = View::new(bounds, first.orbited(angle), [500, 400]);
            let (all, _) = view.laid_out();
            check_all(&view, &all);
            let mut now = BTreeMap::new();
            for along in &all {
                let round = *steps.entry(along.axis).or_insert(along.step);
                assert_eq!(along.step, round, "axis {}: the same step in all frames", along.axis);
                take_edge(&mut edges[along.axis], along.ends, step);
                for text in &along.texts {
                    now.insert((along.axis, text.text.clone()), (text.center, along.ends));
                }
            }
            n_seen += now.len();
            for (text, (at, ends)) in &now {
                let Some((was_at, was_ends)) = before.get(text) else {
                    n_changes += usize::from(0 < step);
                    continue;
                };
                if ends == was_ends && LARGEST_STEP * 500.0 < at.distance(*was_at) {
                    // Names have several places on an edge.
                    assert!(text.1.contains("mm"), "{text:?} jumps from {was_at} to {at}");
                    n_name_jumps += 1;
                }
            }
            n_changes += before.keys().filter(|text| !now.contains_key(text)).count();
            before = now;
        }
        let n_switches = edges.map(|edges| edges.len().saturating_sub(1));
        println!("{n_changes} come or go, {n_name_jumps} names jump, {n_switches:?}, of {n_seen}");
        assert!(n_changes <= MOST_CHANGES, "{n_changes} texts come or go");
        assert!(n_name_jumps <= MOST_NAME_JUMPS, "{n_name_jumps} names jump");
        for (n_switches, most) in n_switches.into_iter().zip(MOST_SWITCHES) {
            assert!(n_switches <= most, "coordinates go to another edge {n_switches} times");
        }
        assert!(3 * N_STEPS as usize <= n_seen, "hardly anything is written: {n_seen}");
    });
}

/// Notes the edge that has an axis' coordinates, and since when.
fn take_edge(edges: &mut Vec<(u32, [DVec3; 2])>, ends: [DVec3; 2], step: u32) {
    let Some((since, last)) = edges.last().copied() else { return edges.push((step, ends)) };
    if last != ends {
        let is_back = edges.iter().rev().nth(1).is_some_and(|(_, earlier)| *earlier == ends);
        assert!(!is_back || STEPS_AWAY <= step - since, "coordinates flicker at step {step}");
        edges.push((step, ends));
    }
}

/// Ticks are where their coordinates are, and numbers beside them, outside of the box.
#[test]
fn axes_numbers_are_where_their_coordinates_are() {
    let perspective = Projection::Perspective { fov_y_radians: 0.6 };
    for projection in [PARALLEL, perspective] {
        let view = View::new(BOX, camera([90.0, 80.0, 70.0], projection), [300, 300]);
        let corners = (0..8).map(|corner: u8| {
            let end = |axis: usize| BOX.0[usize::from(corner >> axis & 1)][axis];
            view.screen.point(DVec3::new(end(0), end(1), end(2))).unwrap()
        });
        let corners: Vec<DVec2> = corners.collect();
        let (all, missing) = view.laid_out();
        assert_eq!((all.len(), missing), (3, vec![]));
        for Along { axis, outwards, line: [from, to], texts, .. } in &all {
            for corner in &corners {
                let beyond = (corner - from.midpoint(*to)).dot(*outwards);
                assert!(beyond < 1e-6, "{corner} is beyond the edge by {beyond}");
            }
            for number in &texts[1..] {
                let coordinate: f64 = number.text.replace('−', "-").parse().unwrap();
                assert_eq!(coordinate % 5.0, 0.0, "{coordinate}");
                let part = (coordinate - BOX.0[0][*axis]) / BOX.size()[*axis];
                let from_line = number.center - from.lerp(*to, part);
                // In perspective halves of an edge differ in length.
                let slack = if projection == PARALLEL { 1e-6 } else { 20.0 };
                assert!(from_line.dot(outwards.perp()).abs() < slack, "{number:?}");
                let least = 0.6 * view.em() + 0.5 * number.size.dot(outwards.abs());
                assert!(least - 1e-6 <= from_line.dot(*outwards), "{number:?} is on the box");
            }
        }
    }
}

/// An axis that is seen end on has no numbers, and that is nothing to tell of.
#[test]
fn axes_seen_end_on_have_no_numbers() {
    for eye in [[90.0, 0.0, 0.0], [90.0, 0.5, 0.0], [90.0, 3.0, 4.0]] {
        let view = View::new(BOX, camera(eye, PARALLEL), [300, 300]);
        let (all, missing) = view.laid_out();
        let axes: Vec<usize> = all.iter().map(|along| along.axis).collect();
        assert_eq!((axes, missing), (vec![2, 1], vec![]), "{eye:?}");
    }
    let view = View::new(BOX, camera([90.0, 80.0, 70.0], PARALLEL), [60, 60]);
    let (_, missing) = view.laid_out();
    assert!(!missing.is_empty(), "in small pictures there is no room");
}

#[test]
fn axes_are_upright_by_the_camera() {
    let upright = |up: [f64; 3]| {
        let camera = Camera::new([50.0, 40.0, 90.0], DVec3::ZERO, up, PARALLEL).unwrap();
        Screen::new(&camera, &ImageDesc::default()).upright_axis()
    };
    assert_eq!(upright([0.0, 0.0, 1.0]), 2);
    assert_eq!(upright([0.0, -5.0, 1.0]), 1);
    assert_eq!(upright([1.0, 0.0, 0.1]), 0);
    assert_eq!(upright([1.0, 1.0, 1.0]), 2);
}

#[test]
fn axes_of_nothing_are_none() {
    let scene = Scene::of_meshes(Vec::new(), camera([9.0, 0.0, 0.0], PARALLEL));
    let mut image = Image::filled(300, 300, [0.0; 4]);
    let mut sheet = Sheet::new(&mut image, &scene);
    let screen = Screen::new(&scene.camera, &scene.image);
    super::draw_coordinates(&mut sheet, &scene, &screen, Acquisition::default());
    assert_eq!(sheet.notes, [""; 0]);
    assert_eq!(Unit::of_axis(40.0, true).symbol, "mm");
}
