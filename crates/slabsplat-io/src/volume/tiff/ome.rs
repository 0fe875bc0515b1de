//! OME-XML in the description of a first page: what the pages are.
//!
//! Schema: <https://docs.openmicroscopy.org/ome-model/latest/ome-tiff/specification.html>.

use roxmltree::{Document, Node};

use super::super::choices::VolumeChoices;
use super::super::units::millimetres;
use super::stack::Counts;

/// The first image of an OME-TIFF.
#[derive(Debug)]
pub(super) struct Ome {
    pub(super) counts: Counts,
    /// What channels are called; empty unless all are.
    pub(super) channel_names: Vec<String>,
    /// How far apart pages of neighbouring slices, channels and times are, if they are in the order that is
    /// said.
    strides: [usize; 3],
    /// Pages of slices by `TiffData` blocks that name them, if any does.
    named: Vec<Block>,
    /// Sizes of voxels, with their units.
    sizes: [Option<(f64, String)>; 3],
}

/// Pages that follow each other from one on, and the place of the first.
#[derive(Debug)]
struct Block {
    page_idx: usize,
    n_pages: usize,
    /// Slice, channel, time.
    first: [usize; 3],
}

impl Ome {
    /// `None` if the description is none of OME's.
    pub(super) fn of(description: &str) -> Option<Result<Self, String>> {
        let text = description.trim_end_matches('\0').trim();
        let is_ome = text.starts_with('<') && text.contains("<OME");
        is_ome.then(|| Self::parse(text))
    }

    fn parse(text: &str) -> Result<Self, String> {
        let document = Document::parse(text).map_err(|error| {
            let at = error.pos();
            format!("its OME-XML is broken in line {}, column {}", at.row, at.col)
        })?;
        let is_pixels = |node: &Node<'_, '_>| node.tag_name().name() == "Pixels";
        let pixels = document.descendants().find(is_pixels);
        let pixels = pixels.ok_or("its OME-XML tells of no Pixels")?;
        let count = |name: &str| -> Result<usize, String> {
            let text = pixels.attribute(name).unwrap_or("1");
            let parsed = text.parse().ok().filter(|&n: &usize| 0 < n);
            parsed.ok_or_else(|| format!("its OME-XML has {text:?} for {name}"))
        };
        let counts = Counts {
            n_slices: count("SizeZ")?,
            n_channels: count("SizeC")?,
            n_times: count("SizeT")?,
        };
        let order = pixels.attribute("DimensionOrder").unwrap_or("XYZCT");
        let strides = ['Z', 'C', 'T'].map(|along| {
            let before = order.chars().take_while(|&axis| axis != along);
            before.fold(1_usize, |stride, axis| match axis {
                'Z' => stride.saturating_mul(counts.n_slices),
                'C' => stride.saturating_mul(counts.n_channels),
                'T' => stride.saturating_mul(counts.n_times),
                _ => stride,
            })
        });
        let size = |axis: &str| {
            let size: f64 =
                pixels.attribute(format!("PhysicalSize{axis}").as_str())?.parse().ok()?;
            let unit = pixels.attribute(format!("PhysicalSize{axis}Unit").as_str()).unwrap_or("µm");
            (size.is_normal() && 0.0 < size).then(|| (size, unit.to_owned()))
        };
        let blocks = pixels.children().filter(|node| node.tag_name().name() == "TiffData");
        let named = blocks.filter_map(|node| Block::of(&node)).collect();
        let sizes = ["X", "Y", "Z"].map(size);
        let channels = pixels.children().filter(|node| node.tag_name().name() == "Channel");
        let channel_names: Vec<String> =
            channels.filter_map(|node| node.attribute("Name").map(str::to_owned)).collect();
        let are_all = channel_names.len() == counts.n_channels;
        let channel_names = if are_all { channel_names } else { Vec::new() };
        Ok(Self { counts, channel_names, strides, named, sizes })
    }

    /// The pages of the channel and the time that are chosen.
    pub(super) fn slices(
        &self,
        choices: &VolumeChoices,
        n_pages: usize,
    ) -> Result<Vec<usize>, String> {
        let n_slices = self.counts.n_slices;
        let [channel, time] = [choices.channel.chosen, choices.time.chosen];
        let missing = || {
            format!(
                "its OME-XML tells of {n_slices} slices, which are not all in this file: open it whole"
            )
        };
        if n_pages < n_slices {
            return Err(missing());
        }
        let in_order = |place: [usize; 3]| {
            let steps = place.into_iter().zip(self.strides);
            steps
                .map(|(idx, stride)| idx.checked_mul(stride))
                .try_fold(0, |sum: usize, step| sum.checked_add(step?))
        };
        let page_of = |z: usize| {
            let place = [z, channel, time];
            match self.named.iter().find_map(|block| block.page_of(place)) {
                Some(page_idx) => Some(page_idx),
                None if self.has_places() => None,
                None => in_order(place),
            }
        };
        let pages = (0..n_slices).map(|z| page_of(z).filter(|&page_idx| page_idx < n_pages));
        pages.collect::<Option<_>>().ok_or_else(missing)
    }

    /// Whether blocks say of single pages where they belong, and not of all pages in their order.
    fn has_places(&self) -> bool {
        1 < self.named.len()
    }

    /// In millimetres.
    pub(super) fn spacing(&self, warnings: &mut Vec<String>) -> [f64; 3] {
        let in_mm = |size: &Option<(f64, String)>| {
            let (size, unit) = size.as_ref()?;
            Some(size * millimetres(unit)?)
        };
        let [x, y, z] = self.sizes.each_ref().map(in_mm);
        if let ([Some(x), Some(y)], Some(z)) =
            ([x, y], z.or(x.filter(|_| self.counts.n_slices == 1)))
        {
            return [x, y, z];
        }
        warnings.push(
            "the file does not say how large its voxels are: 1 x 1 x 1 was assumed".to_owned(),
        );
        [1.0; 3]
    }
}

impl Block {
    /// `None` if the block does not name its first page, or is one of all pages.
    fn of(node: &Node<'_, '_>) -> Option<Self> {
        let number = |name: &str| node.attribute(name).and_then(|text| text.parse().ok());
        let first = ["FirstZ", "FirstC", "FirstT"].map(|name| number(name).unwrap_or(0));
        let n_pages = number("PlaneCount").unwrap_or(1);
        let is_place = 1 == n_pages || first != [0; 3];
        is_place.then_some(Self { page_idx: number("IFD")?, n_pages, first })
    }

    /// The page of a slice, channel and time, if it begins a block.
    fn page_of(&self, place: [usize; 3]) -> Option<usize> {
        let is_it = self.first == place && 0 < self.n_pages;
        is_it.then_some(self.page_idx)
    }
}
