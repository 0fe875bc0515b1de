//! The pages of a TIFF, which all have one size and one type.

use std::io::{BufReader, ErrorKind};
use std::path::{Path, PathBuf};

use slabsplat_core::SampleType;
use tiff::decoder::{Decoder, DecodingSampleType, Limits};
use tiff::tags::{PhotometricInterpretation, Tag};
use tiff::{ColorType, TiffError, TiffUnsupportedError};

use super::super::colors::{Meaning, Values, unmultiply};
use super::super::stored::StoredType;
use crate::IoError;
use crate::store::{Store, StoredFile};

/// No packing that the crate knows makes more of a byte: deflate's 1032, and LZW's codes of 12 bits for 4096
/// bytes.
const MAX_RATIO: u64 = 4096;

/// Of a single page.
const MAX_PAGE_BYTES: u64 = 8 << 30;

/// What `ExtraSamples` says of an alpha with which colours are multiplied.
const ASSOCIATED_ALPHA: u16 = 1;

/// What `PlanarConfiguration` says of values that are images of their own.
const PLANAR: u16 = 2;

/// The bit of `NewSubfileType` for a page that is another one made smaller.
const IS_REDUCED: u32 = 1;

/// A file whose pages have been looked at, and not read.
pub(in crate::volume) struct Pages<'b> {
    path: PathBuf,
    n_bytes: u64,
    decoder: Decoder<BufReader<StoredFile<'b>>>,
    /// Places among all pages of those that are not smaller ones of others.
    indices: Vec<usize>,
    /// Pixels in a row, and rows.
    pub(in crate::volume) size: [usize; 2],
    pub(in crate::volume) stored: StoredType,
    /// Values of a pixel.
    pub(in crate::volume) n_values: usize,
    kind: PixelKind,
    /// What the first page says of all.
    pub(super) description: String,
    /// Pixels per unit of length to the right and downwards, as the first page says.
    pub(super) resolution: [Option<f64>; 2],
}

/// What the values of a pixel are, and how they are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct PixelKind {
    is_color: bool,
    /// Whether colours are multiplied with their alpha.
    is_multiplied: bool,
    /// Whether each value is an image of its own.
    is_planar: bool,
}

impl<'b> Pages<'b> {
    pub(in crate::volume) fn open(store: Store<'b>, path: &Path) -> Result<Self, IoError> {
        let file = store.open(path)?;
        let n_bytes = file.n_bytes().map_err(IoError::read(path))?;
        let decoder = decoder(path, file, n_bytes)?;
        let mut pages = Self {
            path: path.to_owned(),
            n_bytes,
            decoder,
            indices: Vec::new(),
            size: [0; 2],
            stored: StoredType::U8_SAMPLE,
            n_values: 1,
            kind: PixelKind { is_color: false, is_multiplied: false, is_planar: false },
            description: String::new(),
            resolution: [None; 2],
        };
        pages.look_at_first()?;
        pages.look_at_all()?;
        pages.check_backed()?;
        Ok(pages)
    }

