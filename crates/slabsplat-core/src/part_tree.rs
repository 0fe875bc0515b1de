//! A k-d tree of parts (model §17): a grid cut into boxes, and the order in which an eye sees them.

use crate::grid::BRICK_SIDE;
use crate::{Camera, Grid, Part, Plane, Projection};
use glam::{BVec3, DVec3};
use std::ops::Range;

/// A k-d tree over the voxels of a grid, whose leaves are boxes; seen from anywhere they have an order in
/// which none is behind one that comes later.
///
/// The faces of boxes lie half way between voxels. Those that are also the grid's have no end, so that all
/// of the world is in some box.
#[derive(Clone, Debug)]
pub struct PartTree {
    grid: Grid,
    root: Node,
}

/// A box of a grid's voxels, and the part of the world that is drawn of it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PartBox {
    /// First and last voxels along x, y and z, the last not included; none is empty.
    pub voxels: [Range<usize>; 3],
    /// What is drawn of it.
    pub part: Part,
}

/// How far outside of a part voxels of a grid may have a share in its picture.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PartSupport {
    /// Steps of the grid along each of its axes.
    pub steps: [f64; 3],
    /// The coarsest level of cells by which it may be drawn ([model §16](crate::model)); 0 if by its voxels.
    pub coarsest: u32,
}

/// How many voxels around a brick of cells gradients look at.
const OF_GRADIENTS: usize = 1;

impl PartSupport {
    /// So many steps, of voxels alone.
    pub fn of_voxels(steps: [f64; 3]) -> Self {
        Self { steps, coarsest: 0 }
    }

    /// The same with cells of levels up to that one.
    #[must_use]
    pub fn with_cells(self, coarsest: u32) -> Self {
        Self { coarsest, ..self }
    }

    /// The voxels of a grid that may have a share in the picture of a box of some of its voxels, along an
    /// axis of `n`, in whole bricks.
    pub fn around(&self, axis: usize, voxels: &Range<usize>, n: usize) -> Range<usize> {
        let steps = self.steps[axis].ceil() as usize;
        self.in_bricks(voxels.start.saturating_sub(steps)..n.min(voxels.end + steps), n)
    }

    /// All of the bricks that some voxels are of, along an axis of `n`. Of a brick of cells all is there, as
    /// that decides whether it is drawn.
    fn in_bricks(&self, voxels: Range<usize>, n: usize) -> Range<usize> {
        let whole = |of: Range<usize>, side: usize| {
            of.start / side * side..of.end.next_multiple_of(side).min(n)
        };
        if self.coarsest == 0 {
            return whole(voxels, BRICK_SIDE);
        }
        let Range { start, end } = whole(voxels, BRICK_SIDE << self.coarsest);
        whole(start.saturating_sub(OF_GRADIENTS)..n.min(end + OF_GRADIENTS), BRICK_SIDE)
    }
}

#[derive(Clone, Debug)]
enum Node {
    Leaf(PartBox),
    Split {
        /// The near side has `n·x < d`.
        plane: Plane,
        sides: Box<[Node; 2]>,
    },
}

impl PartTree {
    /// Cuts a grid, and a world of which `center` is the centre, into boxes: `cut` is given a box of voxels
    /// and returns an axis and the first voxel along it that goes to the far side, or nothing if the box is
    /// good as it is, or is one voxel alone.
    ///
    /// # Panics
    /// If a cut leaves one side empty.
    pub fn new(
        grid: &Grid,
        center: DVec3,
        mut cut: impl FnMut(&[Range<usize>; 3]) -> Option<(usize, usize)>,
    ) -> Self {
        let voxels = grid.dims().map(|n| 0..n);
        let whole = PartBox { voxels, part: Part::whole(center) };
        Self { grid: *grid, root: Node::cut(grid, whole, &mut cut) }
    }

    /// The grid that was cut.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// All boxes in the order in which `camera` sees them, the nearest first.
    pub fn seen_by(&self, camera: &Camera) -> Vec<&PartBox> {
        let mut boxes = Vec::new();
        self.root.add_seen_by(camera, &mut boxes);
        boxes
    }

    /// The same in at most so many groups, one at least, of as many boxes as can be: each with the part of
    /// the world that its boxes are together.
    pub fn groups_seen_by(&self, camera: &Camera, n_most: usize) -> Vec<(Part, Vec<&PartBox>)> {
        let mut groups = vec![Group::of(Part::whole(self.root.center()), &self.root, camera)];
        while groups.len() < n_most {
            let largest = (0..groups.len()).rev().max_by_key(|idx| groups[*idx].boxes.len());
            let idx = largest.expect("there is one group at least");
            let Some(sides) = groups[idx].split(camera) else { break };
            groups.splice(idx..=idx, sides);
        }
        groups.into_iter().map(|group| (group.part, group.boxes)).collect()
    }

