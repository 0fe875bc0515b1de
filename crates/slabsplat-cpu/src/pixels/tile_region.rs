//! Where the rays of a tile's pixels are in a region (model §11).
//!
//! ```text
//! share of a slab = overlap of its depths with the ray's in the convex set / its thickness
//! ```
//!
//! Most slabs lie wholly within a region or wholly without, at all pixels of a tile or at all of a block:
//! that is decided by the least and the greatest depths there, and only the others are looked at pixel by
//! pixel.
//!
//! Where they are in a part of the world that is drawn alone (model §17) is the same.

use super::blocks::{BLOCK_SIDE, BLOCKS_ACROSS, Blocks};
use super::quad::{QUAD, Quad};
use super::rectangle::TILE_SIDE;
use super::sheet::Sheet;
use slabsplat_core::{PartInView, RegionInView, View, ViewRay};

/// A depth for each pixel.
type Depths = [[f32; TILE_SIDE]; TILE_SIDE];

/// The depths at which the rays of a tile enter and leave a convex set; infinite ones where they do not, from
/// +∞ to −∞ where they never meet it.
#[derive(Debug)]
pub(crate) struct TileRegion {
    starts: Box<Depths>,
    ends: Box<Depths>,
    blocks: [Extremes; BLOCKS_ACROSS * BLOCKS_ACROSS],
    all: Extremes,
    /// Whether the region is the complement of the convex set.
    is_inverted: bool,
    /// Whether a slab has a part in a region; if not, it is in it or not by its middle.
    splits_slabs: bool,
}

/// What has one interval of each ray.
#[derive(Clone, Copy, Debug)]
pub(crate) enum ConvexSet<'a> {
    Region(&'a RegionInView),
    Part(&'a PartInView),
}

impl ConvexSet<'_> {
    fn is_inverted(&self) -> bool {
        match self {
            Self::Region(region) => region.is_inverted(),
            Self::Part(_) => false,
        }
    }

    fn interval(&self, ray: &ViewRay) -> [f64; 2] {
        match self {
            Self::Region(region) => region.interval(ray),
            Self::Part(part) => part.interval(ray),
        }
    }
}

/// The least and the greatest of starts, and of ends.
#[derive(Clone, Copy, Debug)]
struct Extremes {
    starts: [f32; 2],
    ends: [f32; 2],
}

impl Default for TileRegion {
    fn default() -> Self {
        Self {
            starts: Box::new([[0.0; TILE_SIDE]; TILE_SIDE]),
            ends: Box::new([[0.0; TILE_SIDE]; TILE_SIDE]),
            blocks: [Extremes::OF_NOTHING; BLOCKS_ACROSS * BLOCKS_ACROSS],
            all: Extremes::OF_NOTHING,
            is_inverted: false,
            splits_slabs: true,
        }
    }
}

impl TileRegion {
    pub(crate) const BYTES: usize = size_of::<Self>() + 2 * size_of::<Depths>();

    /// Makes it that of the tile with that pixel of the image in its corner.
    pub(crate) fn update(
        &mut self,
        set: &ConvexSet<'_>,
        view: &View,
        [left, top]: [i64; 2],
        splits_slabs: bool,
    ) {
        self.is_inverted = set.is_inverted();
        self.splits_slabs = splits_slabs;
        self.blocks = [Extremes::OF_NOTHING; BLOCKS_ACROSS * BLOCKS_ACROSS];
        self.all = Extremes::OF_NOTHING;
        for row in 0..TILE_SIDE {
            for column in 0..TILE_SIDE {
                let pixel = [left + column as i64, top + row as i64].map(|p| p as f64 + 0.5);
                let [start, end] = set.interval(&view.ray(pixel)).map(|depth| depth as f32);
                (self.starts[row][column], self.ends[row][column]) = (start, end);
                self.blocks[row / BLOCK_SIDE * BLOCKS_ACROSS + column / BLOCK_SIDE].add(start, end);
                self.all.add(start, end);
            }
        }
    }

    /// The blocks of which any pixel may have a share of a slab.
    pub(crate) fn showing(&self, faces: [f32; 2]) -> Blocks {
        if self.is_inverted { self.held(faces).others() } else { self.met(faces) }
    }

    /// The blocks of which all pixels have all of a slab.
    fn showing_whole(&self, faces: [f32; 2]) -> Blocks {
        if self.is_inverted { self.met(faces).others() } else { self.held(faces) }
    }

