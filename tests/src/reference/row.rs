//! One row of pixels: every sheet summed along each ray, and composited from front to back.

use super::frame::{Frame, LayerInView, Sheet, SheetSplat, Voxel};
use super::mesh::{Surfaces, mean_of_samples, share_before};
use super::region::RegionOnRay;
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
pub(super) fn row(frame: &Frame, surfaces: &Surfaces<'_>, y: u32) -> Vec<[f64; 4]> {
    let splats: Vec<_> = frame.sheets.iter().map(|sheet| splats(frame, sheet, y)).collect();
    let pixel = |x: u32| {
        let at = [i64::from(x), i64::from(y)];
        let on_ray = |layer: &LayerInView| RegionOnRay::new(&layer.region, &frame.view, at);
        let regions: Vec<RegionOnRay> = frame.layers.iter().map(on_ray).collect();
        let in_sheet = |(sheet, splats): (&Sheet, &Vec<Vec<Splat<'_>>>)| {
            let mut sums = SheetSums::new(frame.compositing);
            for ((layer, splats), region) in frame.layers.iter().zip(splats).zip(&regions) {
                let share = sheet.faces.map_or(1.0, |it| region.share(frame.compositing, it));
                sums.add_share(share, layer_at(frame, layer, splats, x));
            }
            sums
        };
        let sums: Vec<SheetSums> = frame.sheets.iter().zip(&splats).map(in_sheet).collect();
        let hits = surfaces.hits(&frame.view, at);
        mean_of_samples(&hits, frame.background, |depth| composited(frame, &sums, depth))
    };
    (0..frame.view.width()).map(pixel).collect()
}

/// What a ray that ends at a depth, or nowhere, composites of the sums of sheets.
fn composited(frame: &Frame, sums: &[SheetSums], depth: Option<f64>) -> Premultiplied {
    let mut pixel = Premultiplied::default();
    for (sheet, sums) in frame.sheets.iter().zip(sums) {
        let share = depth.map_or(1.0, |depth| {
            let faces = sheet.faces.expect("only slabs have depths up to which they count");
            share_before(frame.compositing, faces, depth)
        });
        let mut before = SheetSums::new(frame.compositing);
        before.add_share(share, *sums);
        pixel.lay_over(before.finish());
    }
    pixel
}

/// The splats of a sheet that may reach row `y`, layer by layer.
fn splats<'a>(frame: &'a Frame, sheet: &Sheet, y: u32) -> Vec<Vec<Splat<'a>>> {
    let of_layer = |(layer, splats): (&'a LayerInView, &Vec<SheetSplat>)| {
        let splat = |&SheetSplat { voxel_idx, cut }: &SheetSplat| {
            let voxel = &layer.voxels[voxel_idx];
            let own_depth = voxel.center_in_view.z;
            let plane_depth = sheet.faces.map_or(own_depth, |[front, back]| 0.5 * (front + back));
            let stretch = layer.stretch.at(&frame.view, plane_depth);
            let offset_up = frame.view.row_in_view(y, plane_depth) - voxel.center_in_view.y;
            Splat { voxel, cut, plane_depth, stretch, offset_up }
        };
        let may_reach =
            |splat: &Splat<'_>| splat.offset_up.abs() <= splat.stretch * layer.kernel.reach;
        splats.iter().map(splat).filter(may_reach).collect()
    };
    frame.layers.iter().zip(&sheet.splats).map(of_layer).collect()
}

/// What a layer sums up in a sheet, uncut.
fn layer_at(frame: &Frame, layer: &LayerInView, splats: &[Splat<'_>], x: u32) -> SheetSums {
    let mut sums = SheetSums::new(frame.compositing);
    for splat in splats {
        let center = splat.voxel.center_in_view;
        let offset_right = frame.view.column_in_view(x, splat.plane_depth) - center.x;
        let offset = [offset_right, splat.offset_up];
        // A root for each would take longer than most of the rest.
        let distance_squared = offset_right * offset_right + splat.offset_up * splat.offset_up;
        if (splat.stretch * layer.kernel.reach).powi(2) < distance_squared {
            continue;
        }
        let weight = layer.kernel.stretched_weight(splat.cut, offset, center.z, splat.stretch);
        sums.add(weight, splat.voxel.opacity, splat.voxel.color);
    }
    sums
}
