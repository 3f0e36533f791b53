//! fdeflate's codes for the Paeth filter: little time.
//!
//! fdeflate's codes are fixed, and refer to nothing but the byte before. So the codes of all segments one after the
//! other are those of the whole picture encoded at once, and the stream does not depend on how it was divided.

use std::io;

use crate::memory::{filled, with_capacity};
use crate::output::png::zlib::{Codec, ROWS, Rows, Segment};
use crate::simd::{Kernel, Level};

/// Bytes of rows that one thread encodes at a time.
const SEGMENT: usize = 1 << 16;

/// Bytes that are filtered together.
const VECTOR: usize = 64;

/// The type of the Paeth filter.
const PAETH: u8 = 4;

/// The bits of a zlib stream of fdeflate's before its codes: the header of the stream, and that of its only block.
const HEADER_BITS: usize = 8 * 53 + 5;

/// fdeflate's code for the end of a block, and its bits.
const END_OF_BLOCK: (u16, usize) = (0b1000_1111_1111, 12);

/// The bits of fdeflate's longest code.
const LONGEST_CODE: usize = 12;

pub const CODEC: Codec = Codec { segment: SEGMENT, is_seamless: true, encode, end: END_OF_BLOCK };

fn encode(rows: Rows<'_>) -> io::Result<Segment> {
    let bytes_per_pixel = rows.bytes_per_pixel;
    let length = rows.filtered_bytes();
    let mut filtered = filled(rows.above.len(), 0, ROWS)?;
    // All there is room for: the compressor panics where its sink fails at the end.
    let stream = with_capacity(LONGEST_CODE * length / 8 + 2 * HEADER_BITS, ROWS)?;
    let mut compressor = fdeflate::Compressor::new(stream)?;
    let level = Level::best();
    for (row, above) in rows.pairs() {
        level.run(PaethFilter { row, above, bytes_per_pixel, filtered: &mut filtered });
        compressor.write_data(&[PAETH])?;
        compressor.write_data(&filtered)?;
    }
    let stream = compressor.finish()?;
    let (block, checksum) = stream.split_last_chunk().expect("a checksum");
    // The block ends by the code of its end, whose last bit is 1, and zeros up to a whole byte.
    let last = block.last().expect("the end of the block");
    let end = 8 * block.len() - last.leading_zeros() as usize - END_OF_BLOCK.1;
    Ok(Segment { codes: HEADER_BITS..end, checksum: u32::from_be_bytes(*checksum), length, stream })
}

/// Subtracts from each byte of a row the one to the left, above, or above left that predicts it best (PNG
/// specification, section 9.4).
struct PaethFilter<'a> {
    row: &'a [u8],
    above: &'a [u8],
    bytes_per_pixel: usize,
    filtered: &'a mut [u8],
}

impl Kernel for PaethFilter<'_> {
    #[inline(always)]
    fn run(self) {
        let PaethFilter { row, above, bytes_per_pixel, filtered } = self;
        let (first, filtered) = filtered.split_at_mut(bytes_per_pixel);
        for ((filtered, x), b) in first.iter_mut().zip(row).zip(above) {
            *filtered = x.wrapping_sub(*b);
        }
        let count = filtered.len();
        // Arrays of known length: a loop over slices would not vectorize.
        let [(x, x_rest), (a, a_rest), (b, b_rest), (c, c_rest)] =
            [&row[bytes_per_pixel..], &row[..count], &above[bytes_per_pixel..], &above[..count]]
                .map(<[u8]>::as_chunks::<VECTOR>);
        let (filtered, rest) = filtered.as_chunks_mut::<VECTOR>();
        for ((((filtered, x), a), b), c) in filtered.iter_mut().zip(x).zip(a).zip(b).zip(c) {
            for i in 0..VECTOR {
                filtered[i] = x[i].wrapping_sub(predicted(a[i], b[i], c[i]));
            }
        }
        for ((((filtered, x), a), b), c) in rest.iter_mut().zip(x_rest).zip(a_rest).zip(b_rest).zip(c_rest) {
            *filtered = x.wrapping_sub(predicted(*a, *b, *c));
        }
    }
}

/// The one of the bytes to the left, above, and above left that is nearest to p = a + b - c.
#[inline(always)]
fn predicted(a: u8, b: u8, c: u8) -> u8 {
    // |p - a|, |p - b| and |p - c|, the last only where c is between a and b: elsewhere it is the largest. So all fits
    // into bytes.
    let (pa, pb) = (b.abs_diff(c), a.abs_diff(c));
    let pc = if (a < c) == (c < b) { pa.abs_diff(pb) } else { u8::MAX };
    let nearest = if pb < pa { b } else { a };
    if pc < pa.min(pb) { c } else { nearest }
}
