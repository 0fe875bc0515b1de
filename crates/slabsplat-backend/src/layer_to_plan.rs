//! The plan of a layer: its voxels, and the cells of them that may be drawn instead.

use crate::seen_layer::{SeenCells, SeenGrid, SeenLayer};
use crate::shown_values::shown_ranges;
use crate::tables::{LayerToSplat, Tables};
use crate::{CellsPlan, LayerPlan, PlanError};
use slabsplat_core::{
    BlinnPhong, FrameHandle, Layer, Method, RegionInView, RenderSettings, Scene, Shading, SlabGrid,
};
use slabsplat_kernel::Kernel;

/// The tables of a layer, by its voxels and by cells of them.
#[derive(Debug, Default)]
pub(crate) struct TablesOfLayer {
    of_voxels: Tables,
    /// From level 1 on.
    of_cells: Vec<Tables>,
}

/// What the plans of all layers of a frame share.
pub(crate) struct FrameToPlan<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) kernel: &'a dyn Kernel,
    /// With the tolerance that a layer has of it.
    pub(crate) settings: RenderSettings,
    pub(crate) method: Method,
    /// The shortest voxel step of any layer, and the width of what sheets are of, in such.
    pub(crate) unit: f64,
    pub(crate) width: f64,
    pub(crate) slabs: SlabGrid,
    pub(crate) has_meshes: bool,
    pub(crate) frame: &'a FrameHandle,
}

impl FrameToPlan<'_> {
    /// The plan of one of them.
    pub(crate) fn layer<'a>(
        &self,
        seen: &SeenLayer<'a>,
        TablesOfLayer { of_voxels, of_cells }: &mut TablesOfLayer,
    ) -> Result<LayerPlan<'a>, PlanError> {
        of_cells.resize_with(seen.cells.len(), Tables::default);
        let mut coarser = None;
        for (cells, tables) in seen.cells.iter().zip(of_cells).rev() {
            let plan = self.level(seen.layer, &cells.grid, tables, coarser)?;
            let SeenCells { limits, lit, .. } = *cells;
            coarser = Some(Box::new(CellsPlan { plan, limits, lit }));
        }
        self.level(seen.layer, &seen.voxels, of_voxels, coarser)
    }

    fn level<'a>(
        &self,
        layer: &'a Layer,
        seen: &SeenGrid,
        tables: &mut Tables,
        coarser: Option<Box<CellsPlan<'a>>>,
    ) -> Result<LayerPlan<'a>, PlanError> {
        let SeenGrid { level, view, shape, depths } = seen;
        let grid = &seen.grid(layer);
        // The same slabs, in steps of this grid.
        let scale = self.unit / grid.unit();
        let settings = self
            .settings
            .clone()
            .method(self.method)
            .slab_width(scale * self.width)
            .base_slab_width(scale * self.settings.base_slab_width);
        settings.check_hierarchy(shape.kappa)?;
        let slabs = depths.in_slabs(&self.slabs, view);
        let is_cut = !layer.region.is_everywhere();
        let is_split = is_cut || self.has_meshes;
        let (kernel, frame) = (self.kernel, self.frame);
        let level = *level;
        let to_splat =
            LayerToSplat { kernel, grid, level, view, shape, settings, slabs, is_split, frame };
        Ok(LayerPlan {
            volume: &layer.volume,
            relevant: shown_ranges(layer, self.scene.settings.mode.into()),
            transfer: &layer.transfer,
            transfer_2d: layer.transfer_2d.as_ref(),
            gradient_opacity: layer.gradient_opacity.as_ref(),
            colors: layer.colors.as_ref(),
            labels: layer.labels.as_ref(),
            isosurfaces: &layer.isosurfaces,
            light: match layer.shading {
                Shading::None => None,
                Shading::Phong(phong) => {
                    Some(BlinnPhong::new(phong, &self.scene.lights, view.axes().forward))
                }
            },
            region: is_cut.then(|| RegionInView::new(&layer.region, view)),
            level,
            coarser,
            splats: tables.splats(to_splat)?,
            radius: kernel.radius(),
            half_depth: depths.half_depth,
            view: *view,
            shape: *shape,
        })
    }
}
