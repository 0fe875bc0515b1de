//! Pixels packed by run lengths (PS3.5 §G): a segment for each byte of a pixel, the most significant first.

/// The bytes of a frame, least significant first; `None` if the segments are none, or too short.
pub(super) fn unpack(packed: &[u8], n_pixels: usize, pixel_bytes: usize) -> Option<Vec<u8>> {
    let word = |idx: usize| {
        let bytes = packed.get(4 * idx..4 * idx + 4)?;
        Some(u32::from_le_bytes(bytes.try_into().ok()?) as usize)
    };
    let n_segments = word(0)?;
    // An unpacked byte costs a 64th of a packed one at least.
    let is_backed = n_pixels.checked_mul(pixel_bytes)? <= packed.len().saturating_mul(64);
    if n_segments != pixel_bytes || 15 < n_segments || !is_backed {
        return None;
    }
    let mut bytes = vec![0; n_pixels * pixel_bytes];
    for segment in 0..n_segments {
        let start = word(1 + segment)?;
        let end = if segment + 1 < n_segments { word(2 + segment)? } else { packed.len() };
        let plane = pixel_bytes - 1 - segment;
        unpack_segment(packed.get(start..end)?, &mut bytes[plane..], pixel_bytes)?;
    }
    Some(bytes)
}

/// Writes every `stride`-th byte.
fn unpack_segment(mut packed: &[u8], bytes: &mut [u8], stride: usize) -> Option<()> {
    let mut out = bytes.iter_mut().step_by(stride);
    let mut n_left = out.len();
    while 0 < n_left {
        let (&control, rest) = packed.split_first()?;
        let control = usize::from(control);
        packed = match control {
            0..128 => {
                let n = control + 1;
                let literal = rest.get(..n)?;
                literal.iter().zip(&mut out).for_each(|(&byte, out)| *out = byte);
                n_left = n_left.saturating_sub(n);
                &rest[n..]
            }
            128 => rest,
            129.. => {
                let (&byte, rest) = rest.split_first()?;
                let n = 257 - control;
                out.by_ref().take(n).for_each(|out| *out = byte);
                n_left = n_left.saturating_sub(n);
                rest
            }
        };
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two pixels of 16 bits: 0x0102 and 0x0103, with a run and two literals.
    fn packed() -> Vec<u8> {
        let mut packed = [2_u32, 64, 66].iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<_>>();
        packed.resize(64, 0);
        packed.extend([255, 1, 1, 2, 3, 128]);
        packed
    }

    #[test]
    fn rle_planes_become_pixels() {
        assert_eq!(unpack(&packed(), 2, 2), Some(vec![2, 1, 3, 1]));
    }

    #[test]
    fn rle_that_breaks_off_is_none() {
        for n_bytes in 0..packed().len() - 1 {
            assert_eq!(unpack(&packed()[..n_bytes], 2, 2), None, "{n_bytes}");
        }
        assert_eq!(unpack(&packed(), 2, 1), None);
        assert_eq!(unpack(&packed(), usize::MAX, 2), None);
    }
}
