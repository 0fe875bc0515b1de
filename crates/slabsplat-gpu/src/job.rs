//! A frame to be made: all of a plan that the device needs, in the shaders' own terms, so that the
//! plan can go.

use crate::densities::DensityJob;
use crate::depth_params::DepthSort;
use crate::drawn_by::DrawnBy;
use crate::frame_params::{SplatLayer, frame_params, slabs_of};
use crate::layer_params::layer_params;
use crate::listing::Listing;
use crate::params::{COUNT_VOXELS, Frame, Layer, NO_COUNT, NO_SPLITS, NO_SURFACES, TILE_SIDE};
use crate::regions::{self, ELEMENTS_OF_PLANE, Element, Plane};
use crate::splits;
use crate::surfaces::Surfaces;
use crate::tables::LayerTables;
use slabsplat_backend::{ColorSplats, FramePlan, Splats};
use slabsplat_core::Image;
use slabsplat_shaders::{PROJECT, PROJECT_CELLS, Shader};
use std::sync::Arc;

/// A frame to be made.
#[derive(Clone, Debug)]
pub(crate) struct Job {
    pub(crate) frame: Frame,
    /// In the order of the plan, the levels of each from voxels on. None if there are surfaces alone.
    pub(crate) layers: Vec<JobLayer>,
    /// What the shaders read of them.
    pub(crate) params: Vec<Layer>,
    /// The planes of all regions, and of the part that is drawn.
    pub(crate) planes: Vec<Plane>,
    /// How slabs split the kernels of all layers that have merged sections.
    pub(crate) splits: Vec<Element>,
    /// What sheets of densities are shown by, if they are of densities.
    pub(crate) densities: Option<DensityJob>,
    /// Where rays end, if there are meshes.
    pub(crate) surfaces: Option<Arc<Surfaces>>,
    /// How the list is sorted, if not by sheets.
    pub(crate) depth_sort: Option<DepthSort>,
    /// The stage that splats.
    pub(crate) splats_by: &'static Shader,
    /// What the picture is laid behind once it is there.
    pub(crate) in_front: Option<Arc<Image>>,
    /// If it follows a frame that is much like it: by how many sheets what is hidden on a tile lies behind
    /// those in which the tile was saturated then.
    pub(crate) sheets_behind: Option<i32>,
}

/// A layer of a frame, or one level of it.
#[derive(Clone, Debug)]
pub(crate) struct JobLayer {
    pub(crate) listing: Listing,
    /// The stage that projects what is listed.
    pub(crate) projected_by: &'static Shader,
    pub(crate) tables: LayerTables,
    /// At least as many voxels as are relevant, and at least one: a little more than are, so that the
    /// number stays where the list grows and shrinks a little.
    pub(crate) max_voxels: u64,
}

impl Job {
    /// What a plan asks for, whose layers and their levels are these, drawn so, with their voxels listed so,
    /// and with these surfaces. All voxels together should stay below `most_voxels`, if they can.
    pub(crate) fn new(
        plan: &FramePlan<'_>,
        (layers, drawn_by): (&[SplatLayer<'_, '_>], DrawnBy),
        listings: Vec<Listing>,
        surfaces: Option<Arc<Surfaces>>,
        most_voxels: u64,
    ) -> Self {
        let DrawnBy { tables, shader } = drawn_by;
        let job_layer = |(listing, tables): (Listing, _)| {
            let max_voxels = listing.max_voxels().max(1);
            let projected_by = if listing.level() == 0 { &PROJECT } else { &PROJECT_CELLS };
            JobLayer { listing, projected_by, tables, max_voxels }
        };
        let mut job_layers: Vec<_> = listings.into_iter().zip(tables).map(job_layer).collect();
        leave_room(&mut job_layers, most_voxels);
        let (params, planes, splits) = placed(plan, layers, &job_layers);
        let depth_sort = match layers {
            [(layer, Splats::Colors(ColorSplats::Voxels { .. }))] => Some(DepthSort::new(layer)),
            _ => None,
        };
        let n_quads: u32 = job_layers.iter().map(|layer| layer.tables.n_quads()).sum();
        let n_before = n_quads + ELEMENTS_OF_PLANE * planes.len() as u32 + splits.len() as u32;
        let densities = DensityJob::new(plan, layers, &job_layers, n_before);
        let row_len = job_layers.first().map_or(0, |layer| layer.tables.sections.row_len());
        let frame = frame_params(plan, layers, row_len);
        let splats_by = densities.as_ref().map_or(shader, |densities| densities.stage.shader);
        let in_front = plan.in_front.cloned().map(Arc::new);
        let layers = job_layers;
        Self {
            frame,
            layers,
            params,
            planes,
            splits,
            densities,
            surfaces,
            depth_sort,
            splats_by,
            in_front,
            sheets_behind: None,
        }
    }

    /// Elements of the shaders' `table` that section tables take, planes behind those, splits, and what
    /// densities are shown by.
    pub(crate) fn n_elements(&self) -> [u64; 4] {
        let of_tables = self.layers.iter().map(|layer| u64::from(layer.tables.n_quads())).sum();
        let of_planes = u64::from(ELEMENTS_OF_PLANE) * self.planes.len() as u64;
        [of_tables, of_planes, self.splits.len() as u64, self.shown().len() as u64]
    }

    /// What densities are shown by.
    pub(crate) fn shown(&self) -> &[Element] {
        self.densities.as_ref().map_or(&[], |densities| &densities.shown)
    }

