//! Which array is the image, and where its voxels are.

use serde_json::Value;
use slabsplat_core::Grid;
use slabsplat_core::glam::{DAffine3, DMat3, DVec3};

use super::super::array_axes::VolumeAxes;
use super::super::choices::{Choice, Part, VolumeChoices};
use super::super::colors::{Meaning, Values};
use super::super::formats::Input;
use super::super::placed::Axis;
use super::super::units;
use super::super::window::Window;
use super::meta::{ArrayMeta, shown};
use super::tree::{Tree, joined};
use crate::IoError;
use crate::memory::free_bytes;

/// An array, and what of it is the volume.
pub(super) struct Image {
    /// The key of the array's folder.
    pub(super) key: String,
    pub(super) array: ArrayMeta,
    /// What is kept of each axis of the array, the slowest first.
    pub(super) axes: Vec<Axis>,
    pub(super) dims: [usize; 3],
    /// World lengths of a step, and the first voxel's place, in millimetres.
    spacing: [f64; 3],
    origin: [f64; 3],
    pub(super) choices: VolumeChoices,
    pub(super) warnings: Vec<String>,
    /// Whether no more than a box of the volume is kept, which need not have a chunk.
    pub(super) is_box: bool,
}

/// A folder with an array, with several levels of an image, or with images.
struct Node {
    attributes: Value,
    array: Option<ArrayMeta>,
}

/// An axis of an image.
struct NamedAxis {
    role: Role,
    millimetres: Option<f64>,
}

#[derive(Clone, Copy, PartialEq)]
enum Role {
    Space(usize),
    Channel,
    Time,
    Other,
}

/// Levels, and images in one file.
const MAX_PARTS: usize = 1000;

impl Image {
    pub(super) fn find(input: &Input<'_>, tree: &Tree<'_>) -> Result<Self, IoError> {
        let asked = input.options.array.as_deref().unwrap_or_default();
        let key = joined("", asked).ok_or_else(|| {
            IoError::unsupported(input.path, format!("there is no array {}", shown(asked)))
        })?;
        let mut node = Node::read(input, tree, &key)?;
        let mut key = key;
        let mut series = Choice::default();
        if node.attributes.get("bioformats2raw.layout").is_some() {
            let has = |n: &usize| {
                let below =
                    |mark: &str| tree.has(&format!("{}/{mark}", below(&key, &n.to_string())));
                below(".zattrs") || below("zarr.json")
            };
            let n = (0..MAX_PARTS).take_while(has).count().max(1);
            series = input.choose(Part::Series, n)?;
            key = below(&key, &series.chosen.to_string());
            node = Node::read(input, tree, &key)?;
        }
        let mut image = match (node.array, node.attributes["multiscales"].as_array()) {
            (Some(array), _) => Self::of_array(input, key, array)?,
            (None, Some(multiscales)) => Self::of_levels(input, tree, &key, multiscales)?,
            (None, None) => {
                let is_plate = node.attributes.get("plate").is_some();
                let what = if is_plate {
                    "the file is a plate of many images: open one of them, as a.zarr/A/1/0"
                } else {
                    "the file has no image of several levels: open an array in it, as a.zarr/name"
                };
                return Err(IoError::unsupported(input.path, what));
            }
        };
        if 1 < series.n {
            image.choices.series = series;
        }
        Ok(image)
    }

    pub(super) fn grid(&self, input: &Input<'_>) -> Result<Grid, IoError> {
        let matrix = DMat3::from_diagonal(DVec3::from_array(self.spacing));
        let place = DAffine3::from_mat3_translation(matrix, DVec3::from_array(self.origin));
        Grid::new_large(self.dims, place)
            .map_err(|source| IoError::Grid { path: input.path.to_owned(), source })
    }

