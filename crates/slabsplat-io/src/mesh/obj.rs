//! OBJ: vertices, normals, polygons, lines and points, one a line. Materials, textures and curves are
//! ignored.

use std::collections::HashMap;

use slabsplat_core::glam::DVec3;
use slabsplat_core::{MeshLayer, MeshParts};

use super::numbers::{number, numbers, quoted, words};
use super::{NO_VERTEX, add_polygon, add_polyline, next_vertex, take_as_points};

/// A file that is being read.
#[derive(Default)]
struct Reader {
    positions: Vec<DVec3>,
    /// None, or one for each position.
    colors: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    /// Whether any corner has a normal; then those without have that of their face.
    has_normals: bool,
    /// A vertex for each position that is used with a normal.
    parts: MeshParts,
    vertices: HashMap<Corner, u32>,
}

/// A position and a normal, by their numbers.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Corner {
    position: Option<usize>,
    normal: Option<usize>,
}

pub(super) fn read(bytes: &[u8]) -> Result<MeshParts, String> {
    let lines = || bytes.split(|byte| *byte == b'\n');
    let has_normals = lines().any(|line| words(line).next() == Some(b"vn"));
    let mut reader = Reader { has_normals, ..Reader::default() };
    for (line_idx, line) in lines().enumerate() {
        reader.read_line(line).map_err(|what| format!("line {}: {what}", line_idx + 1))?;
    }
    let mut parts = reader.into_parts();
    if !parts.colors.is_empty() {
        parts.colors.resize(parts.positions.len(), default_color());
    }
    Ok(parts)
}

impl Reader {
    fn read_line(&mut self, line: &[u8]) -> Result<(), String> {
        let mut words = words(line);
        match words.next() {
            Some(b"v") => self.add_position(&mut words),
            Some(b"vn") => {
                self.normals.push(numbers::<3>(&mut words)?.map(|it| it as f32));
                Ok(())
            }
            Some(b"f") => self.add_face(words),
            Some(b"l") => {
                let vertices = self.vertices_of(words)?;
                add_polyline(&mut self.parts, &vertices);
                Ok(())
            }
            Some(b"p") => {
                let vertices = self.vertices_of(words)?;
                self.parts.points.extend(vertices);
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// `x y z`, and maybe a weight or a colour, or both.
    fn add_position<'a>(
        &mut self,
        words: &mut impl Iterator<Item = &'a [u8]>,
    ) -> Result<(), String> {
        let position = numbers(words)?;
        let others = words.map(number).collect::<Result<Vec<f64>, _>>()?;
        if let [.., r, g, b] = others[..] {
            self.colors.resize(self.positions.len(), default_color());
            self.colors.push([r, g, b].map(|channel| channel as f32));
        } else if !self.colors.is_empty() {
            self.colors.push(default_color());
        }
        self.positions.push(DVec3::from_array(position));
        Ok(())
    }

    fn add_face<'a>(&mut self, words: impl Iterator<Item = &'a [u8]>) -> Result<(), String> {
        let corners = words.map(|word| self.corner(word)).collect::<Result<Vec<_>, _>>()?;
        let flat = self.flat_normal(&corners);
        let vertices = corners.into_iter().map(|corner| self.vertex(corner, flat));
        let vertices = vertices.collect::<Result<Vec<u32>, _>>()?;
        add_polygon(&mut self.parts, &vertices);
        Ok(())
    }

    /// Those of a line or of points, which have no normals.
    fn vertices_of<'a>(
        &mut self,
        words: impl Iterator<Item = &'a [u8]>,
    ) -> Result<Vec<u32>, String> {
        let corners = words.map(|word| self.corner(word)).collect::<Result<Vec<_>, _>>()?;
        corners.into_iter().map(|corner| self.vertex(corner, [0.0; 3])).collect()
    }

    /// All that was read; of a file that has nothing but positions these.
    fn into_parts(self) -> MeshParts {
        let mut parts = self.parts;
        if parts.positions.is_empty() {
            (parts.positions, parts.colors) = (self.positions, self.colors);
            parts.normals.clear();
            take_as_points(&mut parts);
        }
        parts
    }

    /// `position`, `position/texture`, `position//normal` or `position/texture/normal`.
    fn corner(&self, word: &[u8]) -> Result<Corner, String> {
        let mut parts = word.split(|byte| *byte == b'/');
        let position = index(parts.next().unwrap_or_default(), self.positions.len())?;
        let normal = parts.nth(1).filter(|word| !word.is_empty());
        let normal = normal.map(|word| index(word, self.normals.len())).transpose()?;
        Ok(Corner { position, normal: normal.flatten() })
    }

    /// That of a face without normals.
    fn flat_normal(&self, corners: &[Corner]) -> [f32; 3] {
        let mut positions = corners.iter().map(|corner| self.positions.get(corner.position?));
        let mut next = || positions.next().flatten().copied().unwrap_or(DVec3::NAN);
        let (a, b, c) = (next(), next(), next());
        (b - a).cross(c - a).normalize_or_zero().as_vec3().to_array()
    }

    /// The vertex of a corner; one of its own, if it has the normal of a flat face.
    fn vertex(&mut self, corner: Corner, flat: [f32; 3]) -> Result<u32, String> {
        if let Some(&vertex) = self.vertices.get(&corner) {
            return Ok(vertex);
        }
        let Some(position) = corner.position else { return Ok(NO_VERTEX) };
        let vertex = next_vertex(&self.parts)?;
        self.parts.positions.push(self.positions[position]);
        if !self.colors.is_empty() {
            self.parts.colors.resize(vertex as usize, default_color());
            self.parts.colors.push(self.colors[position]);
        }
        if self.has_normals {
            self.parts.normals.push(corner.normal.map_or(flat, |normal| self.normals[normal]));
        }
        if corner.normal.is_some() || !self.has_normals {
            self.vertices.insert(corner, vertex);
        }
        Ok(vertex)
    }
}

/// Counted from 1, or from −1 backwards; `None` if there is no such thing.
fn index(word: &[u8], n: usize) -> Result<Option<usize>, String> {
    let text = std::str::from_utf8(word).ok();
    let index = text.and_then(|text| text.parse::<i64>().ok());
    let index = index.ok_or_else(|| format!("{} is not the number of a vertex", quoted(word)))?;
    let n = n as i64;
    let from_zero = if index < 0 { n.saturating_add(index) } else { index - 1 };
    Ok((0..n).contains(&from_zero).then_some(from_zero as usize))
}

fn default_color() -> [f32; 3] {
    MeshLayer::DEFAULT_COLOR.map(|channel| channel as f32)
}
