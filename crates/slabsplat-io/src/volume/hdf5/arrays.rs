//! Which data set of a file is read, what its numbers are, and how large its voxels.

use hdf5_pure::{
    AttrValue, Dataset, Datatype, DatatypeByteOrder, File, FloatingPointLayout, Group,
    ReadSeekSource,
};
use slabsplat_core::{Grid, Scaling};

use super::super::array_axes::VolumeAxes;
use super::super::buffer::ReadFailure;
use super::super::choices::{Choice, Part};
use super::super::colors::Voxels;
use super::super::formats::{Input, VolumeListing};
use super::super::placed::Metered;
use super::super::stored::StoredType;
use super::super::stream::MAX_GZIP_RATIO;
use super::super::{Endian, LoadedVolume, VolumeFormat};
use super::refusals::{broken, refused};
use super::rows::Rows;
use crate::IoError;
use crate::printable::printable;
use crate::store::StoredFile;

/// Groups in groups; Imaris has four.
const MAX_DEPTH: usize = 16;

/// Groups that are looked into: links may lead round and round.
const MAX_GROUPS: usize = 4096;

/// Data sets that are listed.
const MAX_ARRAYS: usize = 4096;

/// Data sets that a message lists.
const MAX_LISTED: usize = 12;

/// A data set of so many bytes needs nothing in the file, since what was never written has its fill value.
const MAX_UNBACKED_BYTES: u64 = 256 << 20;

/// How large voxels are, in micrometres along z, y and x, as ilastik and ImageJ's HDF5 plugin write it.
const ELEMENT_SIZE: &str = "element_size_um";

/// A data set that can be read.
pub(super) struct Array {
    dataset: Dataset,
    shape: Vec<usize>,
    stored: StoredType,
    endian: Endian,
    axes: VolumeAxes,
    file_bytes: u64,
}

impl Array {
    pub(super) fn open(input: &Input<'_>) -> Result<Self, IoError> {
        let stored_file = input.store.open(input.path)?;
        let file_bytes = stored_file.n_bytes().map_err(IoError::read(input.path))?;
        let file = open_file(stored_file).map_err(|error| broken(input, &error))?;
        let (dataset, series) = choose(input, &file)?;
        let (stored, endian) =
            numbers(&dataset).map_err(|error| broken(input, &error))?.ok_or_else(|| {
                IoError::unsupported(input.path, "the data set holds no numbers that a volume has")
            })?;
        let shape = shape(&dataset).map_err(|error| broken(input, &error))?;
        let mut axes = VolumeAxes::of(input, &shape, stored)?;
        axes.choices.series = series;
        Ok(Self { dataset, shape, stored, endian, axes, file_bytes })
    }

    pub(super) fn listing(self) -> VolumeListing {
        VolumeListing {
            format: VolumeFormat::Hdf5,
            dims: self.axes.dims,
            sample_type: self.stored.widest(),
            choices: self.axes.choices,
        }
    }

    pub(super) fn read(self, input: &Input<'_>) -> Result<LoadedVolume, IoError> {
        let path = input.path;
        let mut warnings = Vec::new();
        let spacing = self.spacing(&mut warnings);
        let grid = Grid::with_spacing(self.axes.dims, spacing)
            .map_err(|source| IoError::Grid { path: path.to_owned(), source })?;
        let item_bytes = self.stored.size_bytes() as u64;
        let n_items = self.axes.n_items().unwrap_or(u64::MAX);
        let needed = n_items.saturating_mul(item_bytes);
        let backed = self.file_bytes.saturating_mul(MAX_GZIP_RATIO);
        if MAX_UNBACKED_BYTES.max(backed) < needed {
            return Err(input.too_short(needed, self.file_bytes));
        }
        let failed = |failure| match failure {
            ReadFailure::TooShort(found) => input.too_short(needed, found),
            ReadFailure::Io(error) => refused(path, &error),
        };
        let n_samples = grid.n_voxels().saturating_mul(self.axes.choices.n_read());
        let samples = input.room(self.stored, self.endian, n_samples);
        let mut samples = samples.map_err(failed)?;
        let meter = input.meter(needed);
        let mut rows = Rows::of(self.dataset, &self.shape, item_bytes);
        let mut rows = Metered { source: &mut rows, meter: &meter };
        samples.place(&mut rows, &self.axes.axes, 0).map_err(failed)?;
        let samples = samples.finish(&mut warnings);
        let choices = self.axes.choices;
        let voxels = Voxels { grid, samples, scaling: Scaling::IDENTITY, choices };
        voxels.load(input, VolumeFormat::Hdf5, warnings)
    }