    /// Keeps of the volume no more than a box.
    ///
    /// # Errors
    /// If it has to be looked at whole, which says what it is.
    pub(super) fn keep(&mut self, window: &Window) -> Result<(), &'static str> {
        window.keep(&mut self.axes, &self.choices, self.array.stored)?;
        self.is_box = true;
        Ok(())
    }

    /// An array by itself: z, y, x.
    fn of_array(input: &Input<'_>, key: String, array: ArrayMeta) -> Result<Self, IoError> {
        let VolumeAxes { dims, mut axes, choices } =
            VolumeAxes::of(input, &array.shape, array.stored)?;
        axes.reverse();
        let what = "the array does not say how large its voxels are: 1 x 1 x 1 was assumed";
        let warnings = vec![what.to_owned()];
        let (spacing, origin) = ([1.0; 3], [0.0; 3]);
        Ok(Self { key, array, axes, dims, spacing, origin, choices, warnings, is_box: false })
    }

    fn of_levels(
        input: &Input<'_>,
        tree: &Tree<'_>,
        key: &str,
        multiscales: &[Value],
    ) -> Result<Self, IoError> {
        let malformed = |what: &str| IoError::malformed(input.path, what);
        let series = input.choose(Part::Series, multiscales.len().clamp(1, MAX_PARTS))?;
        let image =
            multiscales.get(series.chosen).ok_or_else(|| malformed("the image has no levels"))?;
        let datasets = image["datasets"].as_array().map(Vec::as_slice).unwrap_or_default();
        let datasets = &datasets[..datasets.len().min(MAX_PARTS)];
        let mut levels = Vec::new();
        for dataset in datasets {
            let path = dataset["path"].as_str().and_then(|path| joined(key, path));
            let key =
                path.ok_or_else(|| malformed("a level of the image has a path that cannot be"))?;
            let array = Node::read(input, tree, &key)?.array;
            levels.push((key, array.ok_or_else(|| malformed("a level of the image is no array"))?));
        }
        // Boxes are there to have room.
        let is_box = input.options.voxels.is_some();
        let finest = levels.iter().position(|(_, array)| is_box || has_room(array, image));
        let chosen = finest.unwrap_or(levels.len().saturating_sub(1));
        let level = Choice { n: levels.len().max(1), names: Vec::new(), chosen };
        let level = input.choose_of(Part::Level, level)?;
        if levels.len() <= level.chosen {
            return Err(malformed("the image has no levels"));
        }
        let (key, array) = levels.swap_remove(level.chosen);
        let mut found = Self::of_level(input, key, array, image, &datasets[level.chosen])?;
        found.choices.level = level;
        found.choices.series = series;
        Ok(found)
    }

    fn of_level(
        input: &Input<'_>,
        key: String,
        array: ArrayMeta,
        image: &Value,
        dataset: &Value,
    ) -> Result<Self, IoError> {
        let unsupported = |what: String| IoError::unsupported(input.path, what);
        let mut warnings = Vec::new();
        let axes = named_axes(image, array.shape.len(), &mut warnings).map_err(unsupported)?;
        let [mut spacing, mut origin, mut dims] = [[1.0; 3], [0.0; 3], [1.0; 3]];
        let count = |role: Role| {
            let at = axes.iter().position(|axis| axis.role == role);
            at.map_or(1, |at| array.shape[at])
        };
        // Channels of a microscope, unless somebody says otherwise.
        let values =
            Values { n: count(Role::Channel), stored: array.stored, meaning: Meaning::Other };
        let time = input.choose(Part::Time, count(Role::Time))?;
        let choices = VolumeChoices { time, ..input.choose_values(&values)? };
        let transforms =
            [&dataset["coordinateTransformations"], &image["coordinateTransformations"]];
        let mut said_scale = false;
        for (at, axis) in axes.iter().enumerate() {
            let Role::Space(along) = axis.role else { continue };
            let (mut scale, mut shift) = (1.0, 0.0);
            for transform in transforms.iter().filter_map(|list| list.as_array()).flatten() {
                let number = |name: &str| transform[name][at].as_f64();
                match transform["type"].as_str() {
                    Some("scale") => {
                        let factor = number("scale").ok_or_else(|| {
                            unsupported("a scale of the image is no list of numbers".to_owned())
                        })?;
                        (scale, shift, said_scale) = (scale * factor, shift * factor, true);
                    }
                    Some("translation") => shift += number("translation").unwrap_or(0.0),
                    Some("identity") | None => {}
                    Some(other) => {
                        return Err(unsupported(format!(
                            "a transformation of type {} cannot be read",
                            shown(other)
                        )));
                    }
                }
            }
            let unit = axis.millimetres.unwrap_or(1.0);
            (spacing[along], origin[along]) = (scale * unit, shift * unit);
            dims[along] = array.shape[at] as f64;
        }
        if !said_scale {
            warnings.push(units::NO_SIZE.to_owned());
        }
        let dims = dims.map(|len| len as usize);
        let each = choices.n_read();
        let strides = [each, each.saturating_mul(dims[0])];
        let strides = [strides[0], strides[1], strides[1].saturating_mul(dims[1])];
        let kept = axes.iter().zip(&array.shape).map(|(axis, &len)| match axis.role {
            Role::Space(along) => Axis::whole(len, strides[along]),
            Role::Channel => choices.axis_of_values(),
            Role::Time => Axis::one(len, choices.time.chosen),
            Role::Other => Axis::one(len, 0),
        });
        let axes = kept.collect();
        Ok(Self { key, array, axes, dims, spacing, origin, choices, warnings, is_box: false })
    }
}

