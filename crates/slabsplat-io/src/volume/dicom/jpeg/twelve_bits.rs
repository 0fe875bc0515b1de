//! JPEG of 12 bits: extended sequential, Huffman codes, one component (T.81 §F).
//!
//! ```text
//! for every block of 8 × 8 pixels, rows first:
//!     the difference of its mean from the one before, and runs of zeros before each other coefficient
//!     coefficients · quantisation → inverse cosine transform → + 2048, within 0 … 4095
//! ```

use super::super::coded::CodedImage;
use super::super::frame::Layout;
use super::super::segments::{Broken, END_OF_IMAGE, RESTART_INTERVAL, START_OF_SCAN, Segments};
use super::huffman::{Bits, Codes};
use super::idct::Idct;

/// Extended sequential, Huffman codes.
const START_OF_FRAME: u8 = 0xc1;
const HUFFMAN_TABLES: u8 = 0xc4;
const QUANTISATION_TABLES: u8 = 0xdb;

/// Where the coefficients that come one after the other are in a block (T.81 figure A.6).
const ZIGZAG: [u8; 64] = [
    0, 1, 8, 16, 9, 2, 3, 10, 17, 24, 32, 25, 18, 11, 4, 5, 12, 19, 26, 33, 40, 48, 41, 34, 27, 20,
    13, 6, 7, 14, 21, 28, 35, 42, 49, 56, 57, 50, 43, 36, 29, 22, 15, 23, 30, 37, 44, 51, 58, 59,
    52, 45, 38, 31, 39, 46, 53, 60, 61, 54, 47, 55, 62, 63,
];

/// The means of a block's pixels are around this.
const LEVEL: f32 = 2048.0;

/// What segments say before a scan.
#[derive(Default)]
struct Tables {
    quantisation: [Option<[f32; 64]>; 4],
    /// For the first coefficient of a block, and for the others.
    codes: [[Option<Codes>; 4]; 2],
    restart_interval: usize,
    /// The number of the quantisation table.
    quantised_by: Option<usize>,
}

/// The image of a stream whose size was checked.
pub(super) fn unpack(packed: &[u8], layout: &Layout) -> Result<CodedImage, Broken> {
    let mut segments = Segments::of(packed)?;
    let mut tables = Tables::default();
    loop {
        let segment = segments.next()?;
        let data = segment.data;
        match segment.marker {
            START_OF_FRAME => match *data {
                [_, _, _, _, _, 1, _, _, table] => tables.quantised_by = Some(table.into()),
                _ => return Err("colours of 12 bits cannot be read"),
            },
            0xc0..=0xc3 | 0xc5..=0xc7 | 0xc9..=0xcf => {
                return Err("12 bits are read as sequential JPEG alone");
            }
            HUFFMAN_TABLES => tables.add_codes(data)?,
            QUANTISATION_TABLES => tables.add_quantisation(data)?,
            RESTART_INTERVAL => match *data {
                [high, low] => tables.restart_interval = u16::from_be_bytes([high, low]).into(),
                _ => return Err("its restart interval is broken"),
            },
            START_OF_SCAN => {
                let samples = tables.scan(data, segments.rest(), layout)?;
                return Ok(CodedImage { samples, precision: 12, is_signed: false });
            }
            END_OF_IMAGE => return Err("it has no scan"),
            _ => {}
        }
    }
}

impl Tables {
    /// §B.2.4.2.
    fn add_codes(&mut self, mut data: &[u8]) -> Result<(), Broken> {
        while let [head, rest @ ..] = data {
            let (class, number) = (usize::from(head >> 4), usize::from(head & 15));
            let (codes, rest) = Codes::of(rest)?;
            let class = self.codes.get_mut(class).ok_or("its Huffman tables are broken")?;
            *class.get_mut(number).ok_or("its Huffman tables are broken")? = Some(codes);
            data = rest;
        }
        Ok(())
    }

