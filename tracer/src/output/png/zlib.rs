//! A zlib stream (RFC 1950) that is joined from parts, which threads encode on their own.

use std::io;
use std::ops::Range;

use crate::memory::reserve;

/// Named in the error if memory for codes runs out.
const CODES: &str = "the encoded picture";

/// Named in the error if memory for rows runs out.
pub const ROWS: &str = "rows of the picture";

/// The modulus of Adler-32.
const ADLER: u32 = 65_521;

/// Rows to encode.
#[derive(Clone, Copy)]
pub struct Rows<'a> {
    pub rows: &'a [u8],
    /// The row above the first one: zeros above a picture.
    pub above: &'a [u8],
    pub bytes_per_pixel: usize,
}

impl<'a> Rows<'a> {
    /// The bytes of the rows, and a filter type for each.
    pub fn filtered_bytes(&self) -> usize {
        self.rows.len() + self.rows.len() / self.above.len()
    }

    /// Each row, and the one above it.
    pub fn pairs(&self) -> impl Iterator<Item = (&'a [u8], &'a [u8])> + use<'a> {
        let row_bytes = self.above.len();
        let above = [self.above].into_iter().chain(self.rows.chunks_exact(row_bytes));
        self.rows.chunks_exact(row_bytes).zip(above)
    }
}

/// A way to encode rows.
pub struct Codec {
    /// Bytes of rows that one thread encodes at a time.
    pub segment: usize,
    /// Whether the stream is the same however its rows are divided into segments.
    pub is_seamless: bool,
    /// Encodes the rows of a segment.
    pub encode: fn(Rows<'_>) -> io::Result<Segment>,
    /// The bits after the last segment, and their number.
    pub end: (u16, usize),
}

/// Rows encoded as a zlib stream of their own.
pub struct Segment {
    pub stream: Vec<u8>,
    /// The codes, as a range of bits of the stream: after its header, before the end of its last block.
    pub codes: Range<usize>,
    /// The Adler-32 checksum of the filtered rows.
    pub checksum: u32,
    /// The bytes of the filtered rows.
    pub length: usize,
}

/// The zlib stream of all rows: the codes of many segments one after the other.
#[derive(Debug)]
pub struct ZlibStream {
    begun: bool,
    /// Bytes that are not written yet.
    pub waiting: Vec<u8>,
    /// Fewer than 8 bits after them, from the lowest.
    bits: u8,
    count: usize,
    /// The Adler-32 checksum of all rows: its halves a and b.
    checksum: (u32, u32),
}

impl Default for ZlibStream {
    fn default() -> ZlibStream {
        ZlibStream { begun: false, waiting: Vec::new(), bits: 0, count: 0, checksum: (1, 0) }
    }
}

impl ZlibStream {
    /// Append the codes of a segment; of the first one the header too.
    pub fn append(&mut self, segment: &Segment) -> io::Result<()> {
        let (codes, checksum) = (segment.codes.clone(), segment.checksum);
        self.append_bits(&segment.stream, if self.begun { codes } else { 0..codes.end })?;
        self.begun = true;
        // M. Adler's checksum of two strings: a = a_1 + a_2 - 1, b = b_1 + b_2 + (a_1 - 1) length_2
        let (a, b) = (checksum & 0xffff, checksum >> 16);
        let length = (segment.length % ADLER as usize) as u32;
        let (a_1, b_1) = self.checksum;
        let b = u64::from(b_1 + b) + u64::from(a_1 + ADLER - 1) * u64::from(length);
        self.checksum = ((a_1 + a + ADLER - 1) % ADLER, (b % u64::from(ADLER)) as u32);
        Ok(())
    }

    /// End the stream by some bits and the checksum.
    pub fn end(&mut self, (code, length): (u16, usize)) -> io::Result<()> {
        self.append_bits(&code.to_le_bytes(), 0..length)?;
        if self.count > 0 {
            self.waiting.push(self.bits);
        }
        let (a, b) = self.checksum;
        self.waiting.extend((b << 16 | a).to_be_bytes());
        Ok(())
    }

    /// Append some bits of a list of bytes, which count from the lowest of each byte.
    fn append_bits(&mut self, bytes: &[u8], bits: Range<usize>) -> io::Result<()> {
        const WORD: usize = size_of::<u64>();
        reserve(&mut self.waiting, bits.len() / 8 + 2 * WORD, CODES)?;
        let mut left = bits.len();
        let (words, rest) = bytes[bits.start / 8..].as_chunks::<WORD>();
        let mut tail = [0; WORD];
        tail[..rest.len()].copy_from_slice(rest);
        let mut skipped = bits.start % 8;
        for word in words.iter().chain([&tail]) {
            let taken = (8 * WORD - skipped).min(left);
            let word = u128::from(u64::from_le_bytes(*word) >> skipped) & ((1 << taken) - 1);
            let word = word << self.count | u128::from(self.bits);
            self.count += taken;
            let whole = self.count / 8;
            self.waiting.extend_from_slice(&word.to_le_bytes()[..whole]);
            self.bits = (word >> (8 * whole)) as u8;
            self.count %= 8;
            left -= taken;
            skipped = 0;
            if left == 0 {
                break;
            }
        }
        Ok(())
    }
}
