//! Opens the files of a scene to read boxes of them. What has to be unpacked for that one share of each
//! computer unpacks, and the others there read the same scratch file.

use super::{DividedDesc, DividedError, Exchange};
use slabsplat_core::Samples;
use slabsplat_io::{IoError, LabelBoxes, LabelsFile, LayerFile, ScratchDesc, VolumeBoxes};

/// The part of all memory that unpacked chunks may take while overviews are read, and nothing is drawn.
const OF_OVERVIEW: u64 = 4;

/// Where the volumes of layers are, if all shares can read them.
pub(super) fn volumes_of(
    layers: &[LayerFile],
    desc: &DividedDesc,
    others: &mut dyn Exchange,
) -> Result<Vec<VolumeBoxes>, DividedError> {
    let mut sources: Vec<VolumeBoxes> = Vec::new();
    for layer in layers {
        let before = layers.iter().zip(&sources).find(|(of, _)| layer.shares_volume(of));
        let source = match before {
            Some((_, source)) => source.clone(),
            None => opened(layer, &desc.scratch, others)?,
        };
        // What is looked at meets the same chunks again.
        source.retain_chunks(desc.memory_bytes / OF_OVERVIEW);
        sources.push(source);
    }
    Ok(sources)
}

/// Their labels, and what is to be said of these.
pub(super) fn labels_of(
    layers: &[LayerFile],
    desc: &DividedDesc,
    others: &mut dyn Exchange,
) -> Result<(Vec<Option<LabelBoxes>>, Vec<String>), DividedError> {
    let (mut all, mut all_warnings) = (Vec::new(), Vec::new());
    for layer in layers {
        let labels = layer.labels.as_ref();
        let (labels, warnings) =
            labels.map(|labels| opened(labels, &desc.scratch, others)).transpose()?.unzip();
        all.push(labels);
        all_warnings.extend(warnings.into_iter().flatten());
    }
    Ok((all, all_warnings))
}

/// A file of which boxes are read.
trait InBoxes: Sync {
    /// It, opened.
    type Boxes: Send;

    fn open(&self, scratch: &ScratchDesc) -> Result<Self::Boxes, IoError>;

    /// What others read the same scratch file by, if there is one.
    fn handle(boxes: &Self::Boxes) -> Result<Option<Vec<u8>>, IoError>;
}

impl InBoxes for LayerFile {
    type Boxes = VolumeBoxes;

    fn open(&self, scratch: &ScratchDesc) -> Result<VolumeBoxes, IoError> {
        self.open_boxes(scratch)
    }

    fn handle(boxes: &VolumeBoxes) -> Result<Option<Vec<u8>>, IoError> {
        boxes.scratch_handle()
    }
}

impl InBoxes for LabelsFile {
    /// With warnings.
    type Boxes = (LabelBoxes, Vec<String>);

    fn open(&self, scratch: &ScratchDesc) -> Result<Self::Boxes, IoError> {
        self.open_boxes(scratch)
    }

    fn handle((boxes, _): &Self::Boxes) -> Result<Option<Vec<u8>>, IoError> {
        boxes.scratch_handle()
    }
}

/// Opens a file on all shares, which then all have it.
fn opened<F: InBoxes>(
    file: &F,
    scratch: &ScratchDesc,
    others: &mut dyn Exchange,
) -> Result<F::Boxes, DividedError> {
    let unpacks = others.first_here() == others.share_idx();
    let own = if unpacks {
        opened_at_work(file, scratch, others)?
    } else {
        opened_at_work(file, &scratch.clone().refused(), others)?
    };
    let (own, handle) = match own {
        Err(IoError::NotInBoxes { .. }) if !unpacks => (None, Ok(None)),
        Err(error) => (None, Err(error)),
        Ok(boxes) => {
            let handle = F::handle(&boxes);
            (Some(boxes), handle)
        }
    };
    let handles = others.all(handle.map(|handle| Samples::U8(handle.unwrap_or_default())))?;
    let own = match (own, handles.get(others.first_here())) {
        (Some(boxes), _) => Ok(boxes),
        (None, Some(Samples::U8(handle))) => {
            opened_at_work(file, &scratch.clone().shared(handle), others)?
        }
        (None, _) => return Err(DividedError::Differing),
    };
    // Nobody lets go of a scratch file before all have opened it.
    let (own, is_there) = match own {
        Ok(boxes) => (Some(boxes), Ok(Samples::U8(Vec::new()))),
        Err(error) => (None, Err(error)),
    };
    others.all(is_there)?;
    own.ok_or(DividedError::Differing)
}

fn opened_at_work<F: InBoxes>(
    file: &F,
    scratch: &ScratchDesc,
    others: &mut dyn Exchange,
) -> Result<Result<F::Boxes, IoError>, DividedError> {
    let mut opened = None;
    others.at_work(&mut || opened = Some(file.open(scratch)))?;
    Ok(opened.expect("the work was done"))
}
