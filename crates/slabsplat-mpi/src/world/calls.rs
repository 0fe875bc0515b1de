//! The calls to MPI, each made safe. All unsafe code that talks to MPI is here.

use crate::MpiError;
use std::cell::Cell;
use std::ffi::{c_char, c_int, c_void};
use std::marker::PhantomData;

/// MPI, which one thread calls: the one that has this.
#[derive(Debug)]
pub(super) struct Mpi {
    /// Not MPI's `MPI_COMM_WORLD`, but the same ranks with messages of their own.
    own: c_int,
    pub(super) rank: usize,
    pub(super) n_ranks: usize,
    /// The first rank on this computer.
    pub(super) first_here: usize,
    /// Whether it ends when this does.
    is_ours: bool,
    _one_thread: PhantomData<Cell<()>>,
}

/// A message on its way, which holds its bytes until it is sent.
#[derive(Debug)]
pub(super) struct Sending {
    request: *mut c_void,
    _bytes: Vec<u8>,
}

// Their contract is in `mpi.c`.
unsafe extern "C" {
    fn slabsplat_mpi_start(was_started: *mut c_int, comm: *mut c_int) -> c_int;
    fn slabsplat_mpi_dup(
        comm: c_int,
        own: *mut c_int,
        rank: *mut c_int,
        n_ranks: *mut c_int,
    ) -> c_int;
    fn slabsplat_mpi_first_here(own: c_int, first: *mut c_int) -> c_int;
    fn slabsplat_mpi_free(own: c_int) -> c_int;
    fn slabsplat_mpi_send(
        own: c_int,
        bytes: *const c_void,
        n_bytes: c_int,
        to: c_int,
        tag: c_int,
        request: *mut *mut c_void,
    ) -> c_int;
    fn slabsplat_mpi_is_done(request: *mut c_void, is_done: *mut c_int) -> c_int;
    fn slabsplat_mpi_probe(
        own: c_int,
        from: c_int,
        tag: c_int,
        is_there: *mut c_int,
        n_bytes: *mut c_int,
    ) -> c_int;
    fn slabsplat_mpi_receive(
        own: c_int,
        bytes: *mut c_void,
        n_bytes: c_int,
        from: c_int,
        tag: c_int,
    ) -> c_int;
    fn slabsplat_mpi_node(name: *mut c_char, n_bytes: c_int, length: *mut c_int) -> c_int;
    fn slabsplat_mpi_text(
        code: c_int,
        text: *mut c_char,
        n_bytes: c_int,
        length: *mut c_int,
    ) -> c_int;
    fn slabsplat_mpi_abort(own: c_int) -> c_int;
    fn slabsplat_mpi_end() -> c_int;
}

/// Bytes of a message, at most; a longer one goes on in the next.
pub(super) const MOST_BYTES: usize = 1 << 30;

impl Mpi {
    /// All ranks of the program.
    pub(super) fn start() -> Result<Self, MpiError> {
        let (mut was_started, mut comm) = (0, 0);
        // SAFETY: both are where an integer may be written.
        let code = unsafe { slabsplat_mpi_start(&raw mut was_started, &raw mut comm) };
        check("start", code)?;
        let mut mpi = Self::of(comm)?;
        mpi.is_ours = was_started == 0;
        Ok(mpi)
    }

    /// The ranks of a communicator, by its number in Fortran. MPI has to be started.
    pub(super) fn of(comm: c_int) -> Result<Self, MpiError> {
        let (mut own, mut rank, mut n_ranks) = (0, 0, 0);
        // SAFETY: all three are where an integer may be written; a number that is no communicator is an
        // error.
        let code =
            unsafe { slabsplat_mpi_dup(comm, &raw mut own, &raw mut rank, &raw mut n_ranks) };
        check("name the ranks", code)?;
        let [rank, n_ranks] = [rank, n_ranks].map(|n| n as usize);
        let mut mpi =
            Self { own, rank, n_ranks, first_here: 0, is_ours: false, _one_thread: PhantomData };
        let mut first = 0;
        // SAFETY: an integer may be written there; `own` is the communicator that was just made.
        let code = unsafe { slabsplat_mpi_first_here(own, &raw mut first) };
        check("find the ranks of a computer", code)?;
        mpi.first_here = first as usize;
        Ok(mpi)
    }