    /// The same pages, to be read on another thread.
    pub(super) fn again<'s>(&self, store: Store<'s>) -> Result<Pages<'s>, IoError> {
        let path = self.path.as_path();
        let decoder = decoder(path, store.open(path)?, self.n_bytes)?;
        let indices = self.indices.clone();
        let Self { n_bytes, size, stored, n_values, kind, resolution, .. } = *self;
        Ok(Pages {
            path: path.to_owned(),
            n_bytes,
            decoder,
            indices,
            size,
            stored,
            n_values,
            kind,
            description: String::new(),
            resolution,
        })
    }

    /// How many there are.
    pub(in crate::volume) fn len(&self) -> usize {
        self.indices.len()
    }

    /// Whether its metadata say that other files belong to it.
    pub(in crate::volume) fn is_of_many_files(&self) -> bool {
        let says = |word: &str| self.description.contains(word);
        says("<OME") && (says("<UUID FileName=") || says("<BinaryOnly"))
    }

    /// What the values of a pixel are.
    pub(in crate::volume) fn values(&self) -> Values {
        let meaning = if self.kind.is_color { Meaning::Color } else { Meaning::Other };
        Values { n: self.n_values, stored: self.stored, meaning }
    }

    /// Whether pages are of one size and one kind of pixels, so that they may be slices of one volume.
    pub(in crate::volume) fn are_like(&self, other: &Self) -> bool {
        let like = |pages: &Self| (pages.size, pages.stored, pages.n_values, pages.kind);
        like(self) == like(other)
    }

    /// The bytes of a page, in this machine's byte order, with all values of a pixel next to each other.
    pub(in crate::volume) fn read_into(
        &mut self,
        page_idx: usize,
        page: &mut Vec<u8>,
    ) -> Result<(), IoError> {
        let Self { path, decoder, indices, size, stored, n_values, kind, .. } = self;
        let in_file = |error: TiffError| to_io_error(path, error);
        decoder.seek_to_image(indices[page_idx]).map_err(in_file)?;
        let pixel_bytes = stored.size_bytes() * *n_values;
        let n_bytes = size[0].saturating_mul(size[1]).saturating_mul(pixel_bytes);
        let n_in_file = decoder.image_buffer_layout().map_err(in_file)?.complete_len;
        if n_in_file != n_bytes {
            let what = format!("page {page_idx} has {n_in_file} bytes, not {n_bytes}");
            return Err(IoError::malformed(path.as_path(), what));
        }
        page.clear();
        page.resize(n_bytes, 0);
        decoder.read_image_bytes(page).map_err(in_file)?;
        if kind.is_planar {
            *page = interleaved(page, stored.size_bytes(), *n_values);
        }
        if kind.is_multiplied {
            unmultiply(page, stored.widest());
        }
        Ok(())
    }

    fn look_at_first(&mut self) -> Result<(), IoError> {
        (self.size, self.stored, self.n_values, self.kind) = self.size_and_type()?;
        let [width, height] = self.size.map(|n| n as u64);
        let n_bytes = width.saturating_mul(height).saturating_mul(self.pixel_bytes());
        if MAX_PAGE_BYTES < n_bytes {
            let what = format!("pages of {width} x {height} pixels are too large");
            return Err(IoError::unsupported(self.path.as_path(), what));
        }
        self.description = self.description_of_page().unwrap_or_default();
        self.resolution = [Tag::XResolution, Tag::YResolution].map(|tag| self.ratio(tag));
        Ok(())
    }

    fn pixel_bytes(&self) -> u64 {
        (self.stored.size_bytes() * self.n_values) as u64
    }

    /// `None` if it is longer than the file: the crate prints that where nobody asked.
    fn description_of_page(&mut self) -> Option<String> {
        let entry = self.decoder.image_ifd().find_entry(Tag::ImageDescription)?;
        let is_backed = entry.count() <= self.n_bytes;
        is_backed.then(|| self.decoder.get_tag_ascii_string(Tag::ImageDescription).ok())?
    }

    fn ratio(&mut self, tag: Tag) -> Option<f64> {
        let terms = self.decoder.get_tag(tag).ok()?.into_u32_vec().ok();
        let number = match terms.as_deref() {
            Some([numerator, denominator]) => f64::from(*numerator) / f64::from(*denominator),
            _ => self.decoder.get_tag_f64(tag).ok()?,
        };
        Some(number).filter(|number| number.is_normal() && 0.0 < *number)
    }

    fn look_at_all(&mut self) -> Result<(), IoError> {
        for page_idx in 0.. {
            if 0 < page_idx {
                if !self.decoder.more_images() {
                    break;
                }
                self.decoder.next_image().map_err(|error| to_io_error(&self.path, error))?;
            }
            let kind = self.decoder.find_tag_unsigned::<u32>(Tag::NewSubfileType).ok().flatten();
            if kind.unwrap_or(0) & IS_REDUCED == 0 {
                self.check_like_first(page_idx)?;
                self.indices.push(page_idx);
            }
        }
        if self.indices.is_empty() {
            return Err(IoError::malformed(
                self.path.as_path(),
                "the file has no page of full size",
            ));
        }
        Ok(())
    }

    /// Pages that share their strips are each sound, and together as large as nobody's memory.
    fn check_backed(&self) -> Result<(), IoError> {
        let page_bytes = self.size[0].saturating_mul(self.size[1]) as u64;
        let page_bytes = page_bytes.saturating_mul(self.pixel_bytes());
        let n_bytes = page_bytes.saturating_mul(self.indices.len() as u64);
        if self.n_bytes.saturating_mul(MAX_RATIO) < n_bytes {
            let what = format!(
                "its pages say to have {n_bytes} bytes, more than the file could unpack to"
            );
            return Err(self.malformed(what));
        }
        Ok(())
    }

    fn check_like_first(&mut self, page_idx: usize) -> Result<(), IoError> {
        let (size, stored, n_values, kind) = self.size_and_type()?;
        if (size, stored, n_values, kind) == (self.size, self.stored, self.n_values, self.kind) {
            return Ok(());
        }
        let ([w, h], [w0, h0]) = (size, self.size);
        let values = Values { n: n_values, stored, ..self.values() };
        let what = format!(
            "page {page_idx} has {w} x {h} pixels of {values}, the first {w0} x {h0} of {}: a volume needs \
             slices of one size and type",
            self.values()
        );
        Err(IoError::unsupported(self.path.as_path(), what))
    }

    /// Of the page that the decoder is at.
    fn size_and_type(&mut self) -> Result<([usize; 2], StoredType, usize, PixelKind), IoError> {
        let in_file = |error: TiffError| to_io_error(&self.path, error);
        let (width, height) = self.decoder.dimensions().map_err(in_file)?;
        let color = self.decoder.colortype().map_err(in_file)?;
        let unsupported = |what: String| Err(IoError::unsupported(self.path.as_path(), what));
        let Some((n_values, is_color)) = values_of(color) else {
            let what = "pages of other colours than RGB, or of less than 8 bits, cannot be read: save them \
                        in gray or RGB";
            return unsupported(format!("{what} ({color:?})"));
        };
        let decoded = self.decoder.image_buffer_layout().map_err(in_file)?.sample_type;
        let Some(stored) = decoded.map(stored_type) else {
            return unsupported("pixels of an unknown type cannot be read".to_owned());
        };
        let kind = PixelKind {
            is_color,
            is_multiplied: n_values == 4
                && is_color
                && self.has(Tag::ExtraSamples, ASSOCIATED_ALPHA),
            is_planar: 1 < n_values && self.has(Tag::PlanarConfiguration, PLANAR),
        };
        Ok(([width as usize, height as usize], stored, n_values, kind))
    }

    /// Whether a tag's first number is that one.
    fn has(&mut self, tag: Tag, number: u16) -> bool {
        let numbers = self.decoder.find_tag_unsigned_vec::<u16>(tag).ok().flatten();
        numbers.and_then(|numbers| numbers.first().copied()) == Some(number)
    }

    pub(super) fn malformed(&self, what: impl Into<String>) -> IoError {
        IoError::malformed(self.path.as_path(), what)
    }

    pub(in crate::volume) fn unsupported(&self, what: impl Into<String>) -> IoError {
        IoError::unsupported(self.path.as_path(), what)
    }
}

