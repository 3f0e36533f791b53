//! Bytes on their way from the pool to the calling thread, and a signal that the work has ended.

use std::io::{self, Write};
use std::mem;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use rtcli_tracer::memory::reserve;

/// Writers block while this many bytes are waiting, so that memory stays bounded when the target is slow.
const FULL: usize = 8 << 20;

/// The number of waiting bytes that wakes the calling thread.
const WORTH_TAKING: usize = 1 << 20;

#[derive(Default)]
struct State {
    bytes: Vec<u8>,
    ended: bool,
    closed: bool,
}

/// Passes bytes from the pool to the calling thread.
#[derive(Default)]
pub struct ByteChannel {
    state: Mutex<State>,
    changed: Condvar,
}

impl ByteChannel {
    /// Wait until enough bytes are there or the work has ended, at most for `at_most`; return the bytes written
    /// since the last call, and whether the work has ended.
    pub fn wait(&self, at_most: Duration) -> (Vec<u8>, bool) {
        let nothing = |state: &mut State| !state.ended && state.bytes.len() < WORTH_TAKING;
        let waited = self.changed.wait_timeout_while(self.lock(), at_most, nothing);
        let mut state = waited.unwrap_or_else(PoisonError::into_inner).0;
        self.changed.notify_all();
        (mem::take(&mut state.bytes), state.ended)
    }

    /// Reject further bytes, and wait until the work has ended.
    pub fn close(&self) {
        let mut state = self.lock();
        state.closed = true;
        self.changed.notify_all();
        drop(self.changed.wait_while(state, |state| !state.ended));
    }

    /// Signal that the work has ended.
    pub fn end(&self) {
        self.lock().ended = true;
        self.changed.notify_all();
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        // A panic while the lock is held leaves the state consistent.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Write for &ByteChannel {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let full = |state: &mut State| state.bytes.len() >= FULL && !state.closed;
        let waited = self.changed.wait_while(self.lock(), full);
        let mut state = waited.unwrap_or_else(PoisonError::into_inner);
        if state.closed {
            return Err(io::ErrorKind::BrokenPipe.into());
        }
        reserve(&mut state.bytes, bytes.len(), "the file")?;
        state.bytes.extend_from_slice(bytes);
        if state.bytes.len() >= WORTH_TAKING {
            self.changed.notify_all();
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
