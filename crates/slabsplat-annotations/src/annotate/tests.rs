//! Pictures with everything on them.

use slabsplat_core::glam::{DAffine3, DMat3, DVec3};
use slabsplat_core::{
    Annotations, Camera, Finish, Grid, ImageDesc, Layer, Orientation, Projection, Scaling,
    TransferFunction, Volume,
};

use super::*;

const CLEAR: [f32; 4] = [0.0; 4];

fn everything() -> Annotations {
    Annotations {
        title: Some("A title – µ".to_owned()),
        axes: true,
        scale_bar: true,
        color_bar: true,
        orientation_marker: true,
    }
}

fn scene([width, height]: [u32; 2], projection: Projection) -> Scene {
    let turned = DMat3::from_rotation_z(0.1) * DMat3::from_diagonal(DVec3::new(1.0, 1.5, 2.0));
    let grid =
        Grid::new([40, 30, 20], DAffine3::from_mat3_translation(turned, DVec3::splat(-20.0)));
    let volume = Volume::new(grid.unwrap(), vec![7_u16; 24_000].into(), Scaling::IDENTITY).unwrap();
    let transfer = TransferFunction::new([(0.0, 0.5)], [(0.0, [0.0; 3]), (9.0, [1.0; 3])]).unwrap();
    let target = volume.grid().center_in_world();
    let camera = Camera::new(target + DVec3::new(90.0, 140.0, 70.0), target, DVec3::Z, projection);
    let finish = Finish { annotations: everything(), ..Finish::default() };
    let image = ImageDesc { width, height, background: CLEAR };
    Scene::new(Layer::new(volume, transfer), camera.unwrap()).image(image).finish(finish)
}

fn drawn(scene: &Scene, acquisition: Acquisition) -> (Image, Vec<String>) {
    let mut image = Image::filled(scene.image.width, scene.image.height, CLEAR);
    draw_behind(&mut image, scene);
    let notes = annotate(&mut image, scene, acquisition);
    (image, notes)
}

const METRIC: Acquisition =
    Acquisition { modality: None, orientation: Orientation::Anatomical, is_metric: true };

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
        scene.finish.annotations =
            Annotations { title: Some(title.to_owned()), ..Annotations::default() };
        let (image, notes) = drawn(&scene, METRIC);
        (image.pixels().iter().any(|pixel| *pixel != CLEAR), notes)
    };
    assert_eq!(notes_of("brain", [200, 100]), (true, vec![]));
    assert_eq!(notes_of("a title that is somewhat long", [200, 100]), (true, vec![]), "it shrinks");
    let (is_drawn, notes) = notes_of(&"many words ".repeat(10), [200, 100]);
    assert!(is_drawn && notes == ["all of the title has no room in a picture of 200 x 100 pixels"]);
    let (is_drawn, notes) = notes_of("brain", [200, 6]);
    assert!(!is_drawn && notes == ["the title has no room in a picture of 200 x 6 pixels"]);
    assert_eq!(notes_of("漢", [200, 100]).1, ["the font of the title has no 漢"]);
}