    /// §B.2.4.1.
    fn add_quantisation(&mut self, mut data: &[u8]) -> Result<(), Broken> {
        const BROKEN: Broken = "its quantisation tables are broken";
        while let [head, rest @ ..] = data {
            let (number, n_each) = (usize::from(head & 15), if *head >> 4 == 0 { 1 } else { 2 });
            let (steps, rest) = rest.split_at_checked(64 * n_each).ok_or(BROKEN)?;
            let step = |bytes: &[u8]| bytes.iter().fold(0.0, |n, &b| 256.0 * n + f32::from(b));
            let mut table = [0.0; 64];
            for (&at, bytes) in ZIGZAG.iter().zip(steps.chunks_exact(n_each)) {
                table[usize::from(at)] = step(bytes);
            }
            *self.quantisation.get_mut(number).ok_or(BROKEN)? = Some(table);
            data = rest;
        }
        Ok(())
    }

    fn scan(&self, header: &[u8], bits: &[u8], layout: &Layout) -> Result<Vec<i32>, Broken> {
        let &[1, _, tables, ..] = header else { return Err("its scan is of several components") };
        let codes = |class: usize, number: u8| {
            self.codes[class].get(usize::from(number)).and_then(Option::as_ref)
        };
        let steps = self.quantised_by.and_then(|table| self.quantisation.get(table)?.as_ref());
        let (Some(first), Some(others), Some(steps)) =
            (codes(0, tables >> 4), codes(1, tables & 15), steps)
        else {
            return Err("its scan names tables that are not there");
        };
        let (rows, columns) = (layout.rows, layout.columns);
        let mut samples = vec![0; rows * columns];
        let mut blocks = Blocks { bits: Bits::of(bits), first, others, mean: 0 };
        let idct = Idct::new();
        let n_along = columns.div_ceil(8);
        for at in 0..n_along * rows.div_ceil(8) {
            if 0 < at && self.restart_interval != 0 && at.is_multiple_of(self.restart_interval) {
                blocks.bits.restart()?;
                blocks.mean = 0;
            }
            let values = idct.inverse(&blocks.next(steps)?);
            let (x, y) = (at % n_along * 8, at / n_along * 8);
            for (row, line) in values.chunks_exact(8).take(rows - y).enumerate() {
                let start = (y + row) * columns + x;
                let line = line.iter().take(columns - x);
                for (sample, value) in samples[start..].iter_mut().zip(line) {
                    *sample = (value + LEVEL).round().clamp(0.0, 4095.0) as i32;
                }
            }
        }
        Ok(samples)
    }
}

/// Blocks of a scan, as they come.
struct Blocks<'p> {
    bits: Bits<'p>,
    first: &'p Codes,
    others: &'p Codes,
    /// The first coefficient of the block before.
    mean: i32,
}

impl Blocks<'_> {
    /// The coefficients of the next block, times their steps (§F.2.2.1, §F.2.2.2).
    fn next(&mut self, steps: &[f32; 64]) -> Result<[f32; 64], Broken> {
        const BROKEN: Broken = "a block has more than 64 coefficients, or too large ones";
        let mut block = [0.0; 64];
        let n_bits = u32::from(self.first.read(&mut self.bits)?);
        // Of 12 bits a difference has up to 15 (table F.6).
        if 15 < n_bits {
            return Err(BROKEN);
        }
        self.mean = self.mean.wrapping_add(self.bits.extended(n_bits)?);
        block[0] = self.mean as f32 * steps[0];
        let mut at = 1;
        while at < 64 {
            let symbol = self.others.read(&mut self.bits)?;
            let (n_zeros, n_bits) = (usize::from(symbol >> 4), u32::from(symbol & 15));
            match (n_zeros, n_bits) {
                (15, 0) => at += 16,
                (_, 0) => break,
                _ => {
                    at += n_zeros;
                    let place = usize::from(*ZIGZAG.get(at).ok_or(BROKEN)?);
                    block[place] = self.bits.extended(n_bits)? as f32 * steps[place];
                    at += 1;
                }
            }
        }
        Ok(block)
    }
}
