//! One row of pixels: every sheet summed along each ray, and composited from front to back.

use super::frame::{Frame, Sheet, SheetSplat, Voxel};
use super::{Cut, Premultiplied, SheetSums};

/// What a voxel and a row of pixels have in common.
struct Splat<'a> {
    voxel: &'a Voxel,
    cut: Cut,
    /// Where rays meet the voxel's footprint. Inside a slab rays count as parallel, through where
    /// they are at its mid-depth (§5).
    plane_depth: f64,
    /// How far the footprint is stretched so that no pixel steps over it.
    stretch: f64,
    /// From the voxel's centre up to the row.
    offset_up: f64,
}

/// The premultiplied RGBA of row `y`, background included.
pub(super) fn row(frame: &Frame, y: u32) -> Vec<[f64; 4]> {
    let sheets: Vec<_> = frame.sheets.iter().map(|sheet| splats(frame, sheet, y)).collect();
    let pixel = |x: u32| {
        let mut sum = Premultiplied::default();
        for splats in &sheets {
            sum.lay_over(sheet_at(frame, splats, x));
        }
        let [r, g, b, opacity] = frame.background;
        sum.lay_over(Premultiplied { color: [r, g, b].map(|c| c * opacity), opacity });
        let [r, g, b] = sum.color;
        [r, g, b, sum.opacity]
    };
    (0..frame.view.width()).map(pixel).collect()
}

/// The splats of a sheet that may reach row `y`.
fn splats<'a>(frame: &'a Frame, sheet: &Sheet, y: u32) -> Vec<Splat<'a>> {
    let splat = |&SheetSplat { voxel_idx, cut }: &SheetSplat| {
        let voxel = &frame.voxels[voxel_idx];
        let plane_depth = sheet.plane_depth.unwrap_or(voxel.center_in_view.z);
        let stretch = (frame.view.pixel_size(plane_depth) / frame.unit).max(1.0);
        let offset_up = frame.view.row_in_view(y, plane_depth) - voxel.center_in_view.y;
        Splat { voxel, cut, plane_depth, stretch, offset_up }
    };
    let may_reach = |splat: &Splat<'_>| splat.offset_up.abs() <= splat.stretch * frame.kernel.reach;
    sheet.splats.iter().map(splat).filter(may_reach).collect()
}

fn sheet_at(frame: &Frame, splats: &[Splat<'_>], x: u32) -> Premultiplied {
    let mut sums = SheetSums::new(frame.compositing);
    for splat in splats {
        let center = splat.voxel.center_in_view;
        let offset_right = frame.view.column_in_view(x, splat.plane_depth) - center.x;
        let offset = [offset_right, splat.offset_up];
        if splat.stretch * frame.kernel.reach < offset_right.hypot(splat.offset_up) {
            continue;
        }
        let weight = frame.kernel.stretched_weight(splat.cut, offset, center.z, splat.stretch);
        sums.add(weight, splat.voxel.opacity, splat.voxel.color);
    }
    sums.finish()
}
