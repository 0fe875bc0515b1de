//! STL: three corners a triangle, as text or in binary.
//!
//! Many a binary file begins with the word `solid`, by which text is meant to be told: its length decides.
//! The normals of a file are ignored; many are 0, and the order of corners says the same.

use slabsplat_core::MeshParts;
use slabsplat_core::glam::DVec3;

use super::numbers::{numbers, quoted, words};
use super::{add_polygon, next_vertex};

const HEADER_BYTES: usize = 84;

/// A normal, three corners, and two bytes that mean nothing.
const TRIANGLE_BYTES: usize = 50;

/// Whether a file is as long as its number of triangles asks for.
pub(super) fn is_binary(bytes: &[u8]) -> bool {
    n_triangles(bytes).is_some_and(|n| bytes.len() == HEADER_BYTES + n * TRIANGLE_BYTES)
}

pub(super) fn read(bytes: &[u8]) -> Result<MeshParts, String> {
    let is_text = bytes.trim_ascii_start().get(..5).is_some_and(is_solid);
    if is_text && !is_binary(bytes) { read_text(bytes) } else { read_binary(bytes) }
}

fn is_solid(word: &[u8]) -> bool {
    word.eq_ignore_ascii_case(b"solid")
}

fn n_triangles(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(HEADER_BYTES - 4..HEADER_BYTES)?;
    Some(u32::from_le_bytes(count.try_into().ok()?) as usize)
}

fn read_binary(bytes: &[u8]) -> Result<MeshParts, String> {
    let n = n_triangles(bytes).ok_or("not an STL file: it is shorter than a header")?;
    let triangles = bytes[HEADER_BYTES..].chunks_exact(TRIANGLE_BYTES).take(n);
    if triangles.len() < n {
        return Err(format!("cut off: it has {} of {n} triangles", triangles.len()));
    }
    let mut parts = MeshParts::default();
    for triangle in triangles {
        let (floats, _) = triangle.as_chunks::<4>();
        let coordinate = |idx: usize| f64::from(f32::from_le_bytes(floats[idx]));
        let corner = |idx: usize| DVec3::from_array([0, 1, 2].map(|axis| coordinate(idx + axis)));
        add_triangle(&mut parts, [corner(3), corner(6), corner(9)])?;
    }
    Ok(parts)
}

/// `vertex` lines make triangles, three each; that the others are as they should be is nobody's concern.
fn read_text(bytes: &[u8]) -> Result<MeshParts, String> {
    let mut parts = MeshParts::default();
    let mut corners = Vec::with_capacity(3);
    for (line_idx, line) in bytes.split(|byte| *byte == b'\n').enumerate() {
        let mut words = words(line);
        let Some(first) = words.next() else { continue };
        let at_line = |what: String| format!("line {}: {what}", line_idx + 1);
        match first.to_ascii_lowercase().as_slice() {
            b"vertex" => {
                let corner = numbers(&mut words).map_err(at_line)?;
                corners.push(DVec3::from_array(corner));
            }
            b"endfacet" => {
                let n_corners = corners.len();
                let corners = std::mem::take(&mut corners).try_into();
                let corners = corners
                    .map_err(|_| at_line(format!("a facet has 3 vertices, not {n_corners}")))?;
                add_triangle(&mut parts, corners)?;
            }
            b"solid" | b"facet" | b"outer" | b"endloop" | b"endsolid" => {}
            _ => return Err(at_line(format!("{} is no word of an STL file", quoted(first)))),
        }
    }
    if corners.is_empty() { Ok(parts) } else { Err("cut off within a facet".to_owned()) }
}

fn add_triangle(parts: &mut MeshParts, corners: [DVec3; 3]) -> Result<(), String> {
    let first = next_vertex(parts)?;
    parts.positions.extend(corners);
    next_vertex(parts)?;
    add_polygon(parts, &[first, first + 1, first + 2]);
    Ok(())
}
