//! What all layers read on the device: their section tables, and the planes of their regions.

use crate::job::Job;
use crate::memory::{Buffer, Memory, too_large};
use crate::section_table::{Quad, footprint_quads, section_quads};
use crate::{Device, Slice, Write};
use slabsplat_backend::{BackendError, ColorSplats};
use slabsplat_kernel::{FootprintTable, SectionTable};
use std::sync::Arc;

/// The table of a layer.
#[derive(Clone, Debug)]
pub(crate) enum Table {
    Sections(Arc<SectionTable>),
    Footprint(Arc<FootprintTable>),
}

impl Table {
    pub(crate) fn of(splats: &ColorSplats) -> Self {
        match splats {
            ColorSplats::Sections(sections) => Self::Sections(sections.table.clone()),
            ColorSplats::Slices { table, .. } | ColorSplats::Voxels { table } => {
                Self::Footprint(table.clone())
            }
        }
    }

    /// Whether both are one table, not only alike.
    fn is(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Sections(a), Self::Sections(b)) => Arc::ptr_eq(a, b),
            (Self::Footprint(a), Self::Footprint(b)) => Arc::ptr_eq(a, b),
            _ => false,
        }
    }

    fn quads(&self) -> Vec<Quad> {
        match self {
            Self::Sections(table) => section_quads(table),
            Self::Footprint(table) => footprint_quads(table),
        }
    }

    /// A quad for every two neighbours.
    pub(crate) fn row_len(&self) -> u32 {
        match self {
            Self::Sections(table) => table.row_len() as u32 - 1,
            Self::Footprint(table) => table.row().len() as u32 - 1,
        }
    }

    pub(crate) fn n_quads(&self) -> u32 {
        let n_rows = match self {
            Self::Sections(table) => table.n_rows() as u32,
            Self::Footprint(_) => 1,
        };
        n_rows * self.row_len()
    }
}

/// The tables of all layers, one after the other, and then the planes.
#[derive(Debug)]
pub(crate) struct TablesBuffer {
    buffer: Buffer,
    holds: Vec<Table>,
}

impl TablesBuffer {
    pub(crate) fn new() -> Self {
        Self { buffer: Buffer::new("section tables"), holds: Vec::new() }
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
        let tables = || job.layers.iter().map(|layer| &layer.table);
        let n_quads: u64 = tables().map(|table| u64::from(table.n_quads())).sum();
        let n_table_bytes = n_quads * size_of::<Quad>() as u64;
        let planes: &[u8] = bytemuck::cast_slice(&job.planes);
        let n_bytes = n_table_bytes + planes.len() as u64;
        let most = device.info().max_binding_bytes.min(device.info().max_buffer_bytes);
        if most < n_bytes {
            return Err(too_large(device, "section tables", n_bytes, most));
        }
        if self.buffer.size() < n_bytes {
            self.holds.clear();
            memory.grow(device, &mut self.buffer, n_bytes)?;
        }
        let buffer = self.buffer.all().buffer;
        let are_there = self.holds.len() == job.layers.len()
            && self.holds.iter().zip(tables()).all(|(there, table)| there.is(table));
        if !are_there {
            let quads: Vec<Quad> = tables().flat_map(Table::quads).collect();
            let bytes = bytemuck::cast_slice(&quads).to_vec().into();
            writes.push(Write { buffer, offset: 0, bytes });
            self.holds = tables().cloned().collect();
        }
        if !planes.is_empty() {
            writes.push(Write { buffer, offset: n_table_bytes, bytes: planes.into() });
        }
        Ok(())
    }

    /// The buffer, to be freed: nothing is in it then.
    pub(crate) fn emptied(&mut self) -> &mut Buffer {
        self.holds.clear();
        &mut self.buffer
    }
}
