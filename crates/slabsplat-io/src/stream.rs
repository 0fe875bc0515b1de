//! Streams that cannot be read twice, as standard input and pipes: kept in memory, since most formats are not
//! read from front to back.

use std::io::{self, Read};

use crate::IoError;
use crate::memory::{MemoryNeed, MemoryNeeds, free_bytes};

/// Memory grows by at least so much.
const MIN_GROWTH_BYTES: usize = 1 << 20;

/// All that a stream gives, for [`FilesInMemory`](crate::FilesInMemory); `name` stands for it in messages.
/// Memory grows with what comes, as long as there is some.
///
/// ```
/// use slabsplat_io::{FilesInMemory, read_stream};
///
/// let stream = b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n\n12345678";
/// let bytes = read_stream("standard input", &mut stream.as_slice())?;
/// let files = FilesInMemory::from_iter([("standard input", bytes.as_slice())]);
/// assert_eq!(files.read_volume("standard input")?.volume.grid().dims(), [2, 2, 2]);
/// # Ok::<(), slabsplat_io::IoError>(())
/// ```
///
/// # Errors
/// If reading fails, or if what comes has no room in memory.
pub fn read_stream(name: &str, stream: &mut impl Read) -> Result<Vec<u8>, IoError> {
    read_within(name, stream, free_bytes)
}

fn read_within(
    name: &str,
    stream: &mut impl Read,
    free_bytes: impl Fn() -> Option<u64>,
) -> Result<Vec<u8>, IoError> {
    let mut bytes = Vec::new();
    loop {
        let growth = (bytes.len() / 2).max(MIN_GROWTH_BYTES);
        if let Some(free_bytes) = free_bytes().filter(|&free| free < growth as u64) {
            let need = (bytes.len() as u64).saturating_add(growth as u64);
            let needs = MemoryNeeds(vec![MemoryNeed { what: name.to_owned(), bytes: need }]);
            return Err(IoError::OutOfMemory { needs, free_bytes });
        }
        bytes.try_reserve_exact(growth).map_err(|error| {
            IoError::read(name)(io::Error::new(io::ErrorKind::OutOfMemory, error))
        })?;
        let n_read = stream
            .by_ref()
            .take(growth as u64)
            .read_to_end(&mut bytes)
            .map_err(IoError::read(name))?;
        if n_read < growth {
            return Ok(bytes);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stream_is_read_to_its_end() {
        for n_bytes in [0, 1, MIN_GROWTH_BYTES - 1, MIN_GROWTH_BYTES, 5 * MIN_GROWTH_BYTES + 3] {
            let expected: Vec<u8> = (0..n_bytes).map(|n| (n % 251) as u8).collect();
            assert_eq!(read_stream("a", &mut expected.as_slice()).unwrap(), expected);
        }
    }

    #[test]
    fn stream_ends_where_memory_does() {
        let mut endless = io::repeat(7);
        let error = read_within("standard input", &mut endless, || Some(3 << 20)).unwrap_err();
        let error = error.to_string();
        assert!(error.contains("standard input") && error.contains("3.0 MiB are free"), "{error}");
    }
}
