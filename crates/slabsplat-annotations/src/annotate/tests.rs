//! Pictures with everything on them.

use slabsplat_core::glam::{DAffine3, DMat3, DVec3};
use slabsplat_core::{
    Annotations, Camera, Finish, Grid, ImageDesc, Layer, Orientation, Projection, Scaling,
    TransferFunction, Volume,
};

use super::*;
use crate::room::{Insets, insets};

const CLEAR: [f32; 4] = [0.0; 4];

fn everything() -> Annotations {
    let annotations = Annotations::default().title("A title – µ").axes().scale_bar();
    annotations.color_bar().orientation_marker()
}

fn scene([width, height]: [u32; 2], projection: Projection) -> Scene {
    let turned = DMat3::from_rotation_z(0.1) * DMat3::from_diagonal(DVec3::new(1.0, 1.5, 2.0));
    let grid =
        Grid::new([40, 30, 20], DAffine3::from_mat3_translation(turned, DVec3::splat(-20.0)));
    let volume = Volume::new(grid.unwrap(), vec![7_u16; 24_000].into(), Scaling::IDENTITY).unwrap();
    let transfer = TransferFunction::new([(0.0, 0.5)], [(0.0, [0.0; 3]), (9.0, [1.0; 3])]).unwrap();
    let target = volume.grid().center_in_world();
    let camera = Camera::new(target + DVec3::new(90.0, 140.0, 70.0), target, DVec3::Z, projection);
    let finish = Finish::default().annotations(everything());
    let image = ImageDesc::new(width, height).background(CLEAR);
    Scene::new(Layer::new(volume, transfer), camera.unwrap()).image(image).finish(finish)
}

fn drawn(scene: &Scene, acquisition: Acquisition) -> (Image, Vec<String>) {
    let mut image = Image::filled(scene.image.width, scene.image.height, CLEAR);
    draw_behind(&mut image, scene);
    let notes = annotate(&mut image, scene, acquisition);
    (image, notes)
}

const METRIC: Acquisition = Acquisition::UNKNOWN.orientation(Orientation::Anatomical).metric();

const ORTHOGRAPHIC: Projection = Projection::Orthographic { view_height: 110.0 };
const PERSPECTIVE: Projection = Projection::Perspective { fov_y_radians: 0.6 };

#[test]
fn annotations_have_room_in_usual_pictures() {
    for size in [[400, 400], [800, 600], [2000, 2000]] {
        for projection in [ORTHOGRAPHIC, PERSPECTIVE] {
            let (image, notes) = drawn(&scene(size, projection), METRIC);
            assert_eq!(notes, [""; 0], "{size:?} {projection:?}");
            for channel in image.pixels().as_flattened() {
                assert!((0.0..=1.0).contains(channel), "{channel}");
            }
        }
    }
}

/// Nothing panics, whatever the size, and what has no room is told of.
#[test]
fn annotations_of_odd_pictures() {
    for size in [[1, 1], [16, 16], [64, 64], [3000, 200], [200, 3000], [1, 500], [500, 1]] {
        for projection in
            [ORTHOGRAPHIC, PERSPECTIVE, Projection::Orthographic { view_height: 1e-3 }]
        {
            let (_, notes) = drawn(&scene(size, projection), METRIC);
            if size[0].min(size[1]) <= 64 {
                assert!(notes.iter().any(|note| note.contains("no room")), "{size:?}: {notes:?}");
            }
        }
    }
}

#[test]
fn annotations_seen_from_everywhere() {
    let mut scene = scene([120, 90], PERSPECTIVE);
    let middle = scene.layers[0].volume.grid().center_in_world();
    for step in [DVec3::X, -DVec3::Y, DVec3::new(0.0, 1e-9, 1.0), DVec3::ONE] {
        // From afar, from a face on, and from within.
        for distance in [200.0, 20.0, 1.0, 1e-3] {
            for projection in [ORTHOGRAPHIC, PERSPECTIVE] {
                let up = if step.z == 1.0 { DVec3::Y } else { DVec3::Z };
                scene.camera =
                    Camera::new(middle + step * distance, middle, up, projection).unwrap();
                let (image, _) = drawn(&scene, METRIC);
                assert!(image.pixels().as_flattened().iter().all(|c| c.is_finite()));
            }
        }
    }
}

#[test]
fn annotations_that_are_not_wanted_are_not_drawn() {
    let mut scene = scene([200, 150], ORTHOGRAPHIC);
    scene.finish.annotations = Annotations::default();
    let (image, notes) = drawn(&scene, Acquisition::default());
    assert!(notes.is_empty() && image.pixels().iter().all(|pixel| *pixel == CLEAR));
}

