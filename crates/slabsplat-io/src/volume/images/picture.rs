//! One image in gray or in colours, whatever its file is packed by.

use std::io::BufReader;
use std::path::Path;

use image::codecs::png::PngDecoder;
use image::{ColorType, ImageDecoder, ImageError, Limits};
use jpeg_decoder::{Decoder as JpegDecoder, PixelFormat};
use slabsplat_core::SampleType;

use super::super::colors::{Meaning, Values};
use super::super::stream::first_bytes;
use super::super::tiff::Pages;
use crate::IoError;
use crate::store::{Store, StoredFile};

/// No packing of these makes more of a byte: deflate's 1032, of bytes with 8 pixels each.
const MAX_RATIO: u64 = 1032 * 8;

/// An image whose header has been read.
pub(super) struct Picture<'b> {
    /// Pixels in a row, and rows.
    pub(super) size: [usize; 2],
    pub(super) values: Values,
    pixels: Pixels<'b>,
}

enum Pixels<'b> {
    Tiff(Box<Pages<'b>>),
    Png(Box<PngDecoder<BufReader<StoredFile<'b>>>>),
    Jpeg(Box<JpegDecoder<BufReader<StoredFile<'b>>>>),
}

impl<'b> Picture<'b> {
    pub(super) fn open(store: Store<'b>, path: &Path) -> Result<Self, IoError> {
        let start = first_bytes(store, path)?;
        match start.as_slice() {
            [b'I', b'I', ..] | [b'M', b'M', ..] => Self::tiff(Pages::open(store, path)?),
            [0x89, b'P', b'N', b'G', ..] => Self::png(store, path),
            [0xff, 0xd8, ..] => Self::jpeg(store, path),
            _ => {
                Err(IoError::malformed(path, "not an image, or cut off: it does not begin as one"))
            }
        }
    }

    fn tiff(pages: Pages<'b>) -> Result<Self, IoError> {
        if pages.is_of_many_files() {
            return Err(pages.unsupported(
                "the file says itself which files belong to it (OME-TIFF): name it, not its folder",
            ));
        }
        if pages.len() != 1 {
            let what = format!("the file has {} pages, not one: name it alone", pages.len());
            return Err(pages.unsupported(what));
        }
        let (size, values) = (pages.size, pages.values());
        Ok(Self { size, values, pixels: Pixels::Tiff(Box::new(pages)) })
    }

    fn png(store: Store<'b>, path: &Path) -> Result<Self, IoError> {
        let file = store.open(path)?;
        let most = file.n_bytes().map_err(IoError::read(path))?.saturating_mul(MAX_RATIO);
        let mut limits = Limits::no_limits();
        limits.max_alloc = Some(most);
        let decoder = PngDecoder::with_limits(BufReader::new(file), limits);
        let decoder = decoder.map_err(|error| png_error(path, error))?;
        let values = match decoder.color_type() {
            ColorType::L8 => of(1, SampleType::U8),
            ColorType::L16 => of(1, SampleType::U16),
            ColorType::La8 => of(2, SampleType::U8),
            ColorType::La16 => of(2, SampleType::U16),
            ColorType::Rgb8 => of(3, SampleType::U8),
            ColorType::Rgb16 => of(3, SampleType::U16),
            ColorType::Rgba8 => of(4, SampleType::U8),
            ColorType::Rgba16 => of(4, SampleType::U16),
            other => return Err(of_other_colors(path, &format!("{other:?}"))),
        };
        let (width, height) = decoder.dimensions();
        let size = [width as usize, height as usize];
        check_size(path, size, &values, most)?;
        Ok(Self { size, values, pixels: Pixels::Png(Box::new(decoder)) })
    }

    fn jpeg(store: Store<'b>, path: &Path) -> Result<Self, IoError> {
        let file = store.open(path)?;
        let most = file.n_bytes().map_err(IoError::read(path))?.saturating_mul(MAX_RATIO);
        let mut decoder = JpegDecoder::new(BufReader::new(file));
        decoder.read_info().map_err(|error| jpeg_error(path, error))?;
        let info =
            decoder.info().ok_or_else(|| IoError::malformed(path, "a JPEG without an image"))?;
        let values = match info.pixel_format {
            PixelFormat::L8 => of(1, SampleType::U8),
            PixelFormat::L16 => of(1, SampleType::U16),
            PixelFormat::RGB24 => of(3, SampleType::U8),
            other @ PixelFormat::CMYK32 => {
                return Err(of_other_colors(path, &format!("{other:?}")));
            }
        };
        let size = [usize::from(info.width), usize::from(info.height)];
        check_size(path, size, &values, most)?;
        if MAX_JPEG_ROWS < size[1] {
            let what = format!("JPEGs of more than {MAX_JPEG_ROWS} rows cannot be read");
            return Err(IoError::unsupported(path, what));
        }
        decoder.set_max_decoding_buffer_size(2 * size[0] * size[1] * values.n);
        Ok(Self { size, values, pixels: Pixels::Jpeg(Box::new(decoder)) })
    }

    /// All values of pixels row by row, in this machine's byte order.
    pub(super) fn read_into(self, path: &Path, samples: &mut Vec<u8>) -> Result<(), IoError> {
        match self.pixels {
            Pixels::Tiff(mut pages) => pages.read_into(0, samples),
            Pixels::Png(decoder) => {
                samples.clear();
                samples.resize(self.size[0] * self.size[1] * pixel_bytes(&self.values), 0);
                decoder.read_image(samples).map_err(|error| png_error(path, error))
            }
            Pixels::Jpeg(mut decoder) => {
                *samples = decoder.decode().map_err(|error| jpeg_error(path, error))?;
                Ok(())
            }
        }
    }
}

/// `jpeg-decoder` counts rows in eights, in 16 bits.
pub(in crate::volume) const MAX_JPEG_ROWS: usize = 65_528;

/// Values of a pixel that are gray or a colour.
fn of(n: usize, sample_type: SampleType) -> Values {
    let meaning = if n == 1 { Meaning::Other } else { Meaning::Color };
    Values { n, stored: sample_type.into(), meaning }
}

fn pixel_bytes(values: &Values) -> usize {
    values.n * values.stored.size_bytes()
}

/// That a file can hold what its header says.
fn check_size(
    path: &Path,
    [width, height]: [usize; 2],
    values: &Values,
    most: u64,
) -> Result<(), IoError> {
    let n_pixels = (width as u64).saturating_mul(height as u64);
    if n_pixels.saturating_mul(pixel_bytes(values) as u64) <= most {
        return Ok(());
    }
    let what =
        format!("the image says to have {width} x {height} pixels, more than the file can hold");
    Err(IoError::malformed(path, what))
}

fn of_other_colors(path: &Path, color: &str) -> IoError {
    let what = "images of these colours cannot be read: save them in gray or RGB, of 8 or 16 bits";
    IoError::unsupported(path, format!("{what} ({color})"))
}

fn png_error(path: &Path, error: ImageError) -> IoError {
    match error {
        ImageError::IoError(source) if source.kind() != std::io::ErrorKind::UnexpectedEof => {
            IoError::Read { path: path.to_owned(), source }
        }
        ImageError::IoError(_) => IoError::malformed(path, "the PNG is cut off"),
        other => {
            IoError::malformed(path, format!("not a sound PNG: {}", one_line(&other.to_string())))
        }
    }
}

fn jpeg_error(path: &Path, error: jpeg_decoder::Error) -> IoError {
    match error {
        jpeg_decoder::Error::Io(source) if source.kind() != std::io::ErrorKind::UnexpectedEof => {
            IoError::Read { path: path.to_owned(), source }
        }
        jpeg_decoder::Error::Io(_) => IoError::malformed(path, "the JPEG is cut off"),
        other => {
            IoError::malformed(path, format!("not a sound JPEG: {}", one_line(&other.to_string())))
        }
    }
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
