//! What the section table and early termination cost in a picture (model §9).

use slabsplat::paper::{self, CubeView, cube};
use slabsplat::{ImageDesc, Lookup, Method, RenderSettings, Scene};
use slabsplat_tests::reference;
use slabsplat_tests::render::{backends_in_turn, pictures, render};

/// What a pixel may differ from that of the CPU backend, beyond what a cut-off allows.
const FROM_CPU: f32 = 1e-3;

/// The solid cube.
fn solid_cube(sections: u32, lookup: Lookup) -> Scene {
    // So many radial samples that only the offsets count.
    let settings = paper::settings().sections(sections).lookup(lookup).radial_samples(2048);
    cube(&CubeView { angle_degrees: 45.0, opacity: 1.0, ambient: 0.0, settings })
}

/// model §9 for the solid cube at w = 1: 128 nearest 3.8·10⁻³, 512 nearest 1.0·10⁻³, 128 linear
/// 7·10⁻⁵. Bounds are those of the model; the order of the three is checked too.
#[test]
fn table_quantisation() {
    // It knows no tables, so that it is the same for all of them.
    let expected = reference::render(&solid_cube(128, Lookup::Nearest));
    let largest_difference = |sections: u32, lookup: Lookup| {
        expected.compare(&render("cpu", &solid_cube(sections, lookup))).max
    };
    let paper = largest_difference(128, Lookup::Nearest);
    let finer = largest_difference(512, Lookup::Nearest);
    let linear = largest_difference(128, Lookup::Linear);
    println!("128 nearest {paper:.1e}, 512 nearest {finer:.1e}, 128 linear {linear:.1e}");
    assert!(paper < 5e-3, "{paper}");
    assert!(finer < 0.4 * paper, "{finer}");
    assert!(linear < 2e-4, "{linear}");
}

/// Pixels along a side of a picture of several tiles. With fewer, or thinner slabs, more splats would crowd a
/// tile, which takes a driver that plays a device seconds a frame.
const SIDE: u32 = 64;

/// Leaving out what lies behind saturated pixels changes no pixel by more than the cut-off leaves of 1, in
/// any backend and by any method; so no two backends differ by more, though one stops blocks of pixels and
/// another each by itself.
#[test]
fn opacity_cutoff_keeps_its_promise() {
    for (number, &method) in Method::ALL.iter().enumerate() {
        let pictures_with = |opacity_cutoff| {
            let settings = RenderSettings::default()
                .method(method)
                .opacity_cutoff(opacity_cutoff)
                .slab_width(if method == Method::PostClassified { 3.0 } else { 1.0 })
                .tolerance(0.0);
            let view = CubeView { angle_degrees: 30.0, opacity: 0.3, ambient: 0.5, settings };
            let scene = cube(&view).image(ImageDesc::new(SIDE, SIDE));
            pictures(backends_in_turn(method, number), &scene)
        };
        let exact = pictures_with(1.0);
        for opacity_cutoff in [0.7, 0.9, 0.99, 1.0 - 1e-5] {
            let cut_off = pictures_with(opacity_cutoff);
            let (_, by_cpu) = &cut_off[0];
            for ((backend, image), (_, exact)) in cut_off.iter().zip(&exact) {
                let left = 1.0 - opacity_cutoff as f32;
                let from_exact = image.max_difference(exact);
                let from_cpu = image.max_difference(by_cpu);
                println!("{backend}, {method}, {opacity_cutoff}: {from_exact:.1e}, {from_cpu:.1e}");
                assert!(from_exact <= left + 1e-6, "{backend}, {method}: {from_exact}");
                assert!(from_cpu <= left + FROM_CPU, "{backend}, {method}: {from_cpu}");
                // With so much to leave out, something is.
                assert!(0.0 < from_exact || left < 0.2, "{backend}, {method}");
            }
        }
    }
}
