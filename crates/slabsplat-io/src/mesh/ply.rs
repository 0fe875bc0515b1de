//! PLY: elements of named properties, of which vertices, faces and edges are taken and all others passed
//! over.

use slabsplat_core::MeshParts;
use slabsplat_core::glam::DVec3;

use super::numbers::number;
use super::ply_header::{Element, Encoding, Header, Property, Scalar};
use super::{NO_VERTEX, add_polygon, add_polyline, next_vertex, take_as_points};

/// Of an element, in a message.
const MAX_NAME_CHARS: usize = 40;

/// Where numbers come from.
struct Numbers<'a> {
    encoding: Encoding,
    rest: &'a [u8],
}

/// What a property of a vertex is to a mesh.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Role {
    Position(usize),
    Normal(usize),
    Color(usize),
    Other,
}

pub(super) fn read(bytes: &[u8]) -> Result<MeshParts, String> {
    let Header { encoding, elements, data } = Header::read(bytes)?;
    let has_faces = elements.iter().any(|element| element.name == b"face");
    if !has_faces && elements.iter().any(|element| element.name == b"tristrips") {
        return Err("its faces are strips of triangles: save them as faces of their own".to_owned());
    }
    let mut numbers = Numbers { encoding, rest: data };
    let mut parts = MeshParts::default();
    for element in &elements {
        // Nothing would ever end a great number of elements without properties.
        if element.properties.is_empty() {
            continue;
        }
        for idx in 0..element.n {
            let read = match element.name {
                b"vertex" => read_vertex(&mut numbers, element, &mut parts),
                b"face" => read_face(&mut numbers, element, &mut parts),
                b"edge" => read_edge(&mut numbers, element, &mut parts),
                _ => element.properties.iter().try_for_each(|it| numbers.property(it, |_| {})),
            };
            let name: String =
                String::from_utf8_lossy(element.name).chars().take(MAX_NAME_CHARS).collect();
            read.map_err(|what| format!("{name} {idx} of {}: {what}", element.n))?;
        }
    }
    take_as_points(&mut parts);
    Ok(parts)
}

fn read_vertex(
    numbers: &mut Numbers<'_>,
    element: &Element<'_>,
    parts: &mut MeshParts,
) -> Result<(), String> {
    next_vertex(parts)?;
    let [mut position, mut normal, mut color] = [[f64::NAN; 3], [0.0; 3], [0.0; 3]];
    let (mut has_normal, mut has_color) = (false, false);
    for property in &element.properties {
        let role = Role::of(property);
        numbers.property(property, |number| match role {
            Role::Position(axis) => position[axis] = number,
            Role::Normal(axis) => normal[axis] = number,
            Role::Color(channel) => color[channel] = number / property.scalar.full_color(),
            Role::Other => {}
        })?;
        has_normal |= role == Role::Normal(2);
        has_color |= role == Role::Color(2);
    }
    parts.positions.push(DVec3::from_array(position));
    if has_normal {
        parts.normals.push(normal.map(|it| it as f32));
    }
    if has_color {
        parts.colors.push(color.map(|it| it as f32));
    }
    Ok(())
}

fn read_face(
    numbers: &mut Numbers<'_>,
    element: &Element<'_>,
    parts: &mut MeshParts,
) -> Result<(), String> {
    let mut corners = Vec::new();
    for property in &element.properties {
        let is_ours = matches!(property.name, b"vertex_indices" | b"vertex_index");
        numbers.property(property, |number| {
            if is_ours && property.count.is_some() {
                corners.push(vertex_numbered(number));
            }
        })?;
    }
    add_polygon(parts, &corners);
    Ok(())
}

fn read_edge(
    numbers: &mut Numbers<'_>,
    element: &Element<'_>,
    parts: &mut MeshParts,
) -> Result<(), String> {
    let mut ends = [NO_VERTEX; 2];
    for property in &element.properties {
        let end = [&b"vertex1"[..], b"vertex2"].iter().position(|name| property.name == *name);
        numbers.property(property, |number| {
            if let Some(end) = end.filter(|_| property.count.is_none()) {
                ends[end] = vertex_numbered(number);
            }
        })?;
    }
    add_polyline(parts, &ends);
    Ok(())
}

fn vertex_numbered(number: f64) -> u32 {
    if (0.0..f64::from(NO_VERTEX)).contains(&number) { number as u32 } else { NO_VERTEX }
}

impl Role {
    fn of(property: &Property<'_>) -> Self {
        if property.count.is_some() {
            return Self::Other;
        }
        match property.name {
            b"x" => Self::Position(0),
            b"y" => Self::Position(1),
            b"z" => Self::Position(2),
            b"nx" => Self::Normal(0),
            b"ny" => Self::Normal(1),
            b"nz" => Self::Normal(2),
            b"red" | b"r" | b"diffuse_red" => Self::Color(0),
            b"green" | b"g" | b"diffuse_green" => Self::Color(1),
            b"blue" | b"b" | b"diffuse_blue" => Self::Color(2),
            _ => Self::Other,
        }
    }
}

impl Numbers<'_> {
    /// Calls `take` with the number of a property, or with each of its list.
    fn property(
        &mut self,
        property: &Property<'_>,
        mut take: impl FnMut(f64),
    ) -> Result<(), String> {
        let Some(count) = property.count else {
            take(self.next(property.scalar)?);
            return Ok(());
        };
        let n = self.next(count)?;
        if n.fract() != 0.0 || n < 0.0 {
            return Err(format!("a list cannot have {n} numbers"));
        }
        for _ in 0..n as u64 {
            take(self.next(property.scalar)?);
        }
        Ok(())
    }

    fn next(&mut self, scalar: Scalar) -> Result<f64, String> {
        Ok(match scalar {
            _ if self.encoding == Encoding::Text => number(self.word()?)?,
            Scalar::I8 => i8::from_le_bytes(self.bytes()?).into(),
            Scalar::U8 => u8::from_le_bytes(self.bytes()?).into(),
            Scalar::I16 => i16::from_le_bytes(self.bytes()?).into(),
            Scalar::U16 => u16::from_le_bytes(self.bytes()?).into(),
            Scalar::I32 => i32::from_le_bytes(self.bytes()?).into(),
            Scalar::U32 => u32::from_le_bytes(self.bytes()?).into(),
            Scalar::F32 => f32::from_le_bytes(self.bytes()?).into(),
            Scalar::F64 => f64::from_le_bytes(self.bytes()?),
        })
    }

    fn word(&mut self) -> Result<&[u8], String> {
        let start = self.rest.trim_ascii_start();
        let end = start.iter().position(u8::is_ascii_whitespace).unwrap_or(start.len());
        let (word, rest) = start.split_at(end);
        self.rest = rest;
        if word.is_empty() { Err(CUT_OFF.to_owned()) } else { Ok(word) }
    }

    /// The next number, its lowest byte first.
    fn bytes<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let (bytes, rest) = self.rest.split_first_chunk::<N>().ok_or(CUT_OFF)?;
        self.rest = rest;
        let mut bytes = *bytes;
        if self.encoding == Encoding::BigEndian {
            bytes.reverse();
        }
        Ok(bytes)
    }
}

const CUT_OFF: &str = "the file ends before it";
