//! Pieces of pictures as bytes: of the rows that somebody owns, the pixels that are not empty.
//!
//! ```text
//! a piece: for each row of the rectangle within the band: the number of runs (u16), then each run:
//!     pixels that are empty (u16), pixels that follow (u16), and these, 16 bytes each, as they are
//! ```
//!
//! A picture of a part of a volume is mostly empty, and what is not lies in rows side by side. Pixels are
//! sent as they are, all 16 bytes, so that the picture does not depend on the number of ranks.

use slabsplat::Image;
use std::ops::Range;

/// Pixels that are not empty lie within it: columns and rows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Extent {
    pub(crate) columns: Range<u32>,
    pub(crate) rows: Range<u32>,
}

/// A pixel.
type Pixel = [f32; 4];

impl Extent {
    /// Of all pixels of a picture that are not empty.
    pub(crate) fn of(image: &Image) -> Self {
        let width = image.width() as usize;
        let rows = image.pixels().chunks_exact(width).enumerate();
        let nothing = [u32::MAX, 0, u32::MAX, 0];
        let [x0, x1, y0, y1] = rows.fold(nothing, |[x0, x1, y0, y1], (y, row)| {
            let Some(first) = row.iter().position(|pixel| !is_empty(pixel)) else {
                return [x0, x1, y0, y1];
            };
            let last = row.iter().rposition(|pixel| !is_empty(pixel)).unwrap_or(first);
            let (y, first, last) = (y as u32, first as u32, last as u32);
            [x0.min(first), x1.max(last + 1), y0.min(y), y1.max(y + 1)]
        });
        if x0 == u32::MAX {
            Self { columns: 0..0, rows: 0..0 }
        } else {
            Self { columns: x0..x1, rows: y0..y1 }
        }
    }

    /// Whether it has pixels in a band of rows.
    pub(crate) fn meets(&self, band: &Range<u32>) -> bool {
        !self.rows_in(band).is_empty()
    }

    pub(crate) fn rows_in(&self, band: &Range<u32>) -> Range<u32> {
        self.rows.start.max(band.start)..self.rows.end.min(band.end)
    }

    pub(crate) fn to_bytes(&self) -> Vec<u8> {
        let numbers = [self.columns.start, self.columns.end, self.rows.start, self.rows.end];
        numbers.iter().flat_map(|n| n.to_le_bytes()).collect()
    }

    /// Nothing if that is none, or reaches beyond a picture of that size.
    pub(crate) fn from_bytes(bytes: &[u8], [width, height]: [u32; 2]) -> Option<Self> {
        let bytes: &[u8; 16] = bytes.try_into().ok()?;
        let (numbers, _) = bytes.as_chunks::<4>();
        let at = |idx: usize| u32::from_le_bytes(numbers[idx]);
        let extent = Self { columns: at(0)..at(1), rows: at(2)..at(3) };
        let fits = |range: &Range<u32>, n: u32| range.start <= range.end && range.end <= n;
        (fits(&extent.columns, width) && fits(&extent.rows, height)).then_some(extent)
    }
}

fn is_empty(pixel: &Pixel) -> bool {
    pixel.iter().all(|channel| *channel == 0.0)
}

/// The pixels of `extent` in a band of rows.
pub(crate) fn encode(image: &Image, extent: &Extent, band: &Range<u32>) -> Vec<u8> {
    let mut bytes = Vec::new();
    let columns = extent.columns.start as usize..extent.columns.end as usize;
    for y in extent.rows_in(band) {
        let start = y as usize * image.width() as usize;
        add_row(&mut bytes, &image.pixels()[start..][columns.clone()]);
    }
    bytes
}

/// Of one row.
fn add_row(bytes: &mut Vec<u8>, row: &[Pixel]) {
    let count_at = bytes.len();
    bytes.extend([0; 2]);
    let (mut n_runs, mut x) = (0_u16, 0);
    while let Some(skipped) = row[x..].iter().position(|pixel| !is_empty(pixel)) {
        let run = &row[x + skipped..];
        let n_pixels = run.iter().position(is_empty).unwrap_or(run.len());
        bytes.extend((skipped as u16).to_le_bytes());
        bytes.extend((n_pixels as u16).to_le_bytes());
        bytes.extend_from_slice(bytemuck::cast_slice(&run[..n_pixels]));
        (n_runs, x) = (n_runs + 1, x + skipped + n_pixels);
    }
    bytes[count_at..count_at + 2].copy_from_slice(&n_runs.to_le_bytes());
}

