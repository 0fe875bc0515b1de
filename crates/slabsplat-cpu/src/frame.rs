//! One frame from plan to picture: the stages, in their order.

use crate::image_aligned;
use crate::polynomials::Polynomials;
use crate::raster::Raster;
use crate::relevant::Relevant;
use crate::stopwatch::Stopwatch;
use crate::tiles::Tiles;
use crate::whole::{self, Whole};
use crate::workspace::{Workspace, Workspaces};
use crate::{axis_aligned, every_sample, post_classified};
use fearless_simd::Level;
use slabsplat_backend::{Frame, FrameCost, FramePlan, Splats};
use slabsplat_core::SliceOrder;
use slabsplat_traverse::{BrickView, Classification, RelevantList, Shader};

/// What is kept from frame to frame: what need not be made anew, and memory.
#[derive(Debug, Default)]
pub(crate) struct Buffers {
    relevant: Relevant,
    classification: Option<Classification>,
    polynomials: Polynomials,
    tiles: Option<Tiles>,
    workspaces: Workspaces,
    image_aligned: image_aligned::Buffers,
    densities: post_classified::Buffers,
    /// Of the traditional methods.
    whole: whole::Buffers,
}

/// What the stages of a frame share.
pub(crate) struct Stage<'a> {
    pub(crate) plan: &'a FramePlan<'a>,
    pub(crate) level: Level,
    pub(crate) raster: Raster,
    pub(crate) list: &'a RelevantList,
    pub(crate) bricks: BrickView,
    pub(crate) shader: Shader<'a>,
}

/// Renders with the instructions of `level`.
pub(crate) fn render(plan: &FramePlan<'_>, level: Level, buffers: &mut Buffers) -> Frame {
    if let Splats::Densities { slabs, table } = &plan.splats {
        return post_classified::render(plan, slabs, table, &mut buffers.densities);
    }
    let mut watch = Stopwatch::start();
    let Buffers { relevant, classification, polynomials, tiles, workspaces, .. } = buffers;
    let list = relevant.voxels(plan.volume, &plan.relevant);
    let stage = Stage {
        plan,
        level,
        raster: Raster::new(plan),
        list,
        bricks: BrickView::new(plan.volume.grid(), &plan.view),
        shader: Shader::new(
            classified(classification, plan),
            plan.volume,
            &plan.shading,
            plan.view.axes().forward,
        ),
    };
    let tiles = Tiles::cleared(tiles, plan.view.image_size());
    watch.done("list");
    let mut n_hidden = 0;
    match &plan.splats {
        Splats::Densities { .. } => unreachable!("bug: densities have no colours to be splatted"),
        Splats::Sections { slabs, table, fewer } => {
            let of_sections =
                polynomials.of_sections(table, fewer.as_ref(), stage.raster.is_upright());
            let fewer = fewer.as_ref().zip(of_sections.fewer);
            let fewer = fewer.map(|(fewer, of_fewer)| image_aligned::Fewer {
                tolerance: fewer.tolerance,
                levels: &fewer.levels,
                table: &fewer.table,
                polynomials: of_fewer.folded,
                products: of_fewer.products,
            });
            let polynomials = of_sections.all;
            let job = image_aligned::Job { stage: &stage, slabs, table, polynomials, fewer };
            let buffers = &mut buffers.image_aligned;
            n_hidden = image_aligned::render(&job, tiles, buffers, workspaces, &mut watch);
        }
        Splats::Slices { order, table } => {
            let whole =
                Whole { raster: &stage.raster, polynomials: polynomials.of_footprint(table) };
            stage.render_slices(order, &whole, &mut buffers.whole, tiles, workspaces, &mut watch);
        }
        Splats::Voxels { table } => {
            let whole =
                Whole { raster: &stage.raster, polynomials: polynomials.of_footprint(table) };
            stage.render_voxels(&whole, &mut buffers.whole, tiles, workspaces, &mut watch);
        }
    }
    let mut stats = tiles.stats();
    (stats.n_voxels, stats.n_hidden) = (list.len() as u64, n_hidden);
    let image = tiles.image(plan.image.premultiplied_background());
    watch.done("image");
    let cost = FrameCost { stages: watch.stages(), resident_bytes: buffers.resident_bytes() };
    Frame { image, stats, cost }
}

/// What `kept` holds, if it is of the plan's transfer function, compositing and volume.
fn classified<'a>(
    kept: &'a mut Option<Classification>,
    plan: &FramePlan<'_>,
) -> &'a Classification {
    let FramePlan { transfer, compositing, volume, .. } = *plan;
    if !kept.as_ref().is_some_and(|c| c.is_of(transfer, compositing, volume)) {
        *kept = None;
    }
    kept.get_or_insert_with(|| Classification::new(transfer, compositing, volume))
}

impl Stage<'_> {
    fn render_slices(
        &self,
        order: &SliceOrder,
        whole: &Whole<'_>,
        buffers: &mut whole::Buffers,
        tiles: &mut Tiles,
        workspaces: &mut Workspaces,
        watch: &mut Stopwatch,
    ) {
        let whole::Buffers { voxels, splats, .. } = buffers;
        let sheet_of = |coords| order.sheet_of(coords);
        whole::voxels(self.list, &self.bricks, &self.shader, sheet_of, voxels);
        watch.done("shade");
        let voxel = |splat: usize| &voxels[splat];
        whole::toss(&self.raster, &tiles.grid, voxels.len(), voxel, splats);
        watch.done("toss");
        tiles.for_each(workspaces, |tile_idx, tile, workspace| {
            let here = splats.on_tile(tile_idx).map(voxel);
            axis_aligned::render_tile(self, whole, order.n_slices, here, tile, workspace);
        });
        watch.done("splat");
    }

    fn render_voxels(
        &self,
        whole: &Whole<'_>,
        buffers: &mut whole::Buffers,
        tiles: &mut Tiles,
        workspaces: &mut Workspaces,
        watch: &mut Stopwatch,
    ) {
        let whole::Buffers { voxels, order, splats } = buffers;
        whole::voxels(self.list, &self.bricks, &self.shader, |_| 0, voxels);
        watch.done("shade");
        order.update(self.plan.volume.grid(), &self.plan.view, self.list);
        watch.done("sort");
        let voxel = |splat: usize| &voxels[order.place(splat)];
        whole::toss(&self.raster, &tiles.grid, order.len(), voxel, splats);
        watch.done("toss");
        tiles.for_each(workspaces, |tile_idx, tile, workspace| {
            let here = splats.on_tile(tile_idx).map(voxel);
            every_sample::render_tile(self, whole, here, tile, &mut workspace.sheet);
        });
        watch.done("splat");
    }
}

impl Buffers {
    fn resident_bytes(&self) -> u64 {
        let bytes = self.relevant.resident_bytes()
            + self.classification.as_ref().map_or(0, Classification::resident_bytes)
            + self.tiles.as_ref().map_or(0, Tiles::resident_bytes)
            + self.workspaces.sum_of(Workspace::resident_bytes)
            + self.image_aligned.resident_bytes()
            + self.whole.resident_bytes();
        bytes as u64
    }
}