/// A decoder that takes no more memory than a file of `n_bytes` could unpack to.
fn decoder<'b>(
    path: &Path,
    file: StoredFile<'b>,
    n_bytes: u64,
) -> Result<Decoder<BufReader<StoredFile<'b>>>, IoError> {
    let mut limits = Limits::default();
    let most = n_bytes.saturating_mul(MAX_RATIO).min(MAX_PAGE_BYTES);
    limits.decoding_buffer_size = usize::try_from(most).unwrap_or(usize::MAX);
    let decoder = Decoder::new(BufReader::new(file));
    Ok(decoder.map_err(|error| to_io_error(path, error))?.with_limits(limits))
}

/// The number of a pixel's values, and whether they are a colour; `None` of what is not read.
fn values_of(color: ColorType) -> Option<(usize, bool)> {
    match color {
        ColorType::Gray(8 | 16 | 32 | 64) => Some((1, false)),
        ColorType::GrayA(8 | 16 | 32 | 64) => Some((2, true)),
        ColorType::RGB(8 | 16 | 32 | 64) => Some((3, true)),
        ColorType::RGBA(8 | 16 | 32 | 64) => Some((4, true)),
        ColorType::Multiband { bit_depth: 8 | 16 | 32 | 64, num_samples } => {
            Some((num_samples.into(), false))
        }
        _ => None,
    }
}