#[test]
fn annotations_without_a_unit_say_so() {
    let (_, notes) = drawn(&scene([800, 600], ORTHOGRAPHIC), Acquisition::default());
    let expected = "the file does not say in which unit lengths are: they are shown without one";
    assert_eq!(notes, [expected]);
}

#[test]
fn title_is_made_to_fit() {
    let notes_of = |title: &str, size| {
        let mut scene = scene(size, ORTHOGRAPHIC);
        scene.finish.annotations = Annotations::default().title(title);
        let (image, notes) = drawn(&scene, METRIC);
        (image.pixels().iter().any(|pixel| *pixel != CLEAR), notes)
    };
    assert_eq!(notes_of("brain", [200, 100]), (true, vec![]));
    assert_eq!(notes_of("a title that is somewhat long", [200, 100]), (true, vec![]), "it shrinks");
    let (is_drawn, notes) = notes_of(&"many words ".repeat(10), [200, 100]);
    assert!(is_drawn && notes == ["all of the title has no room in a picture of 200 x 100 pixels"]);
    let (is_drawn, notes) = notes_of("brain", [200, 6]);
    assert!(!is_drawn && notes == ["the title has no room in a picture of 200 x 6 pixels"]);
    assert_eq!(
        notes_of("漢", [200, 100]).1,
        ["the font of the title has no 漢: boxes are in their place"]
    );
}

/// What is left out of small pictures is told of, and of all pictures a good part is left for the scene.
#[test]
fn annotations_leave_room_for_what_is_seen() {
    let mut kept_before = [false; 5];
    for side in (10..400).chain((400..=4000).step_by(50)) {
        let scene = scene([side, side], ORTHOGRAPHIC);
        let room = Room::of(&scene);
        let Room { has_title, has_scale_bar, has_color_bar, has_marker, has_axes, notes } = room;
        let kept = [has_title, has_scale_bar, has_color_bar, has_marker, has_axes];
        let n_kept = kept.iter().filter(|has_room| **has_room).count();
        assert_eq!(n_kept + notes.len(), 5, "{side}: {notes:?}");
        // What comes to have room may take that of what is worth less, and of nothing else.
        assert!(kept_before <= kept, "{side}: {kept:?}");
        kept_before = kept;
        let Insets { left, right, top, bottom } = insets(&scene);
        let left_over = f64::from(side) * 0.4 - 1e-9;
        assert!(left_over <= f64::from(side) - left - right, "{side}");
        assert!(left_over <= f64::from(side) - top - bottom, "{side}");
        match side {
            10..25 => assert_eq!(n_kept, 0, "{side}"),
            // One takes height and the other width; nothing else has room beside or below what is left.
            60 => assert_eq!(kept, [true, false, true, false, false], "{notes:?}"),
            300.. => assert_eq!(n_kept, 5, "{side}: {notes:?}"),
            _ => {}
        }
    }
}

/// The edges of the box do not run through the marker.
#[test]
fn marker_lies_on_no_edge() {
    let mut scene = scene([300, 300], Projection::Orthographic { view_height: 70.0 });
    let em = f64::from(text_size(300, 300));
    let [min, max] = marker_bounds(DVec2::splat(300.0), em);
    let n_drawn = |scene: &Scene| {
        let mut behind = Image::filled(300, 300, CLEAR);
        draw_behind(&mut behind, scene);
        let columns = || min.x.ceil() as u32..max.x as u32;
        let pixels =
            (min.y.ceil() as u32..max.y as u32).flat_map(|y| columns().map(move |x| (x, y)));
        pixels.filter(|(x, y)| behind.pixel(*x, *y) != CLEAR).count()
    };
    let target = scene.camera.target();
    for turn in 0..24 {
        let away = DVec3::new((f64::from(turn) * 0.26).cos(), (f64::from(turn) * 0.26).sin(), 0.4);
        scene.camera =
            Camera::new(target + away * 100.0, target, DVec3::Z, scene.camera.projection())
                .unwrap();
        scene.finish.annotations.orientation_marker = true;
        assert_eq!(n_drawn(&scene), 0, "{turn}");
    }
    let without = (0..24).map(|turn| {
        let away = DVec3::new((f64::from(turn) * 0.26).cos(), (f64::from(turn) * 0.26).sin(), 0.4);
        let mut scene = scene.clone();
        scene.camera =
            Camera::new(target + away * 100.0, target, DVec3::Z, scene.camera.projection())
                .unwrap();
        scene.finish.annotations.orientation_marker = false;
        n_drawn(&scene)
    });
    assert!(0 < without.sum::<usize>(), "there would be edges");
}
