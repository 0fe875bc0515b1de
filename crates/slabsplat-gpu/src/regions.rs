//! Regions, and the part of a frame that is drawn, as the shaders read them: `shaders/shared/region.wgsl`.

use crate::splits::merged_sections;
use slabsplat_backend::{LayerPlan, Slabs, Splats};
use slabsplat_core::glam::{DMat3, DVec3};
use slabsplat_core::{PartInView, PlaneInView, RegionInView, View};
use slabsplat_kernel::SplitLevels;

/// An element of the shaders' `table`.
pub(crate) type Element = [f32; 4];

/// Elements that a plane takes.
pub(crate) const ELEMENTS_OF_PLANE: u32 = 2;

/// A plane as the shaders read it.
pub(crate) type Plane = [Element; ELEMENTS_OF_PLANE as usize];

/// The planes of a layer's region, none if it is everywhere, and behind these those of the part that is
/// drawn, none if that is all of the frame.
pub(crate) fn planes<'a>(
    layer: &'a LayerPlan<'_>,
    slabs: &'a Slabs,
    part: Option<&'a PartInView>,
) -> impl Iterator<Item = Plane> + 'a {
    let axes = layer.view.axes();
    let world_from_view = DMat3::from_cols(axes.right, axes.up, axes.forward);
    let reach = Reach::new(layer, slabs);
    let in_thicknesses = move |plane: &PlaneInView, said: DVec3| {
        let distance = plane.distance / slabs.grid.thickness();
        [plane.normal.extend(distance), said.extend(reach.before(plane))]
            .map(|element| element.as_vec4().to_array())
    };
    let of_region = layer.region.as_ref().map_or(&[][..], RegionInView::planes).iter();
    let of_region = of_region.map(move |plane| (plane, world_from_view * plane.normal));
    let of_part = part.map_or(&[][..], PartInView::faces).iter();
    let of_part = of_part.map(|(plane, is_held)| (plane, DVec3::X * f64::from(*is_held)));
    of_region.chain(of_part).map(move |(plane, said)| in_thicknesses(plane, said))
}

/// How far a voxel of a layer adds to what is drawn.
struct Reach {
    /// Takes steps in index space to steps in view space.
    view_from_index: DMat3,
    /// Of the largest footprint, in index space.
    radius: f64,
    /// How far the steepest ray moves sideways within half a slab, over which rays count as parallel.
    aside: f64,
    thickness: f64,
    /// How many slabs further back a voxel may be drawn whole than that whose face is before it.
    n_behind: f64,
    /// Of densities, how far the neighbours lie that slopes are taken to: to the side, and in thicknesses.
    beside: f64,
    n_beside: f64,
}

/// Sheets behind or before the nodes of a part that it is made of, and the half of one to where it begins.
const SHEETS_BESIDE_PART: f64 = 2.5;

impl Reach {
    fn new(layer: &LayerPlan<'_>, slabs: &Slabs) -> Self {
        let (view, thickness) = (&layer.view, slabs.grid.thickness());
        let is_merged = merged_sections(&layer.splats).is_some();
        let is_of_densities = matches!(layer.splats, Splats::Densities(_));
        let [_, end] = slabs.grid.faces(slabs.grid.n_slabs() - 1);
        let farthest = view.pixels_per_world(end.max(view.near_depth()));
        Self {
            view_from_index: view.from_index(&layer.grid()).matrix,
            radius: layer.radius * view.stretch(farthest),
            aside: 0.5 * thickness * view.steepest_ray(),
            thickness,
            n_behind: if is_merged { SplitLevels::MOST_SLABS_BEFORE as f64 } else { 0.0 },
            beside: if is_of_densities { 1.0 / farthest } else { 0.0 },
            n_beside: if is_of_densities { SHEETS_BESIDE_PART } else { 0.0 },
        }
    }

    /// How far before a plane a voxel may lie that adds to anything behind it, in thicknesses of a slab: as
    /// far as its footprint goes, and to the other end of a slab that the plane cuts, or of one that a whole
    /// voxel is put off to.
    fn before(&self, PlaneInView { normal, .. }: &PlaneInView) -> f64 {
        let of_kernel = self.radius * (self.view_from_index.transpose() * *normal).length();
        let n_thicknesses = 1.0 + 2.0 * self.n_beside;
        let aside = n_thicknesses * self.aside + self.beside;
        let of_ray = aside * normal.truncate().length();
        let n_deep = 1.0 + self.n_behind + self.n_beside;
        (of_kernel + of_ray) / self.thickness + n_deep * normal.z.abs()
    }
}

/// Where the ray of a pixel is at depth 0, and how far it moves over one world unit of depth, for each pixel
/// that it is from the optical axis.
pub(crate) fn ray_per_pixel(view: &View) -> [f64; 2] {
    let [width, height] = view.image_size().map(f64::from);
    let beside_axis = view.ray([0.5 * width + 1.0, 0.5 * height]);
    [beside_axis.start.x, beside_axis.step.x]
}
