//! What both kinds of VTK's files say of an image: where its points are, and which arrays it has.

use slabsplat_core::glam::{DAffine3, DMat3, DVec3};
use slabsplat_core::{Grid, SampleType};

use super::super::VolumeFormat;
use super::super::choices::{Choice, Part, VolumeChoices};
use super::super::colors::{Meaning, Values};
use super::super::formats::{Input, VolumeListing};
use super::super::stored::StoredType;
use crate::IoError;

/// Where the points of an image are.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Geometry {
    /// First and last index along each axis.
    pub(super) extent: Extent,
    /// Where the point of index 0, 0, 0 is.
    pub(super) origin: [f64; 3],
    pub(super) spacing: [f64; 3],
    /// The rows of a matrix, whose columns are the directions of the axes.
    pub(super) direction: [f64; 9],
}

/// First and last index along each axis.
pub(super) type Extent = [[i64; 2]; 3];

/// An array of an image, as far as its header says.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ArrayDesc {
    pub(super) name: String,
    /// `None` of those that are not numbers, or not here.
    pub(super) stored: Option<StoredType>,
    pub(super) type_name: String,
    pub(super) n_components: usize,
    /// Whether the file says that these are a colour.
    pub(super) is_color: bool,
    /// Whether it has a value for each cell, not each point.
    pub(super) is_of_cells: bool,
}

/// Which array was chosen, and what of it.
pub(super) struct Chosen {
    pub(super) array_idx: usize,
    pub(super) stored: StoredType,
    pub(super) choices: VolumeChoices,
}

/// VTK's own arrays, which say which values are none.
const BOOKKEEPING: &[&str] = &["vtkGhostType", "vtkValidPointMask", "vtkGhostLevels"];

impl Geometry {
    pub(super) const IDENTITY: Self = Self {
        extent: [[0, 0]; 3],
        origin: [0.0; 3],
        spacing: [1.0; 3],
        direction: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
    };

    /// Points along each axis, or cells.
    pub(super) fn dims(&self, is_of_cells: bool) -> Option<[usize; 3]> {
        dims(&self.extent, is_of_cells)
    }

    /// A cell's place is its middle.
    pub(super) fn grid(&self, input: &Input<'_>, is_of_cells: bool) -> Result<Grid, IoError> {
        let dims = self.dims(is_of_cells);
        let dims = dims.ok_or_else(|| IoError::malformed(input.path, self.no_extent()))?;
        let d = self.direction;
        let directions = DMat3::from_cols_array(&d).transpose();
        // An axis of one point needs no spacing, and is sometimes given 0.
        let is_flat = |axis: usize| dims[axis] == 1 && self.spacing[axis] == 0.0;
        let spacing = [0, 1, 2].map(|axis| if is_flat(axis) { 1.0 } else { self.spacing[axis] });
        let matrix = directions * DMat3::from_diagonal(DVec3::from_array(spacing));
        let first = [0, 1, 2].map(|axis| {
            let [first, last] = self.extent[axis];
            first as f64 + if is_of_cells && first < last { 0.5 } else { 0.0 }
        });
        let origin = DVec3::from_array(self.origin) + matrix * DVec3::from_array(first);
        Grid::new(dims, DAffine3::from_mat3_translation(matrix, origin))
            .map_err(|source| IoError::Grid { path: input.path.to_owned(), source })
    }

    pub(super) fn no_extent(&self) -> String {
        format!("the image cannot have the extent {:?}", self.extent)
    }
}

/// Points or cells along each axis; `None` if there are none.
pub(super) fn dims(extent: &Extent, is_of_cells: bool) -> Option<[usize; 3]> {
    let mut dims = [0; 3];
    for (n, [first, last]) in dims.iter_mut().zip(extent) {
        let n_steps = usize::try_from(last.checked_sub(*first)?).ok()?;
        *n = if is_of_cells { n_steps.max(1) } else { n_steps.checked_add(1)? };
    }
    Some(dims)
}

