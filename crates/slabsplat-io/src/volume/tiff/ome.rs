//! OME-XML in the description of a first page: what the pages are.
//!
//! Schema: <https://docs.openmicroscopy.org/ome-model/latest/ome-tiff/specification.html>.

use roxmltree::{Document, Node};

use super::super::units;
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
    /// `TiffData` blocks, which say which pages are of which slices.
    named: Vec<Block>,
    /// Sizes of voxels, with their units.
    sizes: [Option<(f64, String)>; 3],
}

/// A page, and the file that it is in; `None` is the one that was opened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Page {
    pub(super) file: Option<String>,
    pub(super) page_idx: usize,
}

/// Pages that follow each other from one on, in the order that is said, and the place of the first.
#[derive(Debug)]
struct Block {
    page: Page,
    n_pages: usize,
    /// Slice, channel, time.
    first: [usize; 3],
}

impl Ome {
    /// `None` if the description is none of OME's; `own_name` is that of the file it is of, whose pixels
    /// have so many values.
    pub(super) fn of(
        description: &str,
        own_name: &str,
        n_values: usize,
    ) -> Option<Result<Self, String>> {
        ome_xml(description).map(|text| Self::parse(text, own_name, n_values))
    }

    fn parse(text: &str, own_name: &str, n_values: usize) -> Result<Self, String> {
        let document = document(text)?;
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
            // The values of a pixel are counted, too.
            n_channels: (count("SizeC")? / n_values).max(1),
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
        let named = blocks.map(|node| Block::of(&node, own_name)).collect();
        let sizes = ["X", "Y", "Z"].map(size);
        let channels = pixels.children().filter(|node| node.tag_name().name() == "Channel");
        let channel_names: Vec<String> =
            channels.filter_map(|node| node.attribute("Name").map(str::to_owned)).collect();
        let are_all = channel_names.len() == counts.n_channels;
        let channel_names = if are_all { channel_names } else { Vec::new() };
        Ok(Self { counts, channel_names, strides, named, sizes })
    }

    /// The pages of the channel and the time that are chosen, in a file that has so many.
    pub(super) fn slices(
        &self,
        [channel, time]: [usize; 2],
        n_pages: usize,
    ) -> Result<Vec<Page>, String> {
        let n_slices = self.counts.n_slices;
        let missing = || {
            format!(
                "its OME-XML tells of {n_slices} slices, which are not all in this file: open it whole"
            )
        };
        if !self.has_other_files() && n_pages < n_slices {
            return Err(missing());
        }
        let page_of = |z: usize| {
            let at = self.in_order([z, channel, time])?;
            let in_block = |block: &Block| {
                let first = self.in_order(block.first)?;
                Some((first, block.page_at(at, first)?))
            };
            // Blocks of all pages of their files end where the next begins.
            match self.named.iter().rev().filter_map(in_block).max_by_key(|(first, _)| *first) {
                Some((_, page)) => Some(page),
                None if self.has_places() => None,
                None => Some(Page { file: None, page_idx: at }),
            }
        };
        let is_there = |page: &Page| page.file.is_some() || page.page_idx < n_pages;
        let pages = (0..n_slices).map(|z| page_of(z).filter(is_there));
        pages.collect::<Option<_>>().ok_or_else(missing)
    }

    /// How many pages come before that of a slice, channel and time, if all are in order.
    fn in_order(&self, place: [usize; 3]) -> Option<usize> {
        let mut steps = place.into_iter().zip(self.strides);
        steps.try_fold(0_usize, |sum, (idx, stride)| sum.checked_add(idx.checked_mul(stride)?))
    }

    /// Whether blocks say of single pages where they belong, and not of all pages in their order.
    fn has_places(&self) -> bool {
        1 < self.named.len() || self.has_other_files()
    }

    fn has_other_files(&self) -> bool {
        self.named.iter().any(|block| block.page.file.is_some())
    }

    /// In millimetres.
    pub(super) fn spacing(&self, warnings: &mut Vec<String>) -> [f64; 3] {
        let [Some((x, x_unit)), Some((y, y_unit)), z] = &self.sizes else {
            warnings.push(units::NO_SIZE.to_owned());
            return [1.0; 3];
        };
        if z.is_none() && 1 < self.counts.n_slices {
            warnings.push(units::NO_DEPTH.to_owned());
        }
        let (z, z_unit) = z.as_ref().map_or((*x, x_unit), |(z, unit)| (*z, unit));
        units::in_millimetres([*x, *y, z], [x_unit, y_unit, z_unit], warnings)
    }
}

impl Block {
    fn of(node: &Node<'_, '_>, own_name: &str) -> Self {
        let number = |name: &str| node.attribute(name).and_then(|text| text.parse().ok());
        let first = ["FirstZ", "FirstC", "FirstT"].map(|name| number(name).unwrap_or(0));
        let uuid = node.children().find(|child| child.tag_name().name() == "UUID");
        let file = uuid.and_then(|uuid| uuid.attribute("FileName"));
        let file = file.filter(|name| *name != own_name).map(str::to_owned);
        // A block that names neither page nor number is of all pages of its file.
        let n_all = if number("IFD").is_some() { 1 } else { usize::MAX };
        let n_pages = number("PlaneCount").unwrap_or(n_all);
        Self { page: Page { file, page_idx: number("IFD").unwrap_or(0) }, n_pages, first }
    }

    /// The page of a place, if the block has it; both are counted as if all pages were in order.
    fn page_at(&self, at: usize, first: usize) -> Option<Page> {
        let after = at.checked_sub(first).filter(|&after| after < self.n_pages)?;
        Some(Page { page_idx: self.page.page_idx.checked_add(after)?, ..self.page.clone() })
    }
}

/// The file that has the OME-XML of this one, if another one has it.
pub(super) fn metadata_file(description: &str) -> Option<String> {
    let document = document(ome_xml(description)?).ok()?;
    let is_it = |node: &Node<'_, '_>| node.tag_name().name() == "BinaryOnly";
    document.descendants().find(is_it)?.attribute("MetadataFile").map(str::to_owned)
}

fn ome_xml(description: &str) -> Option<&str> {
    let text = description.trim_end_matches('\0').trim();
    (text.starts_with('<') && text.contains("<OME")).then_some(text)
}

fn document(text: &str) -> Result<Document<'_>, String> {
    Document::parse(text).map_err(|error| {
        let at = error.pos();
        format!("its OME-XML is broken in line {}, column {}", at.row, at.col)
    })
}