    /// Millimetres from voxel to voxel.
    fn spacing(&self, warnings: &mut Vec<String>) -> [f64; 3] {
        let sizes = self.dataset.attrs().ok().and_then(|mut attrs| attrs.remove(ELEMENT_SIZE));
        let sizes = sizes.map(numbers_of).unwrap_or_default();
        if let &[z, y, x] = sizes.as_slice() {
            let spacing = [x, y, z].map(|micrometres| micrometres * 1e-3);
            if spacing.iter().all(|step| step.is_normal() && 0.0 < *step) {
                return spacing;
            }
        }
        let what = "the data set does not say how large its voxels are: 1 x 1 x 1 was assumed";
        warnings.push(what.to_owned());
        [1.0; 3]
    }
}

fn open_file(file: StoredFile<'_>) -> Result<File, hdf5_pure::Error> {
    match file {
        StoredFile::Disk(file) => File::from_source(ReadSeekSource::new(file)?),
        StoredFile::Memory(cursor) => File::from_bytes(cursor.into_inner().to_vec()),
    }
}

/// An attribute's numbers, however they are written; none if it has others.
fn numbers_of(value: AttrValue) -> Vec<f64> {
    match value {
        AttrValue::F64Array(numbers) => numbers,
        AttrValue::F32Array(numbers) => numbers.into_iter().map(f64::from).collect(),
        AttrValue::I64Array(numbers) => numbers.into_iter().map(|number| number as f64).collect(),
        AttrValue::U64Array(numbers) => numbers.into_iter().map(|number| number as f64).collect(),
        AttrValue::I32Array(numbers) => numbers.into_iter().map(f64::from).collect(),
        AttrValue::U32Array(numbers) => numbers.into_iter().map(f64::from).collect(),
        AttrValue::I16Array(numbers) => numbers.into_iter().map(f64::from).collect(),
        AttrValue::U16Array(numbers) => numbers.into_iter().map(f64::from).collect(),
        AttrValue::U8Array(numbers) => numbers.into_iter().map(f64::from).collect(),
        _ => Vec::new(),
    }
}

/// The data set that is asked for, by path or by number; else the first that has the axes of a volume.
fn choose(input: &Input<'_>, file: &File) -> Result<(Dataset, Choice), IoError> {
    let mut found = Found::default();
    found.walk(&file.root(), "", 0);
    let Found { mut arrays, .. } = found;
    arrays.sort_by(|a, b| a.0.cmp(&b.0));
    if let Some(asked) = &input.options.array {
        let asked = asked.trim_matches('/');
        if let Ok(dataset) = file.dataset(asked) {
            let names = vec![asked.to_owned()];
            return Ok((dataset, Choice { names, ..Choice::default() }));
        }
        return Err(IoError::unsupported(
            input.path,
            format!("there is no data set {:?}: there is {}", printable(asked), listed(&arrays)),
        ));
    }
    let n_axes = |dataset: &Dataset| shape(dataset).map_or(0, |shape| shape.len());
    let are_numbers = |dataset: &Dataset| matches!(numbers(dataset), Ok(Some(_)));
    let all = listed(&arrays);
    arrays.retain(|(_, dataset)| 2 <= n_axes(dataset) && are_numbers(dataset));
    if arrays.is_empty() {
        let what = format!("none of its data sets is a volume: there is {all}");
        return Err(IoError::unsupported(input.path, what));
    }
    let chosen = arrays.iter().position(|(_, dataset)| 3 <= n_axes(dataset)).unwrap_or(0);
    let names = arrays.iter().map(|(name, _)| name.clone()).collect();
    let series = input.choose_of(Part::Series, Choice { n: arrays.len(), names, chosen })?;
    Ok((arrays.swap_remove(series.chosen).1, series))
}