/// The array that is asked for, by name or number; else the one that the file calls its scalars, or else the
/// first with one value a point.
pub(super) fn choose(
    input: &Input<'_>,
    arrays: &[ArrayDesc],
    active: Option<&str>,
) -> Result<Chosen, IoError> {
    let names: Vec<String> = arrays.iter().map(|array| array.name.clone()).collect();
    if arrays.is_empty() {
        return Err(IoError::unsupported(input.path, "the image has no arrays of data"));
    }
    let named = |name: &str| names.iter().position(|other| other == name);
    let is_own =
        |array: &ArrayDesc| array.stored.is_some() && !BOOKKEEPING.contains(&array.name.as_str());
    let chosen = match &input.options.array {
        Some(asked) => named(asked).ok_or_else(|| {
            let there = names.iter().take(12).cloned().collect::<Vec<_>>().join(", ");
            let what = format!("there is no array {asked:?}: there is {there}");
            IoError::unsupported(input.path, what)
        })?,
        None => active
            .and_then(named)
            .or_else(|| arrays.iter().position(|array| is_own(array) && array.n_components == 1))
            .or_else(|| arrays.iter().position(is_own))
            .unwrap_or(0),
    };
    let mut series = Choice { n: arrays.len(), names, chosen };
    if input.options.array.is_none() {
        series = input.choose_of(Part::Series, series)?;
    }
    let array = &arrays[series.chosen];
    let stored = array.stored.ok_or_else(|| {
        let (name, type_name) = (&array.name, &array.type_name);
        let what = format!("the array {name:?} is of {type_name:?}, which cannot be samples");
        IoError::unsupported(input.path, what)
    })?;
    let meaning = if array.is_color { Meaning::Color } else { Meaning::Unsaid };
    let values = Values { n: array.n_components.max(1), stored, meaning };
    let choices = VolumeChoices { series, ..input.choose_values(&values)? };
    Ok(Chosen { array_idx: choices.series.chosen, stored, choices })
}

/// What would be read.
pub(super) fn listing(
    input: &Input<'_>,
    geometry: &Geometry,
    array: &ArrayDesc,
    chosen: Chosen,
) -> Result<VolumeListing, IoError> {
    let dims = geometry.dims(array.is_of_cells);
    let dims = dims.ok_or_else(|| IoError::malformed(input.path, geometry.no_extent()))?;
    let (sample_type, choices) = (chosen.stored.widest(), chosen.choices);
    Ok(VolumeListing { format: VolumeFormat::Vtk, dims, sample_type, choices })
}

/// A type by its name in XML.
pub(super) fn stored_type(name: &str) -> Option<StoredType> {
    Some(match name {
        "Int64" => StoredType::I64,
        "UInt64" => StoredType::U64,
        "Int8" => StoredType::Sample(SampleType::I8),
        "UInt8" => StoredType::Sample(SampleType::U8),
        "Int16" => StoredType::Sample(SampleType::I16),
        "UInt16" => StoredType::Sample(SampleType::U16),
        "Int32" => StoredType::Sample(SampleType::I32),
        "UInt32" => StoredType::Sample(SampleType::U32),
        "Float32" => StoredType::Sample(SampleType::F32),
        "Float64" => StoredType::Sample(SampleType::F64),
        _ => return None,
    })
}

/// A type by its name in legacy files, where `long` has 64 bits as on all machines but Windows.
pub(super) fn legacy_type(name: &str) -> Option<StoredType> {
    stored_type(match name.to_lowercase().as_str() {
        "unsigned_char" => "UInt8",
        "char" | "signed_char" => "Int8",
        "unsigned_short" => "UInt16",
        "short" => "Int16",
        "unsigned_int" => "UInt32",
        "int" => "Int32",
        "unsigned_long" | "vtktypeuint64" | "unsigned_long_long" => "UInt64",
        "long" | "vtktypeint64" | "long_long" | "vtkidtype" => "Int64",
        "float" => "Float32",
        "double" => "Float64",
        _ => return None,
    })
}
