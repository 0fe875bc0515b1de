//! JPEG-LS (ITU-T T.87, ISO/IEC 14495-1), lossless and near-lossless, of up to 16 bits.
//!
//! Own code, by the sections of the standard: the crates in Rust either bind the C++ library CharLS, or
//! decode one component and are known to overflow on broken streams (`pure_jpegls`), or bring all of a
//! toolkit of DICOM. Not read: mapping tables, restart intervals, point transforms, and the colour transforms
//! that HP added, none of which DICOM has.
//!
//! Reading order: `presets` (what a scan is decoded by), `scan` (its lines), `contexts` (what is known of
//! samples like the next), `bits`.

mod bits;
mod contexts;
mod presets;
mod scan;

use super::coded::CodedImage;
use super::frame::Layout;
use super::segments::{Broken, END_OF_IMAGE, FrameSize, RESTART_INTERVAL, START_OF_SCAN, Segments};
use presets::{Coding, Presets};
use scan::Scan;

/// Markers of JPEG-LS (§C.1.1).
const START_OF_FRAME: u8 = 0xf7;
const PRESETS: u8 = 0xf8;

/// Of an application: HP's colour transforms are in one.
const APPLICATION_8: u8 = 0xe8;

/// In which order the samples of several components come (§C.2.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Interleave {
    /// A component after the other, each in a scan of its own.
    None,
    Lines,
    Samples,
}

/// The image of a frame.
pub(super) fn unpack(packed: &[u8], layout: &Layout) -> Result<CodedImage, String> {
    let mut segments = Segments::of(packed)?;
    let mut image = Image { size: None, presets: Presets::default(), n_done: 0, samples: vec![] };
    while image.size.is_none_or(|size| image.n_done < size.n_components) {
        let segment = segments.next()?;
        let data = segment.data;
        match segment.marker {
            START_OF_FRAME if image.size.is_none() => {
                let size = FrameSize::of(data)?;
                layout.check_coded(&size)?;
                image.samples = vec![0; size.rows * size.columns * size.n_components];
                image.size = Some(size);
            }
            PRESETS => image.presets = Presets::of(data)?,
            START_OF_SCAN => {
                let n_read = image.scan(data, segments.rest())?;
                segments.pass_over(n_read);
            }
            RESTART_INTERVAL if data.iter().any(|byte| *byte != 0) => {
                return Err("restart intervals cannot be read".to_owned());
            }
            APPLICATION_8 if matches!(data, [b'm', b'r', b'f', b'x', 1..=0xff, ..]) => {
                return Err("colours transformed as HP does cannot be read".to_owned());
            }
            END_OF_IMAGE => return Err("it ends before its image does".to_owned()),
            _ => {}
        }
    }
    let precision = image.size.map_or(0, |size| size.precision);
    Ok(CodedImage { samples: image.samples, precision, is_signed: false })
}

/// An image, as far as it has come.
struct Image {
    size: Option<FrameSize>,
    presets: Presets,
    /// Components that have come.
    n_done: usize,
    samples: Vec<i32>,
}

impl Image {
    /// Decodes a scan, of which the bytes that it takes are returned.
    fn scan(&mut self, header: &[u8], bits: &[u8]) -> Result<usize, Broken> {
        const BROKEN: Broken = "the header of a scan is broken";
        let size = self.size.ok_or("a scan comes before its frame")?;
        let (&n_components, header) = header.split_first().ok_or(BROKEN)?;
        let n_components = usize::from(n_components);
        let (components, rest) = header.split_at_checked(2 * n_components).ok_or(BROKEN)?;
        let &[near, interleave, shift] = rest else { return Err(BROKEN) };
        if components.chunks_exact(2).any(|component| component[1] != 0) {
            return Err("mapping tables cannot be read");
        }
        if shift != 0 {
            return Err("shifted samples cannot be read");
        }
        let interleave = match interleave {
            _ if n_components == 1 => Interleave::None,
            1 => Interleave::Lines,
            2 => Interleave::Samples,
            _ => return Err(BROKEN),
        };
        if n_components == 0 || size.n_components < self.n_done + n_components {
            return Err(BROKEN);
        }
        let coding = Coding::of(&self.presets, size.precision, near.into())?;
        let mut scan = Scan::new(bits, coding, size.columns, n_components);
        let pixels = self.samples.chunks_exact_mut(size.n_components);
        let mut pixels: Vec<&mut [i32]> =
            pixels.map(|pixel| &mut pixel[self.n_done..][..n_components]).collect();
        pixels.chunks_exact_mut(size.columns).try_for_each(|line| scan.line(line, interleave))?;
        self.n_done += n_components;
        Ok(scan.n_read())
    }
}

#[cfg(test)]
mod tests;
