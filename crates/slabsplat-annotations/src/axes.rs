//! The box around all that there is: its edges, which lie behind it, and coordinates along three of them.
//!
//! The box is that of the world's axes, so that coordinates are the world's, however a grid stands. Of its
//! edges those at which only faces meet that look to the eye are left out: they would lie before the volume.
//! Those between a face that does and one that does not are the outline, along which coordinates stand, as
//! nothing of the volume is outside of it.

use slabsplat_core::glam::{DVec2, DVec3};
use slabsplat_core::{Acquisition, Grid, Image, Orientation, Scene, round_ticks};

use crate::Ink;
use crate::lengths::Unit;
use crate::screen::Screen;
use crate::shapes::{Line, Pen, draw_lines};
use crate::sheet::{Sheet, Words, written};
use crate::text::{measure_text, text_size};

/// The least and the greatest corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds([DVec3; 2]);

/// An edge of a box.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Edge {
    axis: usize,
    ends: [DVec3; 2],
    /// How many of the two faces that meet there look to the eye.
    n_front: usize,
}

/// Parts of a face's ray and normal by which it looks to the eye; what is seen along has no front.
const FRONT_COSINE: f64 = 1e-6;

impl Bounds {
    /// Of all volumes and meshes; `None` if there are none.
    pub(crate) fn of(scene: &Scene) -> Option<Self> {
        let volumes = scene.layers.iter().flat_map(|layer| voxel_corners(layer.volume.grid()));
        let meshes = scene.meshes.iter().filter_map(slabsplat_core::MeshLayer::bounds).flatten();
        let points = volumes.chain(meshes).map(|point| [point, point]);
        points.reduce(|[min, max], [at, _]| [min.min(at), max.max(at)]).map(Self)
    }

    fn size(&self) -> DVec3 {
        self.0[1] - self.0[0]
    }

    fn middle(&self) -> DVec3 {
        self.0[0].midpoint(self.0[1])
    }

    /// Whether a face looks to the eye: that of an axis at its least or its greatest.
    fn is_front(&self, screen: &Screen, axis: usize, is_greatest: bool) -> bool {
        let end = self.0[usize::from(is_greatest)];
        let mut point = self.middle();
        point[axis] = end[axis];
        let outwards = DVec3::AXES[axis] * if is_greatest { 1.0 } else { -1.0 };
        let ray = screen.ray_to(point);
        ray.dot(outwards) < -FRONT_COSINE * ray.length()
    }

    fn edges(&self, screen: &Screen) -> Vec<Edge> {
        let edge = |axis: usize, is_greatest: [bool; 2]| {
            let across = [(axis + 1) % 3, (axis + 2) % 3];
            let mut ends = self.0;
            let mut n_front = 0;
            for (across, is_greatest) in across.into_iter().zip(is_greatest) {
                let at = self.0[usize::from(is_greatest)][across];
                ends.iter_mut().for_each(|end| end[across] = at);
                n_front += usize::from(self.is_front(screen, across, is_greatest));
            }
            Edge { axis, ends, n_front }
        };
        let corners = [[false, false], [false, true], [true, false], [true, true]];
        (0..3).flat_map(|axis| corners.map(|corner| edge(axis, corner))).collect()
    }
}

/// The corners of all voxels together, half a step beyond where the outermost sit.
fn voxel_corners(grid: &Grid) -> impl Iterator<Item = DVec3> + use<> {
    let (world_from_index, n_voxels) = (grid.world_from_index(), grid.dims().map(|n| n as f64));
    (0..8).map(move |corner: u8| {
        let is_last = [0, 1, 2].map(|axis| f64::from(corner >> axis & 1));
        world_from_index.transform_point3(DVec3::from(is_last) * DVec3::from(n_voxels) - 0.5)
    })
}

/// Draws the edges, for a picture behind which nothing but a background is.
pub(crate) fn draw_edges(image: &mut Image, scene: &Scene, screen: &Screen) {
    let Some(bounds) = Bounds::of(scene) else { return };
    let edges = bounds.edges(screen).into_iter().filter(|edge| edge.n_front < 2);
    let lines: Vec<Line> = edges.filter_map(|edge| screen.line(edge.ends)).collect();
    let pen = Pen::of_text(text_size(image.width(), image.height()));
    draw_lines(image, &lines, pen, Ink::on(scene.background_at(0.5)));
}

/// Draws coordinates along an outer edge of each axis.
pub(crate) fn draw_coordinates(
    sheet: &mut Sheet<'_>,
    scene: &Scene,
    screen: &Screen,
    acquisition: Acquisition,
) {
    let Some(bounds) = Bounds::of(scene) else { return };
    let unit = Unit::of_axis(bounds.size().max_element(), acquisition.is_metric);
    let edges = bounds.edges(screen);
    let middle = screen.point(bounds.middle());
    let mut n_without_room = 0;
    for axis in 0..3 {
        let outline = edges.iter().filter(|edge| edge.axis == axis && edge.n_front == 1);
        let scales = outline.filter_map(|edge| Scale::of(edge, screen, middle?, unit));
        let scales: Vec<Scale<'_>> = scales.collect();
        // At the left if they go up, else below.
        let go_up = scales.iter().all(Scale::goes_up);
        let place = |scale: &&Scale<'_>| if go_up { -scale.middle().x } else { scale.middle().y };
        let best = scales.iter().max_by(|a, b| place(a).total_cmp(&place(b)));
        let Some(scale) = best else { continue };
        n_without_room += usize::from(!scale.draw(sheet, name(axis, acquisition.orientation)));
    }
    if 0 < n_without_room {
        sheet.no_room_for("what is written on axes");
    }
}

