//! What all layers read on the device: their section tables, the planes of their regions, how slabs split
//! their kernels, what densities are shown by, and the surfaces at which rays end.

use crate::job::Job;
use crate::memory::{Buffer, Memory, too_large};
use crate::regions::Element;
use crate::section_table::{QUADS_OF_ROW, Quad, polynomial_quads, section_quads};
use crate::surfaces::Surfaces;
use crate::{Device, Slice, Write};
use slabsplat_backend::{BackendError, DensitySplats, SmoothSections};
use slabsplat_kernel::{CubicSectionTable, RadialPolynomials, SectionTable};
use std::sync::Arc;

/// The tables of a layer.
#[derive(Clone, Debug)]
pub(crate) struct LayerTables {
    pub(crate) sections: Table,
    /// Sections with all that lies before or behind a face.
    pub(crate) merged: Table,
}

/// A table of a layer.
#[derive(Clone, Debug)]
pub(crate) enum Table {
    /// Of a kernel whose sections are computed, or of merged sections where none are.
    None,
    Cubics(Arc<CubicSectionTable>),
    Sections(Arc<SectionTable>),
    Polynomials(Arc<RadialPolynomials>),
}

impl LayerTables {
    /// As they lie one behind the other.
    fn all(&self) -> impl Iterator<Item = &Table> {
        [&self.sections, &self.merged].into_iter()
    }

    pub(crate) fn n_quads(&self) -> u32 {
        self.all().map(Table::n_quads).sum()
    }
}

impl Table {
    pub(crate) fn of_densities(densities: &DensitySplats) -> Self {
        match &densities.smooth {
            SmoothSections::Product(_) => Self::None,
            SmoothSections::Table(table) => Self::Cubics(table.clone()),
        }
    }

    /// Of a layer whose sections are never merged.
    pub(crate) fn alone(self) -> LayerTables {
        LayerTables { sections: self, merged: Self::None }
    }

    /// Whether both are one table, not only alike.
    pub(crate) fn is(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Sections(a), Self::Sections(b)) => Arc::ptr_eq(a, b),
            (Self::Polynomials(a), Self::Polynomials(b)) => Arc::ptr_eq(a, b),
            (Self::Cubics(a), Self::Cubics(b)) => Arc::ptr_eq(a, b),
            (Self::None, Self::None) => true,
            _ => false,
        }
    }

    fn quads(&self) -> Vec<Quad> {
        match self {
            Self::Sections(table) => section_quads(table),
            Self::Polynomials(polynomials) => polynomial_quads(polynomials),
            Self::Cubics(table) => table.coefficients().to_vec(),
            Self::None => Vec::new(),
        }
    }

    /// A quad for every two neighbours, for every cubic, or for every four coefficients.
    pub(crate) fn row_len(&self) -> u32 {
        match self {
            Self::None => 0,
            Self::Cubics(_) => CubicSectionTable::ROW_LEN as u32,
            Self::Sections(table) => table.row_len() as u32 - 1,
            Self::Polynomials(_) => QUADS_OF_ROW,
        }
    }

    pub(crate) fn n_quads(&self) -> u32 {
        match self {
            Self::None => 0,
            Self::Cubics(table) => table.coefficients().len() as u32,
            Self::Sections(table) => table.n_rows() as u32 * self.row_len(),
            Self::Polynomials(polynomials) => (polynomials.n_rows() as u32 + 1) * QUADS_OF_ROW,
        }
    }
}

/// The tables of all layers, one after the other, then the planes, then how slabs split kernels, then what
/// densities are shown by, and then the surfaces.
#[derive(Debug)]
pub(crate) struct TablesBuffer {
    buffer: Buffer,
    holds: Vec<Table>,
    /// How slabs split kernels, as it has it, and from which byte on.
    splits: (u64, Vec<Element>),
    /// The surfaces that it holds, and from which byte on.
    surfaces: Option<(u64, Arc<Surfaces>)>,
}

/// Bytes of an element of the shaders' `table`.
const ELEMENT_BYTES: u64 = size_of::<Quad>() as u64;