    /// The voxels of `grid`, which may be that of another layer, that may have a share in the picture of a
    /// box, and all of the bricks of 8³ that these are of, since what is rounded is rounded brick by brick;
    /// always some, the nearest if there is none.
    pub fn voxels_near(
        &self,
        of: &PartBox,
        grid: &Grid,
        support: &PartSupport,
    ) -> [Range<usize>; 3] {
        let steps = support.steps;
        let [min, max] = self.ends_in(of, grid, steps);
        [0, 1, 2].map(|axis| {
            let n = grid.dims()[axis];
            let at = |index: f64| index.clamp(0.0, (n - 1) as f64) as usize;
            let first = at((min[axis] - steps[axis]).ceil());
            let end = at((max[axis] + steps[axis]).floor()).max(first) + 1;
            support.in_bricks(first..end, n)
        })
    }

    /// The least and the greatest corner, in the index space of `grid`, of what a box holds of all that lies
    /// no more than so many steps of that grid outside of it.
    fn ends_in(&self, of: &PartBox, grid: &Grid, steps: [f64; 3]) -> [DVec3; 2] {
        let voxels = of.voxels.each_ref().map(|range| [range.start as f64, range.end as f64]);
        let [first, end] = [0, 1].map(|side| DVec3::from_array(voxels.map(|ends| ends[side])));
        let [first, last] = [first - 0.5, end - 0.5];
        if grid.uncropped() == self.grid.uncropped() {
            let moved = [self.grid, *grid].map(|grid| grid.first_voxel().map(|c| c as f64));
            let [own, other] = moved.map(DVec3::from_array);
            return [first + own - other, last + own - other];
        }
        let [first, last] = self.where_endless(of, [first, last], grid, steps);
        let map = grid.index_from_world() * self.grid.world_from_index();
        bounds((0..8).map(|corner: u8| {
            let is_last = [0, 1, 2].map(|axis| corner >> axis & 1 == 1);
            map.transform_point3(DVec3::select(BVec3::from_array(is_last), last, first))
        }))
    }

    /// Lets a box that has no end along an axis end where `grid` does, so many steps further out.
    fn where_endless(
        &self,
        of: &PartBox,
        [first, last]: [DVec3; 2],
        grid: &Grid,
        steps: [f64; 3],
    ) -> [DVec3; 2] {
        let index_from_world = self.grid.index_from_world();
        let corners = grid.corners_in_world().map(|at| index_from_world.transform_point3(at));
        let [min, max] = bounds(corners);
        let map = index_from_world.matrix3 * grid.world_from_index().matrix3;
        let further = DVec3::from_array(
            [0, 1, 2].map(|axis| map.row(axis).abs().dot(DVec3::from_array(steps))),
        );
        let dims = self.grid.dims();
        let is_first = BVec3::from_array(of.voxels.each_ref().map(|range| range.start == 0));
        let is_last = BVec3::from_array([0, 1, 2].map(|axis| of.voxels[axis].end == dims[axis]));
        [
            DVec3::select(is_first, first.min(min - further), first),
            DVec3::select(is_last, last.max(max + further), last),
        ]
    }
}

/// The least and the greatest coordinates of some points.
fn bounds(points: impl Iterator<Item = DVec3>) -> [DVec3; 2] {
    let nothing = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    points.fold(nothing, |[min, max], at| [min.min(at), max.max(at)])
}

/// All boxes below a node.
struct Group<'a> {
    part: Part,
    node: &'a Node,
    boxes: Vec<&'a PartBox>,
}

impl<'a> Group<'a> {
    fn of(part: Part, node: &'a Node, camera: &Camera) -> Self {
        let mut boxes = Vec::new();
        node.add_seen_by(camera, &mut boxes);
        Self { part, node, boxes }
    }

    /// Both sides, the nearer one first; nothing if it is one box.
    fn split(&self, camera: &Camera) -> Option<[Self; 2]> {
        let Node::Split { plane, sides } = self.node else { return None };
        let [near, far] = &**sides;
        let [near_part, far_part] = self.part.split(*plane);
        let near = Self::of(near_part, near, camera);
        let far = Self::of(far_part, far, camera);
        Some(if is_reversed(plane, camera) { [far, near] } else { [near, far] })
    }
}

/// Whether a camera sees the far side of a plane before the near one.
fn is_reversed(plane: &Plane, camera: &Camera) -> bool {
    match camera.projection() {
        Projection::Orthographic { .. } => plane.normal().dot(camera.axes().forward) < 0.0,
        Projection::Perspective { .. } => 0.0 < plane.before(camera.eye()),
    }
}