    /// Begins to send a message of no more than [`MOST_BYTES`].
    pub(super) fn send(&self, bytes: Vec<u8>, to: usize, tag: c_int) -> Result<Sending, MpiError> {
        let mut request = std::ptr::null_mut();
        let (start, n_bytes) = (bytes.as_ptr().cast(), bytes.len() as c_int);
        // SAFETY: as many bytes are there, and stay where they are, as `Sending` has the vector until it is
        // done; `request` may be written to.
        let code = unsafe {
            slabsplat_mpi_send(self.own, start, n_bytes, to as c_int, tag, &raw mut request)
        };
        check("send", code)?;
        Ok(Sending { request, _bytes: bytes })
    }

    /// Whether a message has been sent; if not, it comes back.
    pub(super) fn sent(&self, sending: Sending) -> Result<Option<Sending>, MpiError> {
        let mut is_done = 0;
        // SAFETY: a `Sending` has a request that is not done: whoever is told that it is has no `Sending` any
        // more. `is_done` may be written to.
        let code = unsafe { slabsplat_mpi_is_done(sending.request, &raw mut is_done) };
        if code != 0 {
            // MPI may still read the bytes.
            std::mem::forget(sending);
            return Err(error("send", code));
        }
        Ok((is_done == 0).then_some(sending))
    }

    /// A message, if one is there.
    pub(super) fn try_receive(&self, from: usize, tag: c_int) -> Result<Option<Vec<u8>>, MpiError> {
        let (mut is_there, mut n_bytes) = (0, 0);
        let from = from as c_int;
        // SAFETY: both are where an integer may be written.
        let code = unsafe {
            slabsplat_mpi_probe(self.own, from, tag, &raw mut is_there, &raw mut n_bytes)
        };
        check("look for messages", code)?;
        if is_there == 0 {
            return Ok(None);
        }
        let mut bytes = vec![0_u8; n_bytes as usize];
        let start = bytes.as_mut_ptr().cast();
        // SAFETY: there is room for as many bytes as the message has that was found, and nobody else takes
        // messages of this communicator, which is this value's alone.
        let code = unsafe { slabsplat_mpi_receive(self.own, start, n_bytes, from, tag) };
        check("receive", code)?;
        Ok(Some(bytes))
    }

    /// The name of this computer.
    pub(super) fn node(&self) -> String {
        text(|start, n_bytes, length| {
            // SAFETY: `text` gives room for so many bytes, and a place for a length.
            unsafe { slabsplat_mpi_node(start, n_bytes, length) }
        })
    }

    /// Ends all ranks, this one too.
    pub(super) fn abort(&self) {
        // SAFETY: any number may be given; it returns only if it failed.
        unsafe { slabsplat_mpi_abort(self.own) };
    }
}

impl Drop for Mpi {
    fn drop(&mut self) {
        // SAFETY: it is the communicator that `of` made, and nobody else has it.
        unsafe { slabsplat_mpi_free(self.own) };
        if self.is_ours {
            // SAFETY: we started it, and whoever could call it again has to start it first.
            unsafe { slabsplat_mpi_end() };
        }
    }
}

fn check(what: &'static str, code: c_int) -> Result<(), MpiError> {
    if code == 0 { Ok(()) } else { Err(error(what, code)) }
}

fn error(what: &'static str, code: c_int) -> MpiError {
    let cause = text(|start, n_bytes, length| {
        // SAFETY: `text` gives room for so many bytes, and a place for a length.
        unsafe { slabsplat_mpi_text(code, start, n_bytes, length) }
    });
    MpiError::Library { what, cause }
}

/// What a function writes into a buffer.
fn text(write: impl FnOnce(*mut c_char, c_int, *mut c_int) -> c_int) -> String {
    let (mut buffer, mut length) = ([0_u8; 512], 0);
    let code = write(buffer.as_mut_ptr().cast(), buffer.len() as c_int, &raw mut length);
    let length = if code == 0 { (length.max(0) as usize).min(buffer.len()) } else { 0 };
    String::from_utf8_lossy(&buffer[..length]).into_owned()
}