impl Node {
    fn read(input: &Input<'_>, tree: &Tree<'_>, key: &str) -> Result<Self, IoError> {
        let unsupported = |what: String| IoError::unsupported(tree.path_of(key), what);
        if let Some(mut meta) = tree.json(&below(key, "zarr.json"))? {
            let is_array = meta["node_type"] == "array";
            let array =
                is_array.then(|| ArrayMeta::of_v3(&meta)).transpose().map_err(unsupported)?;
            let mut attributes = meta["attributes"].take();
            if attributes.get("ome").is_some() {
                attributes = attributes["ome"].take();
            }
            return Ok(Self { attributes, array });
        }
        let array = tree.json(&below(key, ".zarray"))?;
        let attributes = tree.json(&below(key, ".zattrs"))?;
        if array.is_none() && attributes.is_none() && !tree.has(&below(key, ".zgroup")) {
            let what = format!("there is no array or image {} in it", shown(key));
            return Err(IoError::malformed(input.path, what));
        }
        let array = array.map(|meta| ArrayMeta::of_v2(&meta)).transpose().map_err(unsupported)?;
        Ok(Self { attributes: attributes.unwrap_or_default(), array })
    }
}

fn below(key: &str, name: &str) -> String {
    if key.is_empty() { name.to_owned() } else { format!("{key}/{name}") }
}

/// Whether a level takes no more than half of the memory that is free, and no more voxels than a grid has.
fn has_room(array: &ArrayMeta, image: &Value) -> bool {
    let axes = named_axes(image, array.shape.len(), &mut Vec::new()).unwrap_or_default();
    let in_space = axes.iter().zip(&array.shape);
    let in_space = in_space.filter(|(axis, _)| matches!(axis.role, Role::Space(_)));
    let n_voxels = in_space.fold(1, |n: u64, (_, &len)| n.saturating_mul(len as u64));
    let n_bytes = n_voxels.saturating_mul(array.stored.widest().size_bytes() as u64);
    n_voxels <= u64::from(u32::MAX) && n_bytes <= free_bytes().unwrap_or(u64::MAX) / 2
}

/// The axes of an image: by their names, or as older versions have them.
fn named_axes(
    image: &Value,
    n_axes: usize,
    warnings: &mut Vec<String>,
) -> Result<Vec<NamedAxis>, String> {
    let list = image["axes"].as_array().cloned().unwrap_or_else(|| {
        let names = ["t", "c", "z", "y", "x"];
        names[names.len().saturating_sub(n_axes)..].iter().map(|name| Value::from(*name)).collect()
    });
    if list.len() != n_axes {
        return Err(format!("the image names {} axes, and its array has {n_axes}", list.len()));
    }
    let mut has_unit = true;
    let mut axes = Vec::new();
    for axis in &list {
        let name = axis.as_str().or(axis["name"].as_str()).unwrap_or_default();
        let role = match (axis["type"].as_str(), name) {
            (Some("time"), _) | (None, "t") => Role::Time,
            (Some("channel"), _) | (None, "c") => Role::Channel,
            (_, "x" | "X") => Role::Space(0),
            (_, "y" | "Y") => Role::Space(1),
            (_, "z" | "Z") => Role::Space(2),
            _ => Role::Other,
        };
        let unit = axis["unit"].as_str();
        let millimetres = unit.and_then(units::millimetres);
        if matches!(role, Role::Space(_)) {
            if let (Some(unit), None) = (unit, millimetres) {
                warnings.push(units::unknown(unit));
            }
            has_unit &= unit.is_some();
        }
        axes.push(NamedAxis { role, millimetres });
    }
    let roles: Vec<Role> = axes.iter().map(|axis| axis.role).collect();
    let is_twice = |(at, role): (usize, &Role)| *role != Role::Other && roles[..at].contains(role);
    if roles.iter().enumerate().any(is_twice)
        || ![0, 1].iter().all(|a| roles.contains(&Role::Space(*a)))
    {
        return Err("the image has not one x, one y and at most one z".to_owned());
    }
    if !has_unit {
        warnings
            .push("the file does not say a unit of length: millimetres were assumed".to_owned());
    }
    Ok(axes)
}