/// The data sets of a file by their paths, as far as its groups can be read.
#[derive(Default)]
struct Found {
    arrays: Vec<(String, Dataset)>,
    n_groups: usize,
}

impl Found {
    fn walk(&mut self, group: &Group, path: &str, depth: usize) {
        self.n_groups += 1;
        if let Ok(datasets) = group.iter_datasets() {
            let n_left = MAX_ARRAYS.saturating_sub(self.arrays.len());
            let named = |(name, dataset)| (format!("{path}{name}"), dataset);
            self.arrays.extend(datasets.take(n_left).map(named));
        }
        let Ok(groups) = group.iter_groups() else { return };
        for (name, group) in groups {
            if depth < MAX_DEPTH && self.n_groups < MAX_GROUPS {
                self.walk(&group, &format!("{path}{name}/"), depth + 1);
            }
        }
    }
}

/// For messages: `a/b 4 x 3 x 2, c 7`.
fn listed(arrays: &[(String, Dataset)]) -> String {
    let shown = |(name, dataset): &(String, Dataset)| {
        let shape = shape(dataset).unwrap_or_default();
        let sizes = shape.iter().map(usize::to_string).collect::<Vec<_>>().join(" x ");
        format!("{} {sizes}", printable(name))
    };
    let mut listed: Vec<String> = arrays.iter().take(MAX_LISTED).map(shown).collect();
    if MAX_LISTED < arrays.len() {
        listed.push("..".to_owned());
    }
    if listed.is_empty() { "none".to_owned() } else { listed.join(", ") }
}

/// Of an array without axes it is empty.
fn shape(dataset: &Dataset) -> Result<Vec<usize>, hdf5_pure::Error> {
    let shape = dataset.shape()?;
    Ok(shape.into_iter().map(|len| usize::try_from(len).unwrap_or(usize::MAX)).collect())
}

/// The type of a data set's numbers; `None` if they are none, or such as no volume has.
fn numbers(dataset: &Dataset) -> Result<Option<(StoredType, Endian)>, hdf5_pure::Error> {
    Ok(number(&dataset.datatype()?))
}

fn number(datatype: &Datatype) -> Option<(StoredType, Endian)> {
    let (code, byte_order) = match datatype {
        Datatype::FixedPoint { size, byte_order, layout } => {
            let n_bits = u32::from(layout.bit_precision);
            let is_whole = layout.bit_offset == 0 && size.checked_mul(8) == Some(n_bits);
            let kind = if layout.signed { 'i' } else { 'u' };
            (is_whole.then(|| format!("{kind}{size}"))?, byte_order)
        }
        Datatype::FloatingPoint { size: 2, byte_order, layout } if is_half(layout) => {
            ("f2".to_owned(), byte_order)
        }
        Datatype::FloatingPoint { size: 4, byte_order, layout }
            if *layout == FloatingPointLayout::IEEE754_BINARY32 =>
        {
            ("f4".to_owned(), byte_order)
        }
        Datatype::FloatingPoint { size: 8, byte_order, layout }
            if *layout == FloatingPointLayout::IEEE754_BINARY64 =>
        {
            ("f8".to_owned(), byte_order)
        }
        // Truth values, and names of labels.
        Datatype::Enumeration { base_type, .. } => return number(base_type),
        _ => return None,
    };
    let endian = match byte_order {
        DatatypeByteOrder::LittleEndian => Endian::Little,
        DatatypeByteOrder::BigEndian => Endian::Big,
        DatatypeByteOrder::Vax => return None,
    };
    StoredType::of_code(&code).map(|stored| (stored, endian))
}

/// IEEE 754's 16 bits, and not the upper ones of 32.
fn is_half(layout: &FloatingPointLayout) -> bool {
    (layout.exponent_size, layout.mantissa_size, layout.exponent_bias) == (5, 10, 15)
}
