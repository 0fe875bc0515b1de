//! A layer's volume as boxes of voxels, whatever it is stored as.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use slabsplat_core::Grid;
use slabsplat_core::glam::DVec3;

use super::{LayerFile, VolumeSource};
use crate::volume::{ALPHA_IS_CONSTANT, ChunkCache, Scratch, is_constant};
use crate::{IoError, LoadedVolume, OpacitySource, ScratchDesc, ScratchUse, VolumeFormat};

/// A volume of which boxes of voxels are read, one after the other, and the rest is never in memory: from its
/// file, or from a scratch file where that is packed. A clone shares the scratch file, which is gone with the
/// last of them.
#[derive(Clone, Debug)]
pub struct VolumeBoxes {
    layer: LayerFile,
    /// The first voxel, with all that the file says.
    first: LoadedVolume,
    scratch: Option<Arc<Scratch>>,
    chunks: ChunkCache,
}

impl LayerFile {
    /// Opens the volume to read boxes of it: where its file can only be read from front to back, by reading
    /// all of it once, into a scratch file as `scratch` says.
    ///
    /// ```
    /// use slabsplat_io::{LayerFile, ScratchDesc, VolumeSource, builtin_volume, write_volume};
    ///
    /// let dir = tempfile::tempdir()?;
    /// let path = dir.path().join("ball.nrrd");
    /// write_volume(&path, &builtin_volume("sphere", Some(20))?)?;
    ///
    /// let layer = LayerFile::of_volume(VolumeSource::File(path));
    /// let boxes = layer.open_boxes(&ScratchDesc::default().folder(dir.path()))?;
    /// assert_eq!(boxes.grid().dims(), [20, 20, 20]);
    /// assert_eq!(boxes.read([4..12, 0..20, 7..8])?.volume.grid().dims(), [8, 20, 1]);
    /// // It is packed by gzip.
    /// assert_eq!(boxes.scratch().map(|scratch| scratch.n_bytes), Some(8000));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If it cannot be read, or only with all of it in memory ([`IoError::NotInBoxes`]); if there is no room
    /// for scratch ([`IoError::NoScratch`]), or the disk fails ([`IoError::Scratch`]).
    pub fn open_boxes(&self, scratch: &ScratchDesc) -> Result<VolumeBoxes, IoError> {
        let (mut layer, chunks) = (self.clone(), ChunkCache::default());
        layer.options.chunks = Some(chunks.clone());
        match (layer.read_box([0..1, 0..1, 0..1]), &self.volume) {
            (Ok(first), _) => VolumeBoxes { layer, first, scratch: None, chunks }.looked_through(),
            (Err(IoError::NotInBoxes { .. }), VolumeSource::File(path))
                if !scratch.is_refused() =>
            {
                let mut options = self.options.clone();
                options.voxels = None;
                let unpacked = Scratch::open(path, &options, scratch)?;
                let first = self.spaced(unpacked.first().clone())?;
                let scratch = Some(Arc::new(unpacked));
                VolumeBoxes { layer, first, scratch, chunks }.looked_through()
            }
            (Err(error), _) => Err(error),
        }
    }

    fn read_box(&self, voxels: [Range<usize>; 3]) -> Result<LoadedVolume, IoError> {
        let mut layer = self.clone();
        layer.options.voxels = Some(voxels);
        layer.load_volume()
    }
}

/// Levels that are looked for beyond the one that is read: each has mostly an eighth of the voxels.
const MOST_LEVELS: usize = 16;

/// Bytes of a piece, if a row of voxels has no more.
const PIECE_BYTES: usize = 4 << 20;

impl VolumeBoxes {
    /// Voxels along the side of boxes of a volume in chunks: mostly a multiple of theirs.
    pub const SIDE_OF_CHUNKS: usize = 64;

    /// The grid of the whole volume.
    pub fn grid(&self) -> Grid {
        self.first.volume.grid().uncropped()
    }

    /// The first voxel, with all that is known of the volume.
    pub fn first(&self) -> &LoadedVolume {
        &self.first
    }

    /// Reads some voxels along x, y and z.
    ///
    /// # Errors
    /// If there are no such voxels, or they cannot be read.
    pub fn read(&self, voxels: [Range<usize>; 3]) -> Result<LoadedVolume, IoError> {
        match &self.scratch {
            Some(scratch) => {
                let opacity_from = self.layer.options.opacity_from;
                self.layer.spaced(scratch.read(&voxels, opacity_from)?)
            }
            None => self.layer.read_box(voxels),
        }
    }

    /// The coarsest level of the same image that has so many voxels or more, for who wants a first impression
    /// and not each voxel; none where the file has one level, as most do, or where the others are not of the
    /// same samples in the same place.
    ///
    /// ```
    /// # use slabsplat_io::{LayerFile, ScratchDesc, VolumeSource, builtin_volume, write_volume};
    /// # let dir = tempfile::tempdir()?;
    /// # let path = dir.path().join("ball.zarr");
    /// write_volume(&path, &builtin_volume("sphere", Some(20))?)?;
    /// let layer = LayerFile::of_volume(VolumeSource::File(path));
    /// let boxes = layer.open_boxes(&ScratchDesc::default())?;
    /// assert!(boxes.coarser(1)?.is_none());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If a level cannot be read.
    pub fn coarser(&self, least_voxels: usize) -> Result<Option<Self>, IoError> {
        let levels = &self.first.choices.level;
        let mut coarsest = None;
        for level in (levels.chosen + 1..levels.n).take(MOST_LEVELS) {
            let mut layer = self.layer.clone();
            layer.options.level = Some(level);
            let first = layer.read_box([0..1, 0..1, 0..1])?;
            let coarser = Self { layer, first, scratch: None, chunks: self.chunks.clone() };
            if coarser.grid().n_voxels() < least_voxels {
                break;
            }
            if coarser.stands_for(self) {
                coarsest = Some(coarser);
            }
        }
        Ok(coarsest)
    }