impl Node {
    /// Of all of the world.
    fn center(&self) -> DVec3 {
        match self {
            Self::Leaf(leaf) => leaf.part.center(),
            Self::Split { sides, .. } => sides[0].center(),
        }
    }

    fn cut(
        grid: &Grid,
        whole: PartBox,
        cut: &mut impl FnMut(&[Range<usize>; 3]) -> Option<(usize, usize)>,
    ) -> Self {
        let Some((axis, at)) = cut(&whole.voxels) else { return Self::Leaf(whole) };
        let PartBox { voxels, part } = whole;
        let Range { start, end } = voxels[axis].clone();
        assert!(start < at && at < end, "a cut at {at} leaves one side of {start}..{end} empty");
        let plane = plane_before(grid, axis, at);
        let sides = part.split(plane).into_iter().zip([start..at, at..end]).map(|(part, range)| {
            let mut voxels = voxels.clone();
            voxels[axis] = range;
            Self::cut(grid, PartBox { voxels, part }, cut)
        });
        let sides: Vec<Self> = sides.collect();
        let sides: [Self; 2] = sides.try_into().expect("a plane has two sides");
        Self::Split { plane, sides: Box::new(sides) }
    }

    fn add_seen_by<'a>(&'a self, camera: &Camera, boxes: &mut Vec<&'a PartBox>) {
        match self {
            Self::Leaf(leaf) => boxes.push(leaf),
            Self::Split { plane, sides } => {
                let [near, far] = &**sides;
                let order = if is_reversed(plane, camera) { [far, near] } else { [near, far] };
                order.into_iter().for_each(|side| side.add_seen_by(camera, boxes));
            }
        }
    }
}