/// Values that came one image after the other, pixel by pixel.
fn interleaved(planes: &[u8], sample_bytes: usize, n_values: usize) -> Vec<u8> {
    let plane_bytes = planes.len() / n_values;
    let samples = (0..plane_bytes).step_by(sample_bytes);
    let pixels = samples.flat_map(|at| (0..n_values).map(move |plane| plane * plane_bytes + at));
    pixels.flat_map(|at| &planes[at..at + sample_bytes]).copied().collect()
}

fn stored_type(decoded: DecodingSampleType) -> StoredType {
    StoredType::Sample(match decoded {
        DecodingSampleType::U8 => SampleType::U8,
        DecodingSampleType::U16 => SampleType::U16,
        DecodingSampleType::U32 => SampleType::U32,
        DecodingSampleType::I8 => SampleType::I8,
        DecodingSampleType::I16 => SampleType::I16,
        DecodingSampleType::I32 => SampleType::I32,
        DecodingSampleType::F32 => SampleType::F32,
        DecodingSampleType::F64 => SampleType::F64,
        DecodingSampleType::U64 => return StoredType::U64,
        DecodingSampleType::I64 => return StoredType::I64,
        DecodingSampleType::F16 => return StoredType::F16,
    })
}

fn to_io_error(path: &Path, error: TiffError) -> IoError {
    match error {
        TiffError::IoError(source) if source.kind() == ErrorKind::UnexpectedEof => {
            IoError::malformed(path, "the file is cut off: a page is not all there")
        }
        TiffError::IoError(source) => IoError::Read { path: path.to_owned(), source },
        TiffError::UnsupportedError(TiffUnsupportedError::UnsupportedCompressionMethod(method)) => {
            let what = format!(
                "pages packed by {} cannot be read: `tiffcp -c zip` packs them by Deflate",
                packing(method.to_u16())
            );
            IoError::unsupported(path, what)
        }
        TiffError::UnsupportedError(TiffUnsupportedError::InterpretationWithBits(
            PhotometricInterpretation::RGBPalette,
            _,
        )) => {
            let what = "pixels are numbers of a palette's colours, which cannot be read: ImageJ's Image > \
                        Type > RGB Color makes colours of them";
            IoError::unsupported(path, what)
        }
        TiffError::UnsupportedError(error) => IoError::unsupported(path, error.to_string()),
        TiffError::LimitsExceeded => {
            IoError::malformed(path, "a page says to be larger than what the file could unpack to")
        }
        other => IoError::malformed(path, format!("not a sound TIFF: {other}")),
    }
}

/// The name of a packing that the crate does not know, by its number in the file.
fn packing(code: u16) -> String {
    let name = match code {
        2..=4 => "the codes of fax machines",
        6 => "the old way of JPEG",
        34661 => "JBIG",
        34712 | 33003..=33005 => "JPEG 2000",
        34887 => "LERC",
        34892 => "lossy JPEG of DNG",
        34925 => "LZMA",
        34926 | 50000 => "Zstandard",
        34927 | 50001 => "WebP",
        34933 => "PNG",
        34934 | 22610 => "JPEG XR",
        50002 | 52546 => "JPEG XL",
        _ => return format!("method {code}"),
    };
    name.to_owned()
}
