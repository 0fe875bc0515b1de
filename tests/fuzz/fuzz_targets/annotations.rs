//! Annotations: any text, of any size and anywhere, on pictures of any size and of any camera. The first 40
//! bytes say where, as numbers of 32 bits; all else is the text.
#![no_main]

use libfuzzer_sys::fuzz_target;
use slabsplat_annotations::{
    Ink, Label, annotate, draw_behind, draw_text, insets, lacks, measure_text,
};
use slabsplat_core::glam::{DAffine3, DVec3};
use slabsplat_core::{
    Acquisition, Annotations, Camera, Finish, Grid, Image, ImageDesc, Layer, Orientation,
    Projection, Scaling, Scene, TransferFunction, Volume,
};
use slabsplat_fuzz::check_line;

/// Larger pictures only take longer.
const MAX_SIDE: u32 = 400;

fuzz_target!(|input: &[u8]| {
    let Some((numbers, text)) = input.split_first_chunk::<40>() else { return };
    let (numbers, _) = numbers.as_chunks::<4>();
    let bits = |idx: usize| u32::from_le_bytes(numbers[idx]);
    let number = |idx: usize| f32::from_bits(bits(idx));
    let text = String::from_utf8_lossy(text);
    let size = [bits(0) & 0xffff, bits(0) >> 16].map(|side| side % MAX_SIDE + 1);
    let mut image = Image::filled(size[0], size[1], [0.5, 0.5, 0.5, 1.0]);
    let [at, anchor] = [[number(1), number(2)], [number(3), number(4)]];
    let label = Label::new(&text, at).anchor(anchor).size_pixels(number(5));
    draw_text(&mut image, &label);
    assert!(measure_text(&text, 16.0).iter().all(|side| side.is_finite()));
    assert!(lacks(&text).len() <= text.chars().count());
    let eye = [number(6), number(7), number(8)].map(f64::from);
    if let Some(scene) = scene(&text, size, eye, number(9).into()) {
        draw_behind(&mut image, &scene);
        let mut acquisition = Acquisition::default().orientation(Orientation::Anatomical);
        acquisition.is_metric = text.len().is_multiple_of(2);
        annotate(&mut image, &scene, acquisition).iter().for_each(|note| check_line(note));
        insets(&scene);
    }
    let is_color = |channel: &f32| (0.0..=1.0).contains(channel);
    assert!(image.pixels().as_flattened().iter().all(is_color), "a colour that is none");
});

/// A scene with all annotations; `None` if no scene can be like that.
fn scene(title: &str, [width, height]: [u32; 2], eye: [f64; 3], extent: f64) -> Option<Scene> {
    let projection = match extent < 0.0 {
        true => Projection::Perspective { fov_y_radians: -extent },
        false => Projection::Orthographic { view_height: extent },
    };
    let camera = Camera::new(eye, DVec3::ZERO, DVec3::Z, projection).ok()?;
    let grid = Grid::new([2, 3, 4], DAffine3::from_scale(DVec3::new(1.0, 1.5, 2.0))).ok()?;
    let volume = Volume::new(grid, vec![7_u16; 24].into(), Scaling::IDENTITY).ok()?;
    let transfer = TransferFunction::new([(0.0, 0.5)], [(0.0, [0.0; 3]), (9.0, [1.0; 3])]).ok()?;
    let annotations = Annotations::default()
        .title(title)
        .axes()
        .scale_bar()
        .color_bar()
        .orientation_marker();
    let finish = Finish::default().annotations(annotations).checked().ok()?;
    let image = ImageDesc::new(width, height);
    Some(Scene::new(Layer::new(volume, transfer), camera).image(image).finish(finish))
}