/// The plane half a step before the voxels of index `at` along an axis.
fn plane_before(grid: &Grid, axis: usize, at: usize) -> Plane {
    let index_from_world = grid.index_from_world();
    let normal = index_from_world.matrix3.row(axis);
    let distance = at as f64 - 0.5 - index_from_world.translation[axis];
    Plane::new(normal, distance).expect("a grid's matrix can be inverted")
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DAffine3, DMat3};

    fn sheared() -> Grid {
        let columns =
            [DVec3::new(2.0, 0.0, 0.3), DVec3::new(0.7, -1.0, 0.0), DVec3::new(0.0, 0.4, 3.0)];
        let [x, y, z] = columns;
        let placed = DAffine3::from_mat3_translation(DMat3::from_cols(x, y, z), DVec3::ONE);
        Grid::new([8, 7, 9], placed).unwrap()
    }

    /// Boxes of at most 50 voxels, cut across their longest side.
    fn tree(grid: &Grid) -> PartTree {
        PartTree::new(grid, grid.center_in_world(), |voxels| {
            let n = voxels.iter().map(Range::len).product::<usize>();
            let axis = (0..3).max_by_key(|axis| voxels[*axis].len()).unwrap();
            (50 < n).then(|| (axis, voxels[axis].start.midpoint(voxels[axis].end)))
        })
    }

    /// Groups are the boxes in their order, each with all of the world that is theirs.
    #[test]
    fn part_tree_has_groups_of_boxes() {
        let grid = sheared();
        let tree = tree(&grid);
        for eye in [[90.0, 20.0, 5.0], [-7.0, -90.0, 30.0]] {
            let camera = Camera::new(eye, [0.0; 3], DVec3::Y, parallel()).unwrap();
            let boxes = tree.seen_by(&camera);
            for n_most in [1, 2, 5, boxes.len(), 100] {
                let groups = tree.groups_seen_by(&camera, n_most);
                assert_eq!(groups.len(), n_most.min(boxes.len()));
                let in_groups: Vec<&PartBox> =
                    groups.iter().flat_map(|(_, boxes)| boxes.iter().copied()).collect();
                assert_eq!(in_groups, boxes);
                for at in grid.corners_in_world().chain([grid.center_in_world()]) {
                    for (part, boxes) in &groups {
                        let is_in_box = boxes.iter().any(|of| of.part.contains(at));
                        assert_eq!(part.contains(at), is_in_box, "{at}");
                    }
                }
            }
        }
    }

    #[test]
    fn part_tree_has_every_voxel_once() {
        let grid = sheared();
        let tree = tree(&grid);
        let camera = Camera::new([90.0, 20.0, 5.0], [0.0; 3], DVec3::Y, parallel()).unwrap();
        let boxes = tree.seen_by(&camera);
        assert!(8 < boxes.len(), "{}", boxes.len());
        for voxel_idx in 0..grid.n_voxels() {
            let at = grid.voxel_coords(voxel_idx);
            let in_world = DVec3::from_array(at.map(|c| c as f64));
            let in_world = grid.world_from_index().transform_point3(in_world);
            let holding: Vec<_> = boxes
                .iter()
                .filter(|of| (0..3).all(|axis| of.voxels[axis].contains(&at[axis])))
                .collect();
            assert_eq!(holding.len(), 1, "{at:?}");
            assert!(holding[0].part.contains(in_world), "{at:?}");
        }
    }

    fn parallel() -> Projection {
        Projection::Orthographic { view_height: 9.0 }
    }

    /// Along every ray, by its points.
    #[test]
    fn part_tree_is_seen_in_order() {
        let grid = sheared();
        let tree = tree(&grid);
        let middle = grid.center_in_world();
        let perspective = Projection::Perspective { fov_y_radians: 0.9 };
        for (idx, projection) in (0..40).flat_map(|idx| [(idx, parallel()), (idx, perspective)]) {
            let turn = f64::from(idx) * 0.7;
            let from = DVec3::new(turn.cos(), turn.sin(), (1.3 * turn).sin());
            let eye = middle + from * [3.0, 50.0][idx as usize % 2];
            let camera = Camera::new(eye, middle, DVec3::new(0.1, 0.2, 1.0), projection).unwrap();
            let boxes = tree.seen_by(&camera);
            let axes = camera.axes();
            for aside in [[0.0, 0.0], [3.0, 1.0], [-5.0, 4.0], [2.0, -7.0]] {
                let aside = axes.right * aside[0] + axes.up * aside[1];
                let (start, step) = match projection {
                    Projection::Orthographic { .. } => (eye + aside, axes.forward),
                    Projection::Perspective { .. } => (eye, axes.forward + 0.05 * aside),
                };
                let mut last = 0;
                for depth in 0..200 {
                    let point = start + step * f64::from(depth) * 0.5;
                    let at = boxes.iter().position(|of| of.part.contains(point)).unwrap();
                    assert!(last <= at, "{idx} {projection:?}: {last} {at}");
                    last = at;
                }
            }
        }
    }

    /// By hand: of bricks of cells all is there, and what gradients look at, to the brick of voxels.
    #[test]
    fn part_support_has_whole_bricks_of_cells() {
        let support = PartSupport::of_voxels([0.0; 3]);
        for (coarsest, expected) in [(0, 96..112), (1, 88..120), (2, 88..136), (3, 56..136)] {
            assert_eq!(support.with_cells(coarsest).in_bricks(100..110, 300), expected);
        }
        assert_eq!(support.with_cells(2).in_bricks(1..3, 300), 0..40);
        assert_eq!(PartSupport::of_voxels([3.0; 3]).around(1, &(11..16), 300), 8..24);
        assert_eq!(support.with_cells(3).in_bricks(100..110, 125), 56..125);
    }

    /// Along the axes of its own grid, to the brick.
    #[test]
    fn part_tree_finds_voxels_near_a_box() {
        let grid = Grid::new([40, 30, 50], sheared().world_from_index()).unwrap();
        let tree = PartTree::new(&grid, grid.center_in_world(), |voxels| {
            (voxels[0].len() == 40).then_some((0, 24))
        });
        let camera = Camera::new([90.0, 20.0, 5.0], [0.0; 3], DVec3::Y, parallel()).unwrap();
        let mut boxes = tree.seen_by(&camera);
        boxes.sort_by_key(|of| of.voxels[0].start);
        for (steps, expected) in [
            (0.0, [0..24, 24..40]),
            (0.4, [0..24, 24..40]),
            (0.6, [0..32, 16..40]),
            (9.0, [0..40, 8..40]),
        ] {
            for (of, along_x) in boxes.iter().zip(expected) {
                let near = tree.voxels_near(of, &grid, &PartSupport::of_voxels([steps, 0.0, 0.0]));
                assert_eq!(near, [along_x, 0..30, 0..50], "{steps}");
            }
        }
        // Of another grid all that may be in it, and of one far away the nearest.
        let columns = DMat3::from_diagonal(DVec3::new(0.5, 4.0, 1.0));
        for origin in [DVec3::ZERO, DVec3::splat(1e4)] {
            let other = DAffine3::from_mat3_translation(columns, origin);
            let other = Grid::new([37, 9, 21], other).unwrap();
            for of in &boxes {
                let near = tree.voxels_near(of, &other, &PartSupport::of_voxels([0.0; 3]));
                for at in (0..other.n_voxels()).map(|idx| other.voxel_coords(idx)) {
                    let in_index = DVec3::from_array(at.map(|c| c as f64));
                    let in_world = other.world_from_index().transform_point3(in_index);
                    let is_near = (0..3).all(|axis| near[axis].contains(&at[axis]));
                    assert!(is_near || !of.part.contains(in_world), "{at:?} {near:?}");
                }
                assert!(near.iter().all(|range| !range.is_empty()));
            }
        }
    }
}
