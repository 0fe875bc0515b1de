//! Reading meshes, with lines and points: PLY, STL, OBJ. What cannot be drawn of one is left out, and a
//! warning says how much.
//!
//! The readers are our own: triangles that refer to nothing, or to NaN, must not cost the rest of the file,
//! and no count of a header is believed before its bytes are there.
//!
//! Reading order: this file, `numbers`, then a format each: `stl`, `obj`, `ply_header` and `ply`.

mod numbers;
mod obj;
mod ply;
mod ply_header;
mod stl;

use std::path::Path;

use slabsplat_core::{DroppedElements, Mesh, MeshParts};

use crate::IoError;
use crate::printable::shown_path;
use crate::store::Store;

/// A mesh, and what is worth knowing about where it came from.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct LoadedMesh {
    /// The mesh, where the file says that it is.
    pub mesh: Mesh,
    /// What it was read from.
    pub format: MeshFormat,
    /// What the file got wrong; one line each.
    pub warnings: Vec<String>,
}

/// What a mesh was read from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum MeshFormat {
    /// Stanford's polygon file format, as text or in binary numbers of either order.
    Ply,
    /// Stereolithography, as text or in binary.
    Stl,
    /// Wavefront's, without its materials.
    Obj,
}

/// Stands for a vertex that is not there.
const NO_VERTEX: u32 = u32::MAX;

impl MeshFormat {
    /// The format's name as it is written in prose.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ply => "PLY",
            Self::Stl => "STL",
            Self::Obj => "OBJ",
        }
    }

    /// By what the file begins with and how long it is, and by its name where that says nothing.
    fn of(path: &Path, bytes: &[u8]) -> Option<Self> {
        if ply_header::is_ply(bytes) {
            return Some(Self::Ply);
        }
        if stl::is_binary(bytes) {
            return Some(Self::Stl);
        }
        let extension = path.extension().and_then(|extension| extension.to_str());
        match extension.map(str::to_ascii_lowercase).as_deref() {
            Some("ply") => Some(Self::Ply),
            Some("stl") => Some(Self::Stl),
            Some("obj") => Some(Self::Obj),
            _ => None,
        }
    }
}

/// Whether a file's name is that of a mesh: `.ply`, `.stl` or `.obj`.
pub fn is_mesh_name(path: impl AsRef<Path>) -> bool {
    MeshFormat::of(path.as_ref(), &[]).is_some()
}

/// Reads a mesh: PLY (`.ply`), STL (`.stl`) or OBJ (`.obj`).
///
/// # Errors
/// If the file cannot be read, is in no such format, or is broken.
pub fn read_mesh(path: impl AsRef<Path>) -> Result<LoadedMesh, IoError> {
    read_from(Store::Disk, path.as_ref())
}

pub(crate) fn read_from(store: Store<'_>, path: &Path) -> Result<LoadedMesh, IoError> {
    let bytes = store.read(path)?;
    let format = MeshFormat::of(path, &bytes);
    let format = format.ok_or_else(|| IoError::UnknownMesh { path: path.to_owned() })?;
    let parts = match format {
        MeshFormat::Ply => ply::read(&bytes),
        MeshFormat::Stl => stl::read(&bytes),
        MeshFormat::Obj => obj::read(&bytes),
    };
    let parts = parts.map_err(|what| IoError::malformed(path, what))?;
    let given = [parts.triangles.len(), parts.lines.len(), parts.points.len()];
    let mesh = Mesh::new(parts).expect("a reader makes as many normals and colours as vertices");
    let warnings = warning(path, given, mesh.dropped()).into_iter().collect();
    Ok(LoadedMesh { mesh, format, warnings })
}

/// Of how many triangles, lines and points were given.
fn warning(path: &Path, given: [usize; 3], dropped: DroppedElements) -> Option<String> {
    let path = shown_path(path);
    let kinds = given.into_iter().zip(["triangles", "lines", "points"]).filter(|(n, _)| 0 < *n);
    let kinds: Vec<String> = kinds.map(|(n, what)| format!("{n} {what}")).collect();
    if kinds.is_empty() {
        return Some(format!("{path}: there are no triangles, no lines and no points"));
    }
    let DroppedElements { n_without_vertices, n_not_finite, n_flat, .. } = dropped;
    let reasons = [
        (n_without_vertices, "refer to vertices that are not there"),
        (n_not_finite, "have a corner that is not finite"),
        (n_flat, "have no area"),
    ];
    let reasons = reasons.into_iter().filter(|(n, _)| 0 < *n);
    let reasons: Vec<String> = reasons.map(|(n, what)| format!("{n} {what}")).collect();
    let n_all = dropped.n_all();
    (0 < n_all).then(|| {
        let (kinds, reasons) = (enumerated(&kinds), reasons.join(", "));
        format!("{path}: {n_all} of {kinds} are left out: {reasons}")
    })
}

/// As in prose.
fn enumerated(things: &[String]) -> String {
    match things {
        [others @ .., before, last] if !others.is_empty() => {
            format!("{}, {before} and {last}", others.join(", "))
        }
        _ => things.join(" and "),
    }
}

/// Adds the triangles of a polygon: those with its first corner and two that follow each other. One with
/// fewer than three corners counts as a triangle that cannot be drawn.
fn add_polygon(parts: &mut MeshParts, corners: &[u32]) {
    match corners {
        [first, others @ ..] if 1 < others.len() => {
            parts.triangles.extend(others.windows(2).map(|pair| [*first, pair[0], pair[1]]));
        }
        [first, ..] => parts.triangles.push([*first; 3]),
        [] => parts.triangles.push([NO_VERTEX; 3]),
    }
}

/// Adds the lines between points that follow each other. One with a single end counts as a line that cannot
/// be drawn.
fn add_polyline(parts: &mut MeshParts, vertices: &[u32]) {
    match vertices {
        [] | [_] => parts.lines.push([NO_VERTEX; 2]),
        _ => parts.lines.extend(vertices.windows(2).map(|pair| [pair[0], pair[1]])),
    }
}

/// Makes a point of every vertex of a file that has nothing but these: a point cloud.
fn take_as_points(parts: &mut MeshParts) {
    if parts.triangles.is_empty() && parts.lines.is_empty() && parts.points.is_empty() {
        parts.points = (0..parts.positions.len() as u32).collect();
    }
}

/// The number of the vertex that is added next.
fn next_vertex(parts: &MeshParts) -> Result<u32, String> {
    let next = u32::try_from(parts.positions.len()).ok().filter(|next| *next < NO_VERTEX);
    next.ok_or_else(|| "a mesh can have up to 4294967294 vertices".to_owned())
}

#[cfg(test)]
mod tests;