/// Of a body, where coordinates grow.
fn name(axis: usize, orientation: Orientation) -> &'static str {
    match orientation {
        Orientation::Anatomical => ["R", "A", "S"][axis],
        Orientation::Unknown | Orientation::Pictures => ["x", "y", "z"][axis],
    }
}

/// An edge with coordinates.
#[derive(Clone, Debug)]
struct Scale<'a> {
    screen: &'a Screen,
    edge: &'a Edge,
    line: Line,
    unit: Unit,
    /// Away from the box, of length 1.
    outwards: DVec2,
}

impl<'a> Scale<'a> {
    /// `None` if the edge is seen as a point, or not at all.
    fn of(edge: &'a Edge, screen: &'a Screen, middle: DVec2, unit: Unit) -> Option<Self> {
        let line @ [from, to] = screen.line(edge.ends)?;
        let along = (to - from).try_normalize()?;
        let across = along.perp();
        let outwards = if 0.0 <= across.dot(from.midpoint(to) - middle) { across } else { -across };
        Some(Self { screen, edge, line, unit, outwards })
    }

    fn middle(&self) -> DVec2 {
        self.line[0].midpoint(self.line[1])
    }

    fn goes_up(&self) -> bool {
        let along = self.line[1] - self.line[0];
        along.x.abs() < along.y.abs()
    }

    /// Round coordinates in the unit, and where they are.
    fn ticks(&self, em: f64) -> Vec<(f64, DVec2)> {
        let [from, to] = self.edge.ends.map(|end| end[self.edge.axis] / self.unit.in_world);
        let length = self.line[0].distance(self.line[1]);
        let n_steps = (length / (3.2 * em)).clamp(1.0, 10.0) as u32;
        let at = |tick: f64| {
            let mut point = self.edge.ends[0];
            point[self.edge.axis] = tick * self.unit.in_world;
            self.screen.point(point)
        };
        // One coordinate alone is no scale.
        let ticks = (n_steps..n_steps + 4).map(|n_steps| round_ticks([from, to], n_steps));
        let ticks = ticks.into_iter().find(|ticks| 2 <= ticks.len()).unwrap_or_default();
        ticks.into_iter().filter_map(|tick| Some((tick, at(tick)?))).collect()
    }

    /// Draws ticks, coordinates and the axis' name; whether any coordinate had room.
    fn draw(&self, sheet: &mut Sheet<'_>, name: &str) -> bool {
        let size_pixels = sheet.text_size();
        let em = f64::from(size_pixels);
        let (ink, pen) = (sheet.ink_at(self.middle().y), sheet.pen());
        let ticks = self.ticks(em);
        let is_seen = |at: DVec2| at.cmpge(DVec2::ZERO).all() && at.cmple(sheet.size()).all();
        let ticks: Vec<_> = ticks.into_iter().filter(|(_, at)| is_seen(*at)).collect();
        let marks: Vec<Line> =
            ticks.iter().map(|(_, at)| [*at, *at + self.outwards * (0.4 * em)]).collect();
        draw_lines(sheet.image, &marks, pen, ink);
        let mut widest = DVec2::ZERO;
        let mut n_written = 0;
        for (tick, at) in &ticks {
            let text = written(*tick);
            let size = DVec2::from(measure_text(&text, size_pixels).map(f64::from));
            widest = widest.max(size);
            n_written += usize::from(self.write(sheet, &text, *at, 0.6 * em));
        }
        let title = match self.unit.symbol {
            "" => name.to_owned(),
            unit => format!("{name} ({unit})"),
        };
        let beyond = 0.9 * em + widest.dot(self.outwards.abs());
        let is_named = self.write_name(sheet, &title, em, beyond);
        0 < n_written && is_named
    }

    /// Writes what coordinates are of beyond them, beside the middle or else the ends of the edge.
    fn write_name(&self, sheet: &mut Sheet<'_>, name: &str, em: f64, beyond: f64) -> bool {
        let [from, to] = self.line;
        let along = (to - from).normalize_or_zero();
        let beside =
            [0.5, 0.35, 0.65, 0.2, 0.8].map(|part| (from.lerp(to, part), self.outwards, beyond));
        let ends = [(to, along, 0.9 * em), (from, -along, 0.9 * em)];
        beside
            .into_iter()
            .chain(ends)
            .any(|(at, way, distance)| sheet.write(&self.words(sheet, name, at, way, distance)))
    }

