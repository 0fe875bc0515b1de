//! A layer as the camera sees it: its voxels, and cells of them where these tell no more.

use crate::PlanError;
use crate::slabs::Depths;
use slabsplat_core::{Grid, LabelStyle, Layer, Scene, Shading, TransferFunction, View, extinction};
use slabsplat_kernel::{DetailLevels, DetailView, FootprintShape};

/// A layer as the camera sees it.
pub(crate) struct SeenLayer<'a> {
    pub(crate) layer: &'a Layer,
    pub(crate) voxels: SeenGrid,
    /// What may be drawn instead; seldom there.
    pub(crate) cells: Option<Box<SeenGrid>>,
}

/// Voxels, or cells of them, as the camera sees them.
pub(crate) struct SeenGrid {
    /// A cell holds `2^level` voxels along every axis.
    pub(crate) level: u32,
    pub(crate) view: View,
    pub(crate) shape: FootprintShape,
    pub(crate) depths: Depths,
}

impl<'a> SeenLayer<'a> {
    /// A layer of a scene that has all those, with kernels of that radius.
    pub(crate) fn new(
        layer: &'a Layer,
        all: &[&Layer],
        scene: &Scene,
        radius: f64,
        levels: &DetailLevels,
    ) -> Result<Self, PlanError> {
        if let Shading::Phong(phong) = layer.shading {
            phong.checked()?;
        }
        let grid = layer.volume.grid();
        let center = Grid::center_of_all(all.iter().map(|layer| layer.volume.grid()));
        let view = View::about(center, grid, &scene.camera, &scene.image)?;
        let voxels = SeenGrid::new(0, grid, view, radius);
        let level = levels.coarsest(voxels.detail(layer));
        let cells = voxels.cells(grid, level, levels, radius);
        Ok(Self { layer, voxels, cells: cells.map(Box::new) })
    }

    /// The depths that it may have a part in.
    pub(crate) fn depths(&self) -> impl Iterator<Item = &Depths> {
        std::iter::once(&self.voxels).chain(self.cells.as_deref()).map(|seen| &seen.depths)
    }
}

impl SeenGrid {
    fn new(level: u32, grid: &Grid, view: View, radius: f64) -> Self {
        // Cells lie as near to each other in depth as their voxels do, on the average over a face of theirs.
        let shape = FootprintShape::new(grid, view.axes()).thinner(f64::from(1_u32 << level));
        let of_voxels = view.from_index(grid).depth_range(grid);
        let depths = Depths { of_voxels, half_depth: radius * shape.half_depth };
        Self { level, view, shape, depths }
    }

    /// Cells of that level, if it is one.
    fn cells(&self, voxels: &Grid, level: u32, levels: &DetailLevels, radius: f64) -> Option<Self> {
        // No cells where their steps would be longer than a grid can have.
        let grid = (level != 0).then(|| voxels.of_cells(level).ok()).flatten()?;
        let view = self.view.of_cells(level, levels.kernel_variance());
        Some(Self::new(level, &grid, view, radius))
    }

    /// Where these are, of a layer.
    pub(crate) fn grid(&self, layer: &Layer) -> Grid {
        layer.volume.grid().of_cells(self.level).expect("they were seen there")
    }

    fn detail(&self, layer: &Layer) -> DetailView {
        let grid = layer.volume.grid();
        let nearest = self.depths.of_voxels[0] - self.depths.half_depth;
        let scale = self.view.pixels_per_world(nearest.max(self.view.near_depth()));
        DetailView {
            stretch: self.view.stretch(scale),
            layer_depth: self.shape.half_depth / grid.unit(),
            extinction: most_extinction(layer),
            least_dim: grid.dims().into_iter().fold(usize::MAX, usize::min),
        }
    }
}

/// `μ` of the most opaque voxel that there could be.
fn most_extinction(layer: &Layer) -> f64 {
    // Boxes add up.
    if layer.transfer_2d.is_some() {
        return f64::INFINITY;
    }
    let most = |transfer: &TransferFunction| {
        let points = transfer.opacity_points().points();
        points.iter().map(|&(_, [opacity])| opacity).fold(0.0, f64::max)
    };
    let of_style = |style: &LabelStyle| style.transfer.as_ref().map_or(0.0, most);
    let of_labels = layer.labels.iter().flat_map(|labels| labels.styles().values()).map(of_style);
    extinction(of_labels.fold(most(&layer.transfer), f64::max))
}