impl TablesBuffer {
    pub(crate) fn new() -> Self {
        Self {
            buffer: Buffer::new("section tables and surfaces"),
            holds: Vec::new(),
            splits: Default::default(),
            surfaces: None,
        }
    }

    pub(crate) fn all(&self) -> Slice {
        self.buffer.all()
    }

    /// Writes what of a job's is not there.
    pub(crate) fn write<'a, D: Device>(
        &mut self,
        (memory, device): (&mut Memory, &mut D),
        job: &'a Job,
        writes: &mut Vec<Write<'a>>,
    ) -> Result<(), BackendError> {
        let tables = || job.layers.iter().flat_map(|layer| layer.tables.all());
        let n_bytes = job.n_elements().map(|n| n * ELEMENT_BYTES);
        let n_bytes_before = n_bytes.iter().sum();
        let surfaces = job.surfaces.as_ref().map(|it| (n_bytes_before, it));
        self.make_room((memory, device), n_bytes_before, surfaces)?;
        let buffer = self.buffer.all().buffer;
        let are_there = self.holds.len() == tables().count()
            && self.holds.iter().zip(tables()).all(|(there, table)| there.is(table));
        if !are_there {
            let quads: Vec<Quad> = tables().flat_map(Table::quads).collect();
            if !quads.is_empty() {
                let bytes = bytemuck::cast_slice(&quads).to_vec().into();
                writes.push(Write { buffer, offset: 0, bytes });
            }
            self.holds = tables().cloned().collect();
        }
        let [planes_at, n_plane_bytes, n_split_bytes, _] = n_bytes;
        let splits_at = planes_at + n_plane_bytes;
        // They stay while a camera turns around a cubic grid.
        let splits: &[Element] =
            if self.splits == (splits_at, job.splits.clone()) { &[] } else { &job.splits };
        for (offset, elements) in [
            (planes_at, job.planes.as_flattened()),
            (splits_at, splits),
            (splits_at + n_split_bytes, job.shown()),
        ] {
            if !elements.is_empty() {
                let bytes = bytemuck::cast_slice(elements).into();
                writes.push(Write { buffer, offset, bytes });
            }
        }
        self.splits = (splits_at, job.splits.clone());
        if let Some((offset, surfaces)) = surfaces
            && !self.holds_surfaces(offset, surfaces)
        {
            let bytes = bytemuck::cast_slice(&surfaces.elements).into();
            writes.push(Write { buffer, offset, bytes });
        }
        self.surfaces = surfaces.map(|(offset, surfaces)| (offset, surfaces.clone()));
        Ok(())
    }

    /// Sees to it that there is room for what comes before surfaces, and for them. How many they are changes
    /// from frame to frame, so there is some to spare.
    fn make_room<D: Device>(
        &mut self,
        (memory, device): (&mut Memory, &mut D),
        n_bytes_before: u64,
        surfaces: Option<(u64, &Arc<Surfaces>)>,
    ) -> Result<(), BackendError> {
        let n_surface_bytes =
            surfaces.map_or(0, |(_, it)| it.elements.len() as u64 * ELEMENT_BYTES);
        let n_bytes = n_bytes_before + n_surface_bytes;
        let most = device.info().max_binding_bytes.min(device.info().max_buffer_bytes);
        if most < n_bytes {
            let what = if surfaces.is_some() { "surfaces of meshes" } else { "section tables" };
            return Err(too_large(device, what, n_bytes, most));
        }
        if self.buffer.size() < n_bytes {
            self.emptied();
            memory.grow(device, &mut self.buffer, (n_bytes + n_surface_bytes / 4).min(most))?;
        }
        Ok(())
    }

    fn holds_surfaces(&self, offset: u64, surfaces: &Arc<Surfaces>) -> bool {
        let is_it = |(at, it): &(u64, Arc<Surfaces>)| *at == offset && Arc::ptr_eq(it, surfaces);
        self.surfaces.as_ref().is_some_and(is_it)
    }

    /// The buffer, to be freed: nothing is in it then.
    pub(crate) fn emptied(&mut self) -> &mut Buffer {
        self.holds.clear();
        self.splits = Default::default();
        self.surfaces = None;
        &mut self.buffer
    }
}