    /// Whether it has the same samples in the same place, up to two of its own voxels on each side.
    fn stands_for(&self, finer: &Self) -> bool {
        let type_of = |of: &Self| {
            let own = of.first.colors.as_ref().and_then(|colors| colors.voxels.as_ref());
            (of.first.volume.sample_type(), own.map(|colors| colors.samples().size_bytes()))
        };
        let (own, other) = (self.grid(), finer.grid());
        let ends = |grid: &Grid| {
            let dims = DVec3::from_array(grid.dims().map(|n| n as f64));
            [DVec3::splat(-0.5), dims - 0.5]
        };
        let index_from_index = own.index_from_world() * other.world_from_index();
        let is_near = |(end, other): (DVec3, DVec3)| {
            (index_from_index.transform_point3(other) - end).abs().max_element() <= 2.0
        };
        type_of(self) == type_of(finer) && ends(&own).into_iter().zip(ends(&other)).all(is_near)
    }

    /// Finds of a volume of colours what opacity is made of, which is known of all voxels alone.
    fn looked_through(mut self) -> Result<Self, IoError> {
        let has_alpha = self.first.colors.as_ref().is_some_and(|colors| colors.has_alpha);
        if !has_alpha || self.layer.options.opacity_from.is_some() {
            return Ok(self);
        }
        let mut opacity_from = OpacitySource::Luminance;
        let first = self.first.volume.value(0);
        for voxels in self.pieces() {
            let alpha = self.read(voxels)?.volume;
            if alpha.value(0) != first || !is_constant(alpha.samples()) {
                opacity_from = OpacitySource::Alpha;
                break;
            }
        }
        self.layer.options.opacity_from = Some(opacity_from);
        let warnings = std::mem::take(&mut self.first.warnings);
        self.first = self.read([0..1, 0..1, 0..1])?;
        self.first.warnings = warnings;
        if opacity_from == OpacitySource::Luminance {
            self.first.warnings.push(ALPHA_IS_CONSTANT.to_owned());
        }
        Ok(self)
    }

    /// Boxes that have all voxels, a few mebibytes each: one after the other they meet the same chunks.
    pub fn pieces(&self) -> Vec<[Range<usize>; 3]> {
        let [nx, ny, nz] = self.grid().dims();
        let depth = match self.is_in_chunks() {
            true => Self::SIDE_OF_CHUNKS,
            false => (PIECE_BYTES / (nx * ny * self.voxel_bytes())).max(1),
        };
        let planes = (0..nz).step_by(depth).map(|first| first..(first + depth).min(nz));
        planes.flat_map(|planes| self.strips(&planes)).collect()
    }

    /// The same of some planes.
    pub fn strips(&self, planes: &Range<usize>) -> Vec<[Range<usize>; 3]> {
        let [nx, ny, _] = self.grid().dims();
        let n_rows = (PIECE_BYTES / (nx * planes.len() * self.voxel_bytes())).clamp(1, ny);
        let n_rows = match self.is_in_chunks() {
            true if Self::SIDE_OF_CHUNKS < n_rows => {
                n_rows / Self::SIDE_OF_CHUNKS * Self::SIDE_OF_CHUNKS
            }
            _ => n_rows,
        };
        let strip = |first: usize| [0..nx, first..(first + n_rows).min(ny), planes.clone()];
        (0..ny).step_by(n_rows).map(strip).collect()
    }

    /// Bytes of a voxel that is read, its colour included.
    pub fn voxel_bytes(&self) -> usize {
        let own = self.first.colors.as_ref().and_then(|colors| colors.voxels.as_ref());
        let of_colors = own.map_or(0, |colors| colors.samples().size_bytes());
        self.first.volume.sample_type().size_bytes() + of_colors
    }

    /// Whether it is stored in chunks, which are unpacked whole: several boxes may meet one.
    pub fn is_in_chunks(&self) -> bool {
        self.first.format == VolumeFormat::Zarr
    }

    /// Retains unpacked chunks up to so many bytes for the boxes that are read next, of all clones; none at
    /// first. Those that were used last stay.
    pub fn retain_chunks(&self, most_bytes: u64) {
        self.chunks.set_room(most_bytes);
    }

    /// How many chunks had to be unpacked, and how many were there, of those that were looked for.
    pub fn chunk_counts(&self) -> [u64; 2] {
        self.chunks.counts()
    }

    /// What it takes on a disk, if it had to be unpacked.
    pub fn scratch(&self) -> Option<&ScratchUse> {
        self.scratch.as_deref().map(Scratch::of_folder)
    }

    /// What other processes of this computer read the same scratch file by, if it had to be unpacked
    /// ([`ScratchDesc::shared`]): as long as this one has it, or has been read there.
    ///
    /// # Errors
    /// If the system does not tell which file that is.
    pub fn scratch_handle(&self) -> Result<Option<Vec<u8>>, IoError> {
        self.scratch.as_deref().map(Scratch::handle).transpose()
    }

    /// The file, for messages.
    pub fn path(&self) -> &Path {
        match &self.layer.volume {
            VolumeSource::File(path) => path,
            VolumeSource::Builtin { name, .. } => Path::new(name),
        }
    }
}
