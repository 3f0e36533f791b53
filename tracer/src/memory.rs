//! Fallible allocation of everything that grows with a scene or a picture.
//!
//! If the operating system limits a process (`ulimit -v`, a control group), an allocation may fail. Rust's
//! collections then abort the process; the functions of this module return [`OutOfMemory`]. Small and fixed
//! amounts are not checked one by one: [`spare`] checks that there is room for them, before and after the large
//! ones.

use rayon::prelude::*;
use std::error::Error;
use std::fmt;
use std::io;

/// More than the small allocations of a rendering take together.
const SPARE: usize = 4 << 20;

/// There is not enough memory for something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OutOfMemory {
    what: &'static str,
}

impl fmt::Display for OutOfMemory {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "not enough memory for {}", self.what)
    }
}

impl Error for OutOfMemory {}

impl From<OutOfMemory> for io::Error {
    fn from(_: OutOfMemory) -> io::Error {
        // No message: it would be another allocation.
        io::ErrorKind::OutOfMemory.into()
    }
}

/// Make room in a list for more items.
///
/// # Errors
///
/// If there is none.
pub fn reserve<T>(list: &mut Vec<T>, more: usize, what: &'static str) -> Result<(), OutOfMemory> {
    list.try_reserve(more).map_err(|_| OutOfMemory { what })
}

/// Return an empty list with room for a number of items.
///
/// # Errors
///
/// If there is none.
pub fn with_capacity<T>(count: usize, what: &'static str) -> Result<Vec<T>, OutOfMemory> {
    let mut list = Vec::new();
    list.try_reserve_exact(count).map_err(|_| OutOfMemory { what })?;
    Ok(list)
}

/// Return a list of the items of an iterator, which must not exceed its upper size hint.
///
/// # Errors
///
/// If there is no room for them.
pub fn collect<T>(items: impl Iterator<Item = T>, what: &'static str) -> Result<Vec<T>, OutOfMemory> {
    let (least, most) = items.size_hint();
    let mut list = with_capacity(most.unwrap_or(least), what)?;
    list.extend(items);
    Ok(list)
}

/// Return a list of the items of an iterator, which the threads of the current rayon pool compute.
///
/// # Errors
///
/// If there is no room for them.
pub(crate) fn par_collect<T: Send>(
    items: impl IndexedParallelIterator<Item = T>,
    what: &'static str,
) -> Result<Vec<T>, OutOfMemory> {
    let mut list = with_capacity(items.len(), what)?;
    items.collect_into_vec(&mut list);
    Ok(list)
}

/// Return a list of equal items.
///
/// # Errors
///
/// If there is no room for them.
pub fn filled<T: Clone>(count: usize, item: T, what: &'static str) -> Result<Vec<T>, OutOfMemory> {
    let mut list = Vec::new();
    resize(&mut list, count, item, what)?;
    Ok(list)
}

/// Resize a list, filling up with equal items.
///
/// # Errors
///
/// If there is no room for them.
pub fn resize<T: Clone>(list: &mut Vec<T>, count: usize, item: T, what: &'static str) -> Result<(), OutOfMemory> {
    let more = count.saturating_sub(list.len());
    list.try_reserve_exact(more).map_err(|_| OutOfMemory { what })?;
    list.resize(count, item);
    Ok(())
}

/// Check that there is room for small allocations, whose failure would end the process.
///
/// # Errors
///
/// If there is not.
pub fn spare() -> Result<(), OutOfMemory> {
    // Freed at once: untouched memory costs almost nothing.
    with_capacity::<u8>(SPARE, "the work").map(drop)
}

/// A file in memory whose writes fail when memory runs out.
#[derive(Debug, Default)]
pub struct Growing(pub Vec<u8>);

impl io::Write for Growing {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        reserve(&mut self.0, bytes.len(), "a file")?;
        self.0.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    /// More than there is room for in any address space.
    const ENDLESS: usize = usize::MAX / 16;

    #[test]
    fn what_there_is_no_room_for_is_refused_by_its_name() {
        let refused = with_capacity::<f64>(ENDLESS, "the objects").unwrap_err();
        assert_eq!(refused.to_string(), "not enough memory for the objects");
        assert_eq!(filled(ENDLESS, 1_u8, "it").unwrap_err().to_string(), "not enough memory for it");
        // The compiler removes an allocation that nothing uses, and takes it for granted.
        assert!(reserve(std::hint::black_box(&mut vec![1]), ENDLESS, "it").is_err());
        assert!(collect(std::iter::repeat_n(1_u64, ENDLESS), "it").is_err());
    }

    #[test]
    fn what_there_is_room_for_is_as_it_was_asked_for() {
        assert_eq!(collect((0..5).filter(|i| i % 2 == 0), "them").unwrap(), [0, 2, 4]);
        assert_eq!(filled(3, 'a', "them").unwrap(), ['a'; 3]);
        let mut list = Vec::new();
        reserve(&mut list, 100, "it").unwrap();
        assert!(list.capacity() >= 100);
        list.extend(0..100);
        resize(&mut list, 3, 0, "it").unwrap();
        assert_eq!(list, [0, 1, 2]);
        spare().unwrap();
    }

    #[test]
    fn a_file_in_memory_holds_what_is_written() {
        let mut file = Growing::default();
        file.write_all(b"abc").unwrap();
        file.write_all(b"de").unwrap();
        assert_eq!(file.0, b"abcde");
        assert_eq!(io::Error::from(OutOfMemory { what: "it" }).kind(), io::ErrorKind::OutOfMemory);
    }
}