    /// The element at which surfaces begin, behind all that.
    pub(crate) fn first_surface(&self) -> u32 {
        let first = self.n_elements().iter().sum::<u64>() as u32;
        if self.surfaces.is_some() { first } else { NO_SURFACES }
    }

    /// Room for the voxels of all layers.
    pub(crate) fn max_voxels(&self) -> u64 {
        self.layers.iter().map(|layer| layer.max_voxels).sum()
    }

    /// Where the device counts the voxels that are sorted: of several layers all that there is room for.
    pub(crate) fn count_slot(&self) -> u32 {
        if self.layers.len() == 1 { COUNT_VOXELS } else { NO_COUNT }
    }

    /// Elements that a pixel holds from sheet to sheet.
    pub(crate) fn n_held(&self) -> u64 {
        self.densities.as_ref().map_or(1, |densities| densities.stage.n_held)
    }

    pub(crate) fn n_tiles(&self) -> u32 {
        self.frame.n_tiles[0] * self.frame.n_tiles[1]
    }

    /// About how many splats are tossed: each voxel, as often as a footprint at the centre of all touches
    /// tiles. Close-ups may need more, which shows when it is too late, or far less.
    pub(crate) fn expected_splats(&self) -> u64 {
        let of_layer = |(layer, params): (&JobLayer, &Layer)| {
            (layer.max_voxels as f64 * f64::from(self.tiles_of_footprint(params))) as u64
        };
        self.layers.iter().zip(&self.params).map(of_layer).sum()
    }

    /// How many more voxels are drawn than there are records.
    pub(crate) fn n_more_voxels(&self) -> i64 {
        self.layers.iter().map(|layer| layer.listing.n_more_voxels()).sum()
    }

    fn tiles_of_footprint(&self, layer: &Layer) -> f32 {
        let is_perspective = self.frame.is_perspective == 1;
        let distance = if is_perspective { layer.eye_distance.max(1.0) } else { 1.0 };
        let scale = layer.pixels_per_unit / distance;
        let squared = 1.0 / (scale * scale) - layer.spread;
        let stretch = squared.max(layer.least_stretch_squared).sqrt();
        let pixels = scale * stretch;
        let border = if self.densities.is_some() { 1.0 } else { 0.0 };
        let across = |half_extent: f32| {
            1.0 + 2.0 * (half_extent * self.frame.radius * pixels + border) / TILE_SIDE as f32
        };
        layer.half_extent.map(across).iter().product::<f32>().min(MOST_TILES_EXPECTED)
    }
}

/// Of voxels with larger footprints most are outside of the picture. A guess must not cost more memory than a
/// frame needs; if it was too small, the counts tell.
const MOST_TILES_EXPECTED: f32 = 4.0;

/// Leaves some room behind the voxels of each layer, if all together stay below `most_voxels`.
fn leave_room(layers: &mut [JobLayer], most_voxels: u64) {
    let roomy = |layer: &JobLayer| {
        layer.max_voxels.next_multiple_of((layer.max_voxels / 8).next_power_of_two())
    };
    if layers.iter().map(roomy).sum::<u64>() <= most_voxels {
        layers.iter_mut().for_each(|layer| layer.max_voxels = roomy(layer));
    }
}

/// What the shaders read of layers, their voxels, tables, planes and splits one after the other; and the
/// planes and splits.
fn placed(
    plan: &FramePlan<'_>,
    layers: &[SplatLayer<'_, '_>],
    job_layers: &[JobLayer],
) -> (Vec<Layer>, Vec<Plane>, Vec<Element>) {
    let part = plan.part.as_ref();
    let n_part_planes = part.map_or(0, |part| part.faces().len() as u32);
    let n_quads: u32 = job_layers.iter().map(|layer| layer.tables.n_quads()).sum();
    let (mut params, mut planes, mut all_splits): (Vec<Layer>, Vec<_>, Vec<_>) = Default::default();
    let (mut first_voxel, mut first_element, mut region) = (0, 0, 0);
    for (idx, ((layer, splats), job_layer)) in layers.iter().zip(job_layers).enumerate() {
        // Layers of one region follow each other.
        if layers[region as usize].0.region != layer.region {
            region = idx as u32;
        }
        let first_plane = n_quads + ELEMENTS_OF_PLANE * planes.len() as u32;
        if let Some(slabs) = slabs_of(splats) {
            planes.extend(regions::planes(layer, slabs, part));
        }
        let own = layer_params(layer, splats);
        let placed = Layer { first_voxel, first_element, region, first_plane, ..own };
        let first_merged_element = first_element + job_layer.tables.sections.n_quads();
        // Counted from the first of all, until it is known where that is.
        let splits = splits::elements(splats);
        let first_split = if splits.is_some() { all_splits.len() as u32 } else { NO_SPLITS };
        all_splits.extend(splits.into_iter().flatten());
        params.push(Layer { n_part_planes, first_merged_element, first_split, ..placed });
        first_voxel += job_layer.max_voxels as u32;
        first_element += job_layer.tables.n_quads();
    }
    let n_before = n_quads + ELEMENTS_OF_PLANE * planes.len() as u32;
    for layer in params.iter_mut().filter(|layer| layer.first_split != NO_SPLITS) {
        layer.first_split += n_before;
    }
    (params, planes, all_splits)
}