    /// Writes a coordinate outside of the box if that is in the picture, else within.
    fn write(&self, sheet: &mut Sheet<'_>, text: &str, at: DVec2, distance: f64) -> bool {
        let outside = self.words(sheet, text, at, self.outwards, distance);
        let inside = self.words(sheet, text, at, -self.outwards, distance);
        let words = if sheet.holds(outside.bounds()) { outside } else { inside };
        sheet.write(&words)
    }

    /// Words so far from a point, to one side of it.
    fn words<'t>(
        &self,
        sheet: &Sheet<'_>,
        text: &'t str,
        at: DVec2,
        way: DVec2,
        distance: f64,
    ) -> Words<'t> {
        let anchor = [0, 1].map(|axis| 0.5 - 0.5 * way[axis]);
        Words { text, at: at + way * distance, anchor, size_pixels: sheet.text_size() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::{
        Camera, Grid, ImageDesc, Layer, Projection, Scaling, TransferFunction, Volume,
    };

    const PARALLEL: Projection = Projection::Orthographic { view_height: 90.0 };

    fn screen(eye: [f64; 3], projection: Projection) -> Screen {
        let up = if eye[0] == 0.0 && eye[1] == 0.0 { DVec3::Y } else { DVec3::Z };
        let camera = Camera::new(eye, DVec3::ZERO, up, projection).unwrap();
        Screen::new(&camera, &ImageDesc { width: 300, height: 300, background: [0.0; 4] })
    }

    const BOX: Bounds = Bounds([DVec3::new(-20.0, -10.0, -15.0), DVec3::new(20.0, 10.0, 15.0)]);

    #[test]
    fn axes_box_is_around_all_voxels() {
        let grid = Grid::centered([4, 2, 3], [1.0, 2.0, 5.0]).unwrap();
        let volume = Volume::new(grid, vec![0_u8; 24].into(), Scaling::IDENTITY).unwrap();
        let transfer = TransferFunction::new([(0.0, 0.0)], [(0.0, [1.0; 3])]).unwrap();
        let camera = Camera::new([9.0, 0.0, 0.0], [0.0; 3], [0.0, 0.0, 1.0], PARALLEL).unwrap();
        let scene = Scene::new(Layer::new(volume, transfer), camera);
        let expected = DVec3::new(2.0, 2.0, 7.5);
        assert_eq!(Bounds::of(&scene), Some(Bounds([-expected, expected])));
        assert_eq!(Bounds::of(&Scene::of_meshes(Vec::new(), camera)), None);
    }

    /// Of a corner seen from afar three edges lie before the volume, and six are its outline.
    #[test]
    fn axes_edges_by_how_they_are_seen() {
        let counts = |eye, projection| {
            let edges = BOX.edges(&screen(eye, projection));
            assert_eq!(edges.len(), 12);
            [0, 1, 2].map(|n| edges.iter().filter(|edge| edge.n_front == n).count())
        };
        let perspective = Projection::Perspective { fov_y_radians: 0.6 };
        assert_eq!(counts([90.0, 80.0, 70.0], PARALLEL), [3, 6, 3]);
        assert_eq!(counts([90.0, 80.0, 70.0], perspective), [3, 6, 3]);
        assert_eq!(counts([0.0, 90.0, 0.0], PARALLEL), [8, 4, 0], "a face from before it");
        assert_eq!(counts([0.0, 1.0, 0.0], perspective), [12, 0, 0], "from within");
    }

    /// Ticks are where their coordinates are, and outside of the box.
    #[test]
    fn axes_ticks_are_round_and_in_place() {
        let screen = screen([90.0, 80.0, 70.0], PARALLEL);
        let unit = Unit::of_axis(40.0, true);
        let middle = screen.point(DVec3::ZERO).unwrap();
        for edge in BOX.edges(&screen).iter().filter(|edge| edge.n_front == 1) {
            let scale = Scale::of(edge, &screen, middle, unit).unwrap();
            let ticks = scale.ticks(11.0);
            assert!(2 <= ticks.len(), "{ticks:?}");
            for (tick, at) in ticks {
                assert_eq!(tick % 5.0, 0.0, "{tick}");
                let mut point = edge.ends[0];
                point[edge.axis] = tick;
                assert!(at.distance(screen.point(point).unwrap()) < 1e-9);
            }
            let corners = (0..8).map(|corner: u8| {
                let end = |axis: usize| BOX.0[usize::from(corner >> axis & 1)][axis];
                screen.point(DVec3::new(end(0), end(1), end(2))).unwrap()
            });
            for corner in corners {
                let beyond = (corner - scale.middle()).dot(scale.outwards);
                assert!(beyond < 1e-9, "{edge:?}: {beyond}");
            }
        }
    }

    #[test]
    fn axes_are_named_by_what_is_known() {
        assert_eq!([0, 1, 2].map(|axis| name(axis, Orientation::Anatomical)), ["R", "A", "S"]);
        assert_eq!([0, 1, 2].map(|axis| name(axis, Orientation::Pictures)), ["x", "y", "z"]);
    }
}
