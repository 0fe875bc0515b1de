//! Small scenes for every stage of a frame: each method, the modes, layers, regions, labels, meshes. What
//! plays a graphics card takes seconds for what a card does in a millisecond.
//!
//! The test that judges compiles this file too, so that both sides draw the same.

use slabsplat::glam::DVec3;
use slabsplat::{
    Automatic, ImageDesc, Isosurface, LabelMap, LabelStyle, Labels, Layer, Light, Mesh, MeshLayer,
    MeshParts, Method, Mode, Plane, Region, RenderSettings, Scene, Volume, io,
};
use std::error::Error;
use std::sync::Arc;

/// All of them, by their names.
pub(crate) fn all() -> Vec<(&'static str, Scene)> {
    try_all().expect("the scenes are valid")
}

fn try_all() -> Result<Vec<(&'static str, Scene)>, Box<dyn Error>> {
    let [cell, signal] = [builtin("neuron")?, builtin("marschner-lobb")?];
    let densities = Method::PostClassified;
    let colors = [
        ("image-aligned", of(&cell, Method::ImageAligned)),
        ("axis-aligned", of(&cell, Method::AxisAligned)),
        ("every-sample", of(&cell, Method::EverySample)),
        ("perspective", in_perspective(of(&cell, Method::ImageAligned))),
        ("labels", with_labels(of(&cell, Method::ImageAligned))?),
        ("layers, one cut", with_layer(of(&cell, Method::ImageAligned), &signal)?),
        ("mesh among sheets", with_mesh(of(&cell, Method::ImageAligned))?),
    ];
    let of_densities = [
        ("post-classified", of(&signal, densities)),
        ("maximum", in_mode(of(&cell, densities), Mode::Maximum)),
        ("minimum", in_mode(of(&signal, densities), Mode::Minimum)),
        ("average", in_mode(of(&signal, densities), Mode::Average)),
        ("isosurfaces", with_isosurfaces(of(&signal, densities))?),
        ("mesh among densities", with_mesh(of(&cell, densities))?),
        ("layers of densities", with_layer(of(&cell, densities), &signal)?),
        ("layers, maximum", in_mode(with_layer(of(&cell, densities), &signal)?, Mode::Maximum)),
        ("layers, isosurfaces", with_isosurfaces(with_layer(of(&cell, densities), &signal)?)?),
    ];
    Ok(colors.into_iter().chain(of_densities).collect())
}

fn builtin(name: &str) -> Result<Arc<Volume>, Box<dyn Error>> {
    Ok(Arc::new(io::builtin_volume(name, Some(12))?))
}

/// As it is by itself, with nothing left out that two backends need not leave out alike.
fn of(volume: &Arc<Volume>, method: Method) -> Scene {
    let image = ImageDesc::new(30, 22).background([0.1, 0.2, 0.3, 0.5]);
    let settings = RenderSettings::default().method(method).tolerance(0.0);
    let scene = Automatic::new(volume.clone()).scene(image, settings.opacity_cutoff(1.0 - 1e-5));
    let camera = scene.camera.orbited(0.3);
    scene.camera(camera)
}

fn in_perspective(scene: Scene) -> Scene {
    let automatic = Automatic::new(scene.layers[0].volume.clone());
    let camera = automatic.camera(&scene.image, true).orbited(-0.4);
    let light = Light::towards([1.0, 2.0, 3.0]).expect("it is not zero");
    scene.camera(camera).lights(vec![light, Light::default().color([0.4, 0.4, 0.5])])
}

fn in_mode(mut scene: Scene, mode: Mode) -> Scene {
    scene.settings = scene.settings.mode(mode);
    scene
}

fn with_isosurfaces(mut scene: Scene) -> Result<Scene, Box<dyn Error>> {
    for layer in &mut scene.layers {
        let [_, top] = layer.volume.summary().range.ok_or("no voxel has a value")?;
        layer.isosurfaces = vec![
            Isosurface::new(0.35 * top, 0.4, Some([0.2, 0.6, 1.0]))?,
            Isosurface::new(0.6 * top, 1.0, None)?,
        ];
    }
    Ok(in_mode(scene, Mode::Isosurfaces))
}

/// A second volume at the same position, of which half is cut off.
fn with_layer(mut scene: Scene, volume: &Arc<Volume>) -> Result<Scene, Box<dyn Error>> {
    let grid = *scene.layers[0].volume.grid();
    let placed = Volume::clone(volume).with_grid(grid)?;
    let transfer = Automatic::new(placed.clone()).transfer().clone();
    let half = Region::new(vec![Plane::new([1.0, 0.5, 0.2], 0.0)?]).lit();
    scene.layers.push(Layer::new(placed, transfer).region(half));
    Ok(scene)
}

/// One half is green, the other hardly there.
fn with_labels(mut scene: Scene) -> Result<Scene, Box<dyn Error>> {
    let grid = *scene.layers[0].volume.grid();
    let middle = grid.dims()[0] / 2;
    let halves = Volume::from_fn(grid, |[x, ..]| 1 + u8::from(middle <= x));
    let green = LabelStyle::default().color([0.1, 0.9, 0.2]);
    let faint = LabelStyle::default().opacity(0.2);
    scene.layers[0].labels =
        Some(Labels::new(LabelMap::new(&halves, &grid)?, [(1, green), (2, faint)])?);
    Ok(scene)
}

/// A slanted triangle through the middle, as large as the volume.
fn with_mesh(scene: Scene) -> Result<Scene, Box<dyn Error>> {
    let grid = scene.layers[0].volume.grid();
    let (middle, size) = (grid.center_in_world(), grid.unit() * grid.dims()[0] as f64);
    let corners = [[-0.5, -0.4, -0.3], [0.6, 0.1, -0.2], [-0.1, 0.3, 0.5]];
    let positions = corners.map(|corner| middle + size * DVec3::from(corner)).to_vec();
    let parts = MeshParts::new(positions).triangles(vec![[0, 1, 2]]);
    Ok(scene.meshes(vec![MeshLayer::new(Mesh::new(parts)?).color([0.9, 0.7, 0.2])]))
}