    /// The blocks of which no pixel has anything behind a depth.
    pub(crate) fn over_from(&self, depth: f32) -> Blocks {
        let is_over = |of_block: &Extremes| {
            if self.is_inverted {
                of_block.starts[1] <= depth && of_block.ends[0] == f32::INFINITY
            } else {
                of_block.ends[1] <= depth
            }
        };
        self.blocks_where(is_over)
    }

    /// Multiplies what a sheet has summed of a slab with the shares of its pixels.
    pub(crate) fn cut(&self, sheet: &mut Sheet, faces: [f32; 2]) {
        let whole = self.showing_whole(faces);
        for [column, block_row] in sheet.touched.iter() {
            if whole.has([column, block_row]) {
                continue;
            }
            for row in block_row * BLOCK_SIDE..(block_row + 1) * BLOCK_SIDE {
                let shares = self.shares(row, column * QUAD, faces);
                scale(&mut sheet.sums[row][column], shares);
            }
        }
    }

    /// What part of a slab four pixels of a row have in the region.
    #[inline(always)]
    pub(crate) fn shares(&self, row: usize, first_column: usize, faces: [f32; 2]) -> [f32; QUAD] {
        let mut shares = [0.0; QUAD];
        for (idx, share) in shares.iter_mut().enumerate() {
            let column = first_column + idx;
            *share = self.share([self.starts[row][column], self.ends[row][column]], faces);
        }
        shares
    }

    /// Whether a pixel's ray is in the region at a depth.
    pub(crate) fn holds(&self, row: usize, column: usize, depth: f32) -> bool {
        let is_in_convex = self.starts[row][column] <= depth && depth < self.ends[row][column];
        is_in_convex != self.is_inverted
    }

    #[inline(always)]
    fn share(&self, [start, end]: [f32; 2], [front, back]: [f32; 2]) -> f32 {
        let of_convex = if self.splits_slabs {
            let overlap = end.min(back) - start.max(front);
            overlap.max(0.0) / (back - front)
        } else {
            let middle = 0.5 * (front + back);
            if start <= middle && middle < end { 1.0 } else { 0.0 }
        };
        if self.is_inverted { 1.0 - of_convex } else { of_convex }
    }

    /// The blocks of which all rays are in the convex set throughout a slab.
    fn held(&self, faces: [f32; 2]) -> Blocks {
        let faces = self.deciding(faces);
        if !self.all.meet(faces) {
            return Blocks::NONE;
        }
        if self.all.hold(faces) { Blocks::ALL } else { self.blocks_where(|of| of.hold(faces)) }
    }

    /// The blocks of which any ray may be in the convex set in a slab.
    fn met(&self, faces: [f32; 2]) -> Blocks {
        let faces = self.deciding(faces);
        if self.all.hold(faces) {
            return Blocks::ALL;
        }
        if self.all.meet(faces) { self.blocks_where(|of| of.meet(faces)) } else { Blocks::NONE }
    }

    /// The depths that decide about a slab.
    fn deciding(&self, [front, back]: [f32; 2]) -> [f32; 2] {
        if self.splits_slabs { [front, back] } else { [0.5 * (front + back); 2] }
    }

    fn blocks_where(&self, is_so: impl Fn(&Extremes) -> bool) -> Blocks {
        let mut blocks = Blocks::NONE;
        for (idx, extremes) in self.blocks.iter().enumerate() {
            if is_so(extremes) {
                blocks.add_one([idx % BLOCKS_ACROSS, idx / BLOCKS_ACROSS]);
            }
        }
        blocks
    }
}

impl Extremes {
    const OF_NOTHING: Self = Self {
        starts: [f32::INFINITY, f32::NEG_INFINITY],
        ends: [f32::INFINITY, f32::NEG_INFINITY],
    };

    fn add(&mut self, start: f32, end: f32) {
        self.starts = [self.starts[0].min(start), self.starts[1].max(start)];
        self.ends = [self.ends[0].min(end), self.ends[1].max(end)];
    }

    /// Whether all rays are in the convex set between those depths.
    fn hold(&self, [front, back]: [f32; 2]) -> bool {
        self.starts[1] <= front && back < self.ends[0]
    }

    /// Whether any ray may be in the convex set between those depths.
    fn meet(&self, [front, back]: [f32; 2]) -> bool {
        self.starts[0] <= back && front <= self.ends[1]
    }
}

fn scale(quad: &mut Quad, shares: [f32; QUAD]) {
    for channel in quad.0.as_chunks_mut::<QUAD>().0 {
        for (sum, share) in channel.iter_mut().zip(shares) {
            *sum *= share;
        }
    }
}
