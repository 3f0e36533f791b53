//! Codes of zlib's kind, which refer to whatever came before in their segment: few bytes.
//!
//! The segments are the same for any number of threads, and the compressor computes with whole numbers alone.

use std::io;

use miniz_oxide::deflate::core::{
    CompressorOxide, TDEFLFlush, TDEFLStatus, compress_to_output, create_comp_flags_from_zip_params,
};

use crate::memory::{Growing, spare, with_capacity};
use crate::output::png::zlib::{Codec, ROWS, Rows, Segment};

/// Bytes of rows that one thread encodes at a time. The bytes of a file depend on it.
const SEGMENT: usize = 1 << 18;

/// The levels of compression that a segment is encoded with, and that its filter is chosen by.
const LEVEL: u8 = 6;
const TRIAL_LEVEL: u8 = 1;

/// The bits of the header of a zlib stream.
const HEADER_BITS: usize = 16;

/// A last block, of fixed codes: its header, and the code of its end.
const EMPTY_BLOCK: (u16, usize) = (0b011, 10);

pub const CODEC: Codec = Codec { segment: SEGMENT, is_seamless: false, encode, end: EMPTY_BLOCK };

/// What is subtracted from each byte of a row (PNG specification, section 9.2).
#[derive(Clone, Copy)]
enum Filter {
    /// Nothing.
    None = 0,
    /// The byte to the left.
    Sub = 1,
    /// The byte above.
    Up = 2,
}

const FILTERS: [Filter; 3] = [Filter::None, Filter::Sub, Filter::Up];

impl Filter {
    /// Returns the rows, each after the type of the filter.
    fn filtered(self, rows: Rows<'_>) -> io::Result<Vec<u8>> {
        let mut filtered = with_capacity(rows.filtered_bytes(), ROWS)?;
        for (row, above) in rows.pairs() {
            filtered.push(self as u8);
            match self {
                Filter::None => filtered.extend_from_slice(row),
                Filter::Sub => {
                    let (first, rest) = row.split_at(rows.bytes_per_pixel);
                    filtered.extend_from_slice(first);
                    filtered.extend(rest.iter().zip(row).map(|(x, a)| x.wrapping_sub(*a)));
                }
                Filter::Up => filtered.extend(row.iter().zip(above).map(|(x, b)| x.wrapping_sub(*b))),
            }
        }
        Ok(filtered)
    }
}

/// Encodes rows with one filter: the one with which a quicker compression makes the fewest bytes.
///
/// Choosing one for each row by the sum of its absolute values, as is usual, or by other measures makes larger files:
/// a pattern that comes back must look the same.
fn encode(rows: Rows<'_>) -> io::Result<Segment> {
    spare()?;
    let mut trial = compressor(TRIAL_LEVEL);
    let mut best = (usize::MAX, Vec::new());
    for filter in FILTERS {
        let filtered = filter.filtered(rows)?;
        let mut size = 0;
        trial.reset();
        deflate(&mut trial, &filtered, |codes| {
            size += codes.len();
            true
        })?;
        if size < best.0 {
            best = (size, filtered);
        }
    }
    let (size, filtered) = best;
    let mut compressor = compressor(LEVEL);
    let mut stream = Growing(with_capacity(size, ROWS)?);
    deflate(&mut compressor, &filtered, |codes| io::Write::write_all(&mut stream, codes).is_ok())?;
    let Growing(stream) = stream;
    let codes = HEADER_BITS..8 * stream.len();
    Ok(Segment { codes, checksum: compressor.adler32(), length: filtered.len(), stream })
}

fn compressor(level: u8) -> CompressorOxide {
    CompressorOxide::new(create_comp_flags_from_zip_params(level.into(), 15, 0))
}

/// Passes on a zlib stream without an end, in whole bytes.
fn deflate(compressor: &mut CompressorOxide, bytes: &[u8], sink: impl FnMut(&[u8]) -> bool) -> io::Result<()> {
    match compress_to_output(compressor, bytes, TDEFLFlush::Sync, sink) {
        (TDEFLStatus::Okay, _) => Ok(()),
        _ => Err(io::ErrorKind::OutOfMemory.into()),
    }
}
