//! How large a film is, how long, and how fast.

use crate::FilmError;

/// Frames a second, in thousandths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameRate {
    thousandths: u32,
}

/// What the frames of a film are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct FilmDesc {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// How many frames there are, 1 … 100000.
    pub n_frames: u32,
    /// How fast they follow each other.
    pub rate: FrameRate,
    /// Whether something may shine through them. Formats without opacity show such frames before black.
    pub has_opacity: bool,
    /// Threads that an encoder may use beside the renderer's.
    pub n_threads: usize,
}

impl FrameRate {
    /// The slowest and the fastest, in frames a second.
    pub const RANGE: [f64; 2] = [0.1, 240.0];

    /// So many frames a second, to the thousandth.
    ///
    /// # Errors
    /// If they are not 0.1 to 240.
    pub fn new(frames_per_second: f64) -> Result<Self, FilmError> {
        let [min, max] = Self::RANGE;
        if !(min..=max).contains(&frames_per_second) {
            return Err(FilmError::BadRate(frames_per_second));
        }
        Ok(Self { thousandths: (frames_per_second * 1000.0).round() as u32 })
    }

    /// Frames a second.
    pub fn per_second(self) -> f64 {
        f64::from(self.thousandths) / 1000.0
    }

    /// The same as a fraction in lowest terms.
    pub(crate) fn fraction(self) -> [u32; 2] {
        let divisor = (1..=1000)
            .rev()
            .find(|n| self.thousandths.is_multiple_of(*n) && 1000_u32.is_multiple_of(*n));
        let divisor = divisor.unwrap_or(1);
        [self.thousandths / divisor, 1000 / divisor]
    }

    /// For how many of a clock's ticks a frame is seen. They are whole, and so differ by one between frames;
    /// no frame is late by more than half a tick.
    pub(crate) fn ticks(self, frame_idx: u32, per_second: u32) -> u32 {
        let thousandths = u64::from(self.thousandths);
        let begin = |idx: u32| {
            (u64::from(idx) * u64::from(per_second) * 1000 + thousandths / 2) / thousandths
        };
        // A frame of the slowest film lasts 10 seconds.
        (begin(frame_idx + 1) - begin(frame_idx)) as u32
    }
}

impl FilmDesc {
    /// The most frames of a film: more than an hour at 25 a second.
    pub const MAX_FRAMES: u32 = 100_000;

    /// Opaque frames of that size.
    ///
    /// # Errors
    /// If there are none, or too many.
    pub fn new(width: u32, height: u32, n_frames: u32, rate: FrameRate) -> Result<Self, FilmError> {
        if !(1..=Self::MAX_FRAMES).contains(&n_frames) {
            return Err(FilmError::BadLength { n_frames: n_frames.into(), rate });
        }
        Ok(Self { width, height, n_frames, rate, has_opacity: false, n_threads: 1 })
    }

    /// The number of frames that a film of so many seconds has: at least one.
    ///
    /// # Errors
    /// If the seconds are no positive number, or there are too many.
    pub fn n_frames_of(seconds: f64, rate: FrameRate) -> Result<u32, FilmError> {
        if !(seconds.is_finite() && 0.0 < seconds) {
            return Err(FilmError::BadSeconds(seconds));
        }
        let n_frames = (seconds * rate.per_second()).round().max(1.0);
        if f64::from(Self::MAX_FRAMES) < n_frames {
            return Err(FilmError::BadLength { n_frames, rate });
        }
        Ok(n_frames as u32)
    }

    /// The same with frames through which something may shine, or not.
    #[must_use]
    pub fn has_opacity(self, has_opacity: bool) -> Self {
        Self { has_opacity, ..self }
    }

    /// The same with so many threads for an encoder.
    #[must_use]
    pub fn n_threads(self, n_threads: usize) -> Self {
        Self { n_threads: n_threads.max(1), ..self }
    }

    /// How long the film is, in seconds.
    pub fn seconds(&self) -> f64 {
        f64::from(self.n_frames) / self.rate.per_second()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frame_rate_ticks_add_up() {
        for (rate, per_second) in [(30.0, 100), (25.0, 100), (29.97, 1000), (0.1, 100), (7.3, 1000)]
        {
            let rate = FrameRate::new(rate).unwrap();
            let mut sum = 0;
            for idx in 0..500 {
                sum += rate.ticks(idx, per_second);
                let exact = f64::from(idx + 1) / rate.per_second() * f64::from(per_second);
                assert!((f64::from(sum) - exact).abs() <= 0.5 + 1e-6, "{rate:?} {idx}");
            }
        }
        assert_eq!([0, 1, 2].map(|idx| FrameRate::new(30.0).unwrap().ticks(idx, 100)), [3, 4, 3]);
    }

    #[test]
    fn frame_rate_is_a_fraction() {
        let fraction = |rate| FrameRate::new(rate).unwrap().fraction();
        assert_eq!(fraction(25.0), [25, 1]);
        assert_eq!(fraction(29.97), [2997, 100]);
        assert_eq!(fraction(23.976), [2997, 125]);
        assert_eq!(fraction(0.1), [1, 10]);
    }

    #[test]
    fn film_length_has_bounds() {
        let rate = FrameRate::new(25.0).unwrap();
        assert_eq!(FilmDesc::n_frames_of(6.0, rate).unwrap(), 150);
        assert_eq!(FilmDesc::n_frames_of(1e-9, rate).unwrap(), 1);
        for seconds in [0.0, -1.0, f64::NAN, f64::INFINITY, 4001.0] {
            assert!(FilmDesc::n_frames_of(seconds, rate).is_err(), "{seconds}");
        }
        assert!(FilmDesc::new(1, 1, 0, rate).is_err());
        for rate in [0.0, 0.09, 241.0, f64::NAN, -25.0] {
            assert!(FrameRate::new(rate).is_err(), "{rate}");
        }
        let error = FilmDesc::n_frames_of(4001.0, rate).unwrap_err().to_string();
        assert_eq!(
            error,
            "a film has 1 to 100000 frames, which last 4000 seconds at 25 a second, and not 100025"
        );
    }
}