/// Calls `lay` with each run of a piece: its row and first column in the picture, and its pixels. Returns
/// nothing if the bytes are no piece of that extent and band.
pub(crate) fn decode(
    bytes: &[u8],
    extent: &Extent,
    band: &Range<u32>,
    mut lay: impl FnMut([u32; 2], &[Pixel]),
) -> Option<()> {
    let mut bytes = Reader(bytes);
    let mut pixels = Vec::new();
    for y in extent.rows_in(band) {
        let mut x = extent.columns.start;
        for _ in 0..bytes.number()? {
            x += u32::from(bytes.number()?);
            let n_pixels = u32::from(bytes.number()?);
            let run = bytes.take(n_pixels as usize * size_of::<Pixel>())?;
            let end = x.checked_add(n_pixels).filter(|end| *end <= extent.columns.end)?;
            pixels.clear();
            pixels.extend(run.as_chunks::<16>().0.iter().map(|pixel| pixel_of(*pixel)));
            lay([x, y], &pixels);
            x = end;
        }
    }
    bytes.0.is_empty().then_some(())
}

/// Bytes of messages need not lie where floats do.
fn pixel_of(bytes: [u8; 16]) -> Pixel {
    bytemuck::cast::<_, [[u8; 4]; 4]>(bytes).map(f32::from_ne_bytes)
}

struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    fn number(&mut self) -> Option<u16> {
        let (number, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(u16::from_le_bytes(*number))
    }

    fn take(&mut self, n_bytes: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(n_bytes)?;
        self.0 = rest;
        Some(taken)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use fastrand::Rng;
    use slabsplat_seeds::for_each_seed;

    /// Empty but for some rectangles, which have holes.
    pub(crate) fn random_image(rng: &mut Rng, [width, height]: [u32; 2]) -> Image {
        let mut image = Image::filled(width, height, [0.0; 4]);
        for _ in 0..rng.usize(..4) {
            let (x0, y0) = (rng.u32(..width), rng.u32(..height));
            let (x1, y1) = (rng.u32(x0..width) + 1, rng.u32(y0..height) + 1);
            let holes = rng.f32();
            for (x, y) in (y0..y1).flat_map(|y| (x0..x1).map(move |x| (x, y))) {
                if holes < rng.f32() {
                    let alpha = if rng.u8(..9) == 0 { 1.0 } else { rng.f32() };
                    let pixel = [rng.f32(), rng.f32(), rng.f32(), 1.0].map(|c| c * alpha);
                    image.pixels_mut()[(y * width + x) as usize] = pixel;
                }
            }
        }
        image
    }

    #[test]
    fn piece_is_what_it_was() {
        for_each_seed(60, |mut rng| {
            let size = [rng.u32(1..70), rng.u32(1..50)];
            let image = random_image(&mut rng, size);
            let extent = Extent::of(&image);
            assert_eq!(Extent::from_bytes(&extent.to_bytes(), size), Some(extent.clone()));
            let middle = rng.u32(..=size[1]);
            let mut again = Image::filled(size[0], size[1], [0.0; 4]);
            for band in [0..middle, middle..size[1]] {
                let bytes = encode(&image, &extent, &band);
                let laid = decode(&bytes, &extent, &band, |[x, y], run| {
                    let start = (y * size[0] + x) as usize;
                    again.pixels_mut()[start..start + run.len()].copy_from_slice(run);
                });
                assert_eq!(laid, Some(()));
                if !extent.meets(&band) {
                    assert!(bytes.is_empty());
                }
            }
            assert!(again == image, "{size:?} {extent:?}");
        });
    }

    /// Whatever it is made of, a piece is read within its extent or refused.
    #[test]
    fn hostile_pieces_are_refused() {
        for_each_seed(300, |mut rng| {
            let size = [rng.u32(1..20), rng.u32(1..20)];
            let image = random_image(&mut rng, size);
            let extent = Extent::of(&image);
            let band = 0..size[1];
            let mut bytes = encode(&image, &extent, &band);
            for _ in 0..rng.usize(1..4) {
                match rng.u8(..3) {
                    0 => bytes.truncate(rng.usize(..=bytes.len())),
                    1 => bytes.push(rng.u8(..)),
                    _ if bytes.is_empty() => {}
                    _ => {
                        let idx = rng.usize(..bytes.len());
                        bytes[idx] = rng.u8(..);
                    }
                }
            }
            let _ = decode(&bytes, &extent, &band, |[x, y], run| {
                assert!(x + run.len() as u32 <= extent.columns.end && extent.rows.contains(&y));
            });
            let any: [u8; 16] = std::array::from_fn(|_| rng.u8(..4));
            if let Some(extent) = Extent::from_bytes(&any, size) {
                assert!(extent.columns.end <= size[0] && extent.rows.end <= size[1]);
            }
        });
        assert_eq!(Extent::from_bytes(&[0; 15], [1, 1]), None);
    }
}
