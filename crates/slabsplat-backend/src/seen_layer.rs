//! A layer as the camera sees it: its voxels, and cells of them where these tell no more.

use crate::PlanError;
use crate::slabs::Depths;
use slabsplat_core::glam::DVec3;
use slabsplat_core::{Grid, Layer, Light, Scene, Shading, View};
use slabsplat_kernel::{CellLimits, DetailLevels, FootprintShape, LitDifferences};

/// A layer as the camera sees it.
pub(crate) struct SeenLayer<'a> {
    pub(crate) layer: &'a Layer,
    pub(crate) voxels: SeenGrid,
    /// What may be drawn instead, from level 1 on; seldom there.
    pub(crate) cells: Vec<SeenCells>,
}

/// Voxels, or cells of them, as the camera sees them.
pub(crate) struct SeenGrid {
    /// A cell holds `2^level` voxels along every axis.
    pub(crate) level: u32,
    pub(crate) view: View,
    pub(crate) shape: FootprintShape,
    pub(crate) depths: Depths,
}

/// Which cells may be drawn instead of voxels.
pub(crate) struct CellsToSee<'a> {
    pub(crate) levels: &'a DetailLevels,
    /// The coarsest, where parts of a scene have no more than those need; none if their grids do not say of
    /// what they are part.
    pub(crate) coarsest_in_part: Option<u32>,
}

/// Cells, and which of them may be drawn.
pub(crate) struct SeenCells {
    pub(crate) grid: SeenGrid,
    pub(crate) limits: CellLimits,
    pub(crate) lit: LitDifferences,
}

impl<'a> SeenLayer<'a> {
    /// A layer of a scene whose depths count from `center`, with kernels of that radius, and those cells.
    pub(crate) fn new(
        layer: &'a Layer,
        center: DVec3,
        scene: &Scene,
        radius: f64,
        cells: Option<&CellsToSee<'_>>,
    ) -> Result<Self, PlanError> {
        if let Shading::Phong(phong) = layer.shading {
            phong.checked()?;
        }
        let grid = layer.volume.grid();
        let view = View::about(center, grid, &scene.camera, &scene.image)?;
        let voxels = SeenGrid::new(0, grid, view, radius);
        let cells = cells.map_or_else(Vec::new, |cells| {
            voxels.all_cells(grid, cells, radius, lit_differences(layer, &scene.lights))
        });
        Ok(Self { layer, voxels, cells })
    }

    /// The depths that it may have a part in.
    pub(crate) fn depths(&self) -> impl Iterator<Item = &Depths> {
        let cells = self.cells.iter().map(|cells| &cells.grid);
        std::iter::once(&self.voxels).chain(cells).map(|seen| &seen.depths)
    }
}

impl SeenGrid {
    pub(crate) fn new(level: u32, grid: &Grid, view: View, radius: f64) -> Self {
        // Cells lie as near to each other in depth as their voxels do, on the average over a face of theirs.
        let shape = FootprintShape::new(grid, view.axes()).thinner(f64::from(1_u32 << level));
        let of_voxels = view.from_index(grid).depth_range(grid);
        let depths = Depths { of_voxels, half_depth: radius * shape.half_depth };
        Self { level, view, shape, depths }
    }

    /// Cells of all levels that may be drawn.
    fn all_cells(
        &self,
        voxels: &Grid,
        &CellsToSee { levels, coarsest_in_part }: &CellsToSee<'_>,
        radius: f64,
        lit: LitDifferences,
    ) -> Vec<SeenCells> {
        let there =
            coarsest_in_part.map_or(u32::MAX, |of| if voxels.is_in_whole() { of } else { 0 });
        let coarsest = self.coarsest(voxels, levels).min(there);
        // None where their steps would be longer than a grid can have.
        (1..=coarsest).map_while(|level| self.cells(voxels, level, levels, radius, lit)).collect()
    }

    /// Cells of that level.
    fn cells(
        &self,
        voxels: &Grid,
        level: u32,
        levels: &DetailLevels,
        radius: f64,
        lit: LitDifferences,
    ) -> Option<SeenCells> {
        let view = self.view.of_cells(level, levels.kernel_variance());
        Some(SeenCells {
            grid: Self::new(level, &voxels.of_cells(level).ok()?, view, radius),
            limits: levels.limits(level, voxels.longest_in_world() / voxels.unit(), lit),
            lit,
        })
    }

    /// Where these are, of a layer.
    pub(crate) fn grid(&self, layer: &Layer) -> Grid {
        layer.volume.grid().of_cells(self.level).expect("they were seen there")
    }

    /// The coarsest level by which anything of a grid may be drawn.
    pub(crate) fn coarsest(&self, voxels: &Grid, levels: &DetailLevels) -> u32 {
        let least_dim = voxels.whole().dims().into_iter().fold(usize::MAX, usize::min);
        levels.coarsest(self.most_stretch(), least_dim)
    }

    /// By how much footprints are stretched at the far end.
    fn most_stretch(&self) -> f64 {
        let farthest = self.depths.of_voxels[1].max(self.view.near_depth());
        self.view.stretch(self.view.pixels_per_world(farthest))
    }
}

/// What the light of a layer makes of differences at most (model §16).
fn lit_differences(layer: &Layer, lights: &[Light]) -> LitDifferences {
    let Shading::Phong(phong) = layer.shading else { return LitDifferences::UNLIT };
    let in_all = lights.iter().map(|light| DVec3::from(light.color)).sum::<DVec3>().max_element();
    LitDifferences::new(&phong, in_all)
}
