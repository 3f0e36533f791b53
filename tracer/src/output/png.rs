//! PNG files, written row by row.
//!
//! The filter and the compression were chosen by measurement: milliseconds per megapixel / KB of the file, from
//! memory to memory, scenes of `scenes/` at 1920x1080, one thread on 2 cores of an AMD EPYC (Zen 5).
//!
//! | 8 bits                 | first     | still-life | city      |
//! |------------------------|-----------|------------|-----------|
//! | Sub, fdeflate          | 1.0 / 212 | 1.8 / 428  | 3.2 / 783 |
//! | Up, fdeflate           | 1.2 / 253 | 2.3 / 649  | 2.9 / 682 |
//! | Average, fdeflate      | 1.2 / 240 | 2.4 / 617  | 3.2 / 763 |
//! | **Paeth, fdeflate**    | 1.4 / 191 | 2.6 / 449  | 3.4 / 613 |
//! | adaptive, fdeflate     | 1.8 / 190 | 3.3 / 445  | 3.9 / 613 |
//! | Paeth, zlib level 1    | 2.1 / 225 | 4.4 / 523  | 6.4 / 701 |
//! | adaptive, zlib level 6 | 17 / 120  | 31 / 297   | 57 / 447  |
//! | Pillow 13, default     | 35 / 121  | 48 / 300   | 76 / 449  |
//!
//! | 16 bits                | first      | still-life | city        |
//! |------------------------|------------|------------|-------------|
//! | Sub, fdeflate          | 4.6 / 2563 | 6.7 / 5675 | 8.7 / 5424  |
//! | Up, fdeflate           | 4.9 / 3338 | 6.9 / 7150 | 8.0 / 5623  |
//! | **Paeth, fdeflate**    | 5.9 / 2316 | 8.3 / 5223 | 9.7 / 4790  |
//! | adaptive, fdeflate     | 6.7 / 2316 | 9.8 / 5207 | 10.7 / 4790 |
//! | Paeth, zlib level 1    | 15 / 1888  | 25 / 3576  | 24 / 4085   |
//! | adaptive, zlib level 6 | 116 / 1113 | 269 / 2245 | 218 / 3240  |
//!
//! So Paeth it is: nearly the smallest file that fdeflate makes, in a little more time than the quickest; larger IDAT
//! chunks gain nothing.
//!
//! The table is that of the crate `png`. Its files are written here bit for bit, in 0.66 to 0.76 of its time for rows:
//! segments of rows are filtered with the widest vectors, encoded by several threads, and joined at bits.

use std::io::{self, Write};
use std::ops::Range;
use std::time::{Duration, Instant};

use rayon::prelude::*;

use crate::memory::{Growing, filled, reserve, with_capacity};
use crate::output::develop::BitDepth;
use crate::simd::{Kernel, Level};

pub use png::DecodingError;

/// The size of an IDAT chunk: encoded data goes to the sink in such pieces.
const CHUNK: usize = 1 << 15;

/// Bytes of rows that one thread encodes at a time.
const SEGMENT: usize = 1 << 16;

/// The bytes of a chunk without data: its length, name and checksum.
const EMPTY_CHUNK: usize = 12;

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

/// The modulus of Adler-32.
const ADLER: u32 = 65_521;

/// Named in the error if memory runs out.
const ROWS: &str = "rows of the picture";

/// The data before the pixels.
#[derive(Clone, Copy, Debug)]
pub struct Header<'a> {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The meaning of the channels.
    pub color: Color,
    /// The depth of each channel.
    pub bits: BitDepth,
    /// Keywords in Latin-1 and their texts in ASCII.
    pub texts: &'a [(String, String)],
}

/// The meaning of the channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Color {
    /// One value that is no color.
    Grey,
    /// Three values that are no color.
    Triple,
    /// Red, green and blue: the file declares sRGB.
    Srgb,
    /// The same with alpha, by which the colors are not multiplied.
    SrgbAlpha,
}

impl Color {
    const fn channels(self) -> usize {
        match self {
            Color::Grey => 1,
            Color::Triple | Color::Srgb => 3,
            Color::SrgbAlpha => 4,
        }
    }
}

/// Writes a picture of 8 or 16 bits a channel as a PNG.
///
/// It buffers a row and a chunk of encoded data. An incomplete file has no IEND chunk, so that no reader takes it for
/// a complete one.
pub struct PngWriter<W: Write> {
    sink: W,
    stream: ZlibStream,
    /// The row above the next one.
    above: Vec<u8>,
    bytes_per_pixel: usize,
    rows_left: u32,
    encoding: Duration,
}

impl<W: Write> PngWriter<W> {
    /// Begin a picture by writing the data before its pixels.
    ///
    /// # Errors
    ///
    /// If the picture has no pixels, or the sink fails.
    pub fn new(mut sink: W, header: Header<'_>) -> io::Result<Self> {
        sink.write_all(&chunks_before_pixels(header)?)?;
        let bytes_per_pixel = header.color.channels() * header.bits.bytes();
        Ok(PngWriter {
            sink,
            stream: ZlibStream::default(),
            above: filled(header.width as usize * bytes_per_pixel, 0, ROWS)?,
            bytes_per_pixel,
            rows_left: header.height,
            encoding: Duration::ZERO,
        })
    }

    /// Write the next rows, from the top: interleaved channels, 8 bits or big-endian 16 bits. Within a rayon pool its
    /// threads encode them; the file is the same for any number of them.
    ///
    /// # Errors
    ///
    /// If these are not whole rows, or more than are missing, or the sink fails.
    pub fn write_rows(&mut self, rows: &[u8]) -> io::Result<()> {
        let row_bytes = self.above.len();
        let count = rows.len() / row_bytes;
        if !rows.len().is_multiple_of(row_bytes) || count > self.rows_left as usize {
            let left = self.rows_left;
            return Err(io::Error::new(
                io::ErrorKind::InvalidInput,
                format!("{} bytes are not at most {left} whole rows of {row_bytes} bytes", rows.len()),
            ));
        }
        let segment_bytes = row_bytes * (SEGMENT / row_bytes).max(1);
        let threads = rayon::current_thread_index().map_or(1, |_| rayon::current_num_threads());
        for group in rows.chunks(segment_bytes * 4 * threads) {
            let above = |start: usize| if start == 0 { &self.above } else { &group[start - row_bytes..start] };
            let encode =
                |(i, rows): (usize, &[u8])| Segment::encode(rows, above(i * segment_bytes), self.bytes_per_pixel);
            let segments: io::Result<Vec<Segment>> = if threads > 1 {
                group.par_chunks(segment_bytes).enumerate().map(encode).collect()
            } else {
                group.chunks(segment_bytes).enumerate().map(encode).collect()
            };
            for segment in segments? {
                let start = Instant::now();
                self.stream.append(&segment)?;
                self.stream.write_chunks(&mut self.sink, CHUNK)?;
                self.encoding += segment.encoding + start.elapsed();
            }
            self.above.copy_from_slice(&group[group.len() - row_bytes..]);
            self.rows_left -= (group.len() / row_bytes) as u32;
        }
        Ok(())
    }

    /// End the file and return the sink.
    ///
    /// # Errors
    ///
    /// If rows are missing, or the sink fails.
    pub fn finish(mut self) -> io::Result<W> {
        if self.rows_left > 0 {
            let message = format!("{} rows are missing", self.rows_left);
            return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
        }
        self.stream.end()?;
        self.stream.write_chunks(&mut self.sink, 1)?;
        write_chunk(&mut self.sink, *b"IEND", &[])?;
        self.sink.flush()?;
        Ok(self.sink)
    }

    /// Return the sink.
    pub fn sink(&mut self) -> &mut W {
        &mut self.sink
    }

    /// The time of all threads together for encoding and writing.
    pub fn encoding(&self) -> Duration {
        self.encoding
    }
}

/// Return a picture as the bytes of a PNG: interleaved channels, 8 bits or big-endian 16 bits.
///
/// # Errors
///
/// If these are not the rows of the picture, or memory runs out.
pub fn encode(header: Header<'_>, pixels: &[u8]) -> io::Result<Vec<u8>> {
    let mut writer = PngWriter::new(Growing::default(), header)?;
    writer.write_rows(pixels)?;
    Ok(writer.finish()?.0)
}

/// The signature and the chunks before the first IDAT chunk.
fn chunks_before_pixels(header: Header<'_>) -> io::Result<Vec<u8>> {
    let mut file = Vec::new();
    let mut settings = png::Encoder::new(&mut file, header.width, header.height);
    settings.set_color(match header.color {
        Color::Grey => png::ColorType::Grayscale,
        Color::Triple | Color::Srgb => png::ColorType::Rgb,
        Color::SrgbAlpha => png::ColorType::Rgba,
    });
    settings.set_depth(match header.bits {
        BitDepth::Eight => png::BitDepth::Eight,
        BitDepth::Sixteen => png::BitDepth::Sixteen,
    });
    if matches!(header.color, Color::Srgb | Color::SrgbAlpha) {
        settings.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    }
    for (keyword, text) in header.texts {
        settings.add_text_chunk(keyword.clone(), text.clone())?;
    }
    // Dropping the writer ends the file by an empty chunk, IEND.
    drop(settings.write_header()?);
    file.truncate(file.len() - EMPTY_CHUNK);
    Ok(file)
}

fn write_chunk(sink: &mut impl Write, name: [u8; 4], data: &[u8]) -> io::Result<()> {
    let mut checksum = crc32fast::Hasher::new();
    checksum.update(&name);
    checksum.update(data);
    sink.write_all(&(data.len() as u32).to_be_bytes())?;
    sink.write_all(&name)?;
    sink.write_all(data)?;
    sink.write_all(&checksum.finalize().to_be_bytes())
}

/// Rows encoded as a zlib stream of their own.
struct Segment {
    stream: Vec<u8>,
    /// The bytes of the rows, and a filter type for each.
    length: usize,
    encoding: Duration,
}

impl Segment {
    fn encode<'a>(rows: &'a [u8], mut above: &'a [u8], bytes_per_pixel: usize) -> io::Result<Segment> {
        let start = Instant::now();
        let row_bytes = above.len();
        let length = rows.len() / row_bytes * (row_bytes + 1);
        let mut filtered = filled(row_bytes, 0, ROWS)?;
        // All there is room for: the compressor panics where its sink fails at the end.
        let stream = with_capacity(LONGEST_CODE * length / 8 + 2 * HEADER_BITS, ROWS)?;
        let mut compressor = fdeflate::Compressor::new(stream)?;
        let level = Level::best();
        for row in rows.chunks_exact(row_bytes) {
            level.run(PaethFilter { row, above, bytes_per_pixel, filtered: &mut filtered });
            compressor.write_data(&[PAETH])?;
            compressor.write_data(&filtered)?;
            above = row;
        }
        Ok(Segment { stream: compressor.finish()?, length, encoding: start.elapsed() })
    }

    /// The codes, as a range of bits of the stream, and the checksum after them.
    ///
    /// The block ends by the code of its end, whose last bit is 1, and zeros up to a whole byte.
    fn codes(&self) -> (Range<usize>, u32) {
        let (block, checksum) = self.stream.split_last_chunk().expect("a checksum");
        let last = block.last().expect("the end of the block");
        let end = 8 * block.len() - last.leading_zeros() as usize - END_OF_BLOCK.1;
        (HEADER_BITS..end, u32::from_be_bytes(*checksum))
    }
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

/// A zlib stream of one block, from the codes of many segments.
///
/// The compressor's codes are fixed, and refer to nothing but the byte before. So the codes of all segments one after
/// the other are those of the whole picture encoded at once, and the stream does not depend on how it was divided.
#[derive(Debug)]
struct ZlibStream {
    begun: bool,
    /// Bytes that are not written yet.
    waiting: Vec<u8>,
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
    fn append(&mut self, segment: &Segment) -> io::Result<()> {
        let (codes, checksum) = segment.codes();
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

    fn end(&mut self) -> io::Result<()> {
        let (code, length) = END_OF_BLOCK;
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
        reserve(&mut self.waiting, bits.len() / 8 + 2 * WORD, ROWS)?;
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

    /// Write waiting bytes as IDAT chunks, while there are at least so many.
    fn write_chunks(&mut self, sink: &mut impl Write, least: usize) -> io::Result<()> {
        let mut rest = self.waiting.as_slice();
        while rest.len() >= least {
            let data = rest.split_off(..CHUNK.min(rest.len())).unwrap_or_default();
            write_chunk(sink, *b"IDAT", data)?;
        }
        let written = self.waiting.len() - rest.len();
        self.waiting.drain(..written);
        Ok(())
    }
}

/// The contents of a PNG.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Decoded {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// 1 to 4: grey, grey and alpha, RGB, RGB and alpha.
    pub channels: usize,
    /// The depth of each channel.
    pub bits: BitDepth,
    /// Interleaved channels row by row; 16 bits have the high byte first.
    pub pixels: Vec<u8>,
}

/// Read a PNG of any kind; palettes, small depths and transparent colors are expanded.
///
/// # Errors
///
/// If it is not a PNG, is broken, or its pixels take more than `most` bytes or more memory than there is.
pub fn decode(file: &[u8], most: usize) -> Result<Decoded, DecodingError> {
    let limits = png::Limits { bytes: most };
    let mut decoder = png::Decoder::new_with_limits(io::Cursor::new(file), limits);
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info()?;
    let size = reader.output_buffer_size().filter(|&size| size <= most);
    let size = size.ok_or(DecodingError::LimitsExceeded)?;
    let mut pixels = filled(size, 0, "the picture").map_err(io::Error::from)?;
    let info = reader.next_frame(&mut pixels)?;
    reader.finish()?;
    Ok(Decoded {
        width: info.width,
        height: info.height,
        channels: info.color_type.samples(),
        bits: if info.bit_depth == png::BitDepth::Sixteen { BitDepth::Sixteen } else { BitDepth::Eight },
        pixels,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn srgb(width: u32, height: u32, bits: BitDepth) -> Header<'static> {
        Header { width, height, color: Color::Srgb, bits, texts: &[] }
    }

    fn encoded(width: u32, height: u32, bits: BitDepth, pixels: &[u8]) -> Vec<u8> {
        let mut file = Vec::new();
        let mut writer = PngWriter::new(&mut file, srgb(width, height, bits)).unwrap();
        writer.write_rows(pixels).unwrap();
        writer.finish().unwrap();
        file
    }

    fn decoded(file: &[u8]) -> (png::OutputInfo, Vec<u8>) {
        let mut reader = png::Decoder::new(io::Cursor::new(file)).read_info().unwrap();
        assert_eq!(reader.info().srgb, Some(png::SrgbRenderingIntent::Perceptual));
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        reader.finish().unwrap();
        (info, pixels)
    }

    /// Bytes in which nothing repeats.
    fn noise(count: usize) -> Vec<u8> {
        (0..count as u64).map(|i| (i.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 56) as u8).collect()
    }

    /// A disk with room for a number of bytes.
    #[derive(Debug)]
    struct Disk(usize);

    impl Write for Disk {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let fits = bytes.len().min(self.0);
            self.0 -= fits;
            if fits == 0 { Err(io::ErrorKind::StorageFull.into()) } else { Ok(fits) }
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn the_file_says_that_it_is_srgb_and_nothing_else() {
        let mut file = &encoded(1, 1, BitDepth::Eight, &[1, 2, 3])[8..];
        let mut chunks = Vec::new();
        while let [a, b, c, d, rest @ ..] = file {
            chunks.push(String::from_utf8_lossy(&rest[..4]));
            file = &rest[u32::from_be_bytes([*a, *b, *c, *d]) as usize + 8..];
        }
        assert_eq!(chunks, ["IHDR", "sRGB", "IDAT", "IEND"]);
    }

    #[test]
    fn the_file_does_not_depend_on_the_bands_it_was_written_in() {
        let pixels = noise(300 * 3 * 100);
        let mut file = Vec::new();
        let mut writer = PngWriter::new(&mut file, srgb(300, 100, BitDepth::Eight)).unwrap();
        for band in pixels.chunks(300 * 3 * 7) {
            writer.write_rows(band).unwrap();
        }
        writer.finish().unwrap();
        assert!(file == encoded(300, 100, BitDepth::Eight, &pixels));
    }

    /// Rows of noise, of one color, and of a gradient.
    fn varied(row_bytes: usize, rows: usize) -> Vec<u8> {
        let noise = noise(row_bytes);
        let row = |y: usize| -> Vec<u8> {
            match y / 5 % 3 {
                0 => noise.clone(),
                1 => vec![y as u8; row_bytes],
                _ => (0..row_bytes).map(|x| ((x + y) / 7) as u8).collect(),
            }
        };
        (0..rows).flat_map(row).collect()
    }

    #[test]
    fn the_file_is_that_of_the_png_crate_on_any_number_of_threads() {
        for (width, height, bits) in
            [(700, 900, BitDepth::Eight), (300, 700, BitDepth::Sixteen), (5, 3, BitDepth::Eight)]
        {
            let pixels = varied(width as usize * bits.bytes_per_pixel(), height as usize);
            let mut expected = Vec::new();
            let mut settings = png::Encoder::new(&mut expected, width, height);
            settings.set_color(png::ColorType::Rgb);
            settings.set_depth(if bits == BitDepth::Eight {
                png::BitDepth::Eight
            } else {
                png::BitDepth::Sixteen
            });
            settings.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
            settings.set_deflate_compression(png::DeflateCompression::FdeflateUltraFast);
            settings.set_filter(png::Filter::Paeth);
            let mut writer = settings.write_header().unwrap();
            let mut stream = writer.stream_writer_with_size(CHUNK).unwrap();
            stream.write_all(&pixels).unwrap();
            stream.finish().unwrap();
            writer.finish().unwrap();
            for threads in [1, 2, 3] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                let file = pool.install(|| encoded(width, height, bits, &pixels));
                assert!(file == expected, "{width}x{height}, {threads} threads");
            }
            assert!(encoded(width, height, bits, &pixels) == expected, "{width}x{height}, no pool");
        }
    }

    #[test]
    fn encoded_rows_leave_for_the_sink_as_they_come() {
        let mut writer = PngWriter::new(Vec::new(), srgb(1000, 200, BitDepth::Sixteen)).unwrap();
        for row in noise(6000 * 200).chunks(6000) {
            writer.write_rows(row).unwrap();
            assert!(writer.stream.waiting.len() < CHUNK && writer.stream.waiting.capacity() <= 4 * CHUNK);
        }
        assert!(writer.sink.len() > 1_000_000);
    }

    #[test]
    fn the_widest_picture_can_be_written() {
        let pixels = noise(65_535 * 6);
        let (info, back) = decoded(&encoded(65_535, 1, BitDepth::Sixteen, &pixels));
        assert_eq!((info.width, info.height), (65_535, 1));
        assert!(back == pixels);
    }

    #[test]
    fn a_full_disk_is_an_error_wherever_it_happens() {
        let pixels = noise(30 * 3 * 1000);
        let size = encoded(30, 1000, BitDepth::Eight, &pixels).len();
        for room in (0..size).step_by(5003).chain(size - 100..size) {
            let written = PngWriter::new(Disk(room), srgb(30, 1000, BitDepth::Eight)).and_then(|mut writer| {
                writer.write_rows(&pixels)?;
                writer.finish()
            });
            let error = written.expect_err("the disk was too small");
            assert_eq!(error.kind(), io::ErrorKind::StorageFull, "room for {room} bytes");
        }
    }

    #[test]
    fn a_sink_that_cannot_flush_is_an_error() {
        struct Unflushable;
        impl Write for Unflushable {
            fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
                Ok(bytes.len())
            }
            fn flush(&mut self) -> io::Result<()> {
                Err(io::ErrorKind::StorageFull.into())
            }
        }
        let mut writer = PngWriter::new(Unflushable, srgb(1, 1, BitDepth::Eight)).unwrap();
        writer.write_rows(&[0; 3]).unwrap();
        assert!(writer.finish().is_err());
    }

    #[test]
    fn missing_rows_are_an_error() {
        let mut writer = PngWriter::new(Vec::new(), srgb(4, 3, BitDepth::Eight)).unwrap();
        writer.write_rows(&[0; 24]).unwrap();
        assert!(writer.finish().is_err());
    }

    #[test]
    fn too_many_rows_or_parts_of_rows_are_an_error() {
        let mut writer = PngWriter::new(Vec::new(), srgb(4, 3, BitDepth::Eight)).unwrap();
        assert!(writer.write_rows(&[0; 48]).is_err());
        assert!(writer.write_rows(&[0; 13]).is_err());
        writer.write_rows(&[0; 36]).unwrap();
        assert!(writer.write_rows(&[0; 12]).is_err());
        writer.finish().unwrap();
    }

    #[test]
    fn a_picture_without_pixels_is_an_error() {
        assert!(PngWriter::new(Vec::new(), srgb(0, 1, BitDepth::Eight)).is_err());
        assert!(PngWriter::new(Vec::new(), srgb(1, 0, BitDepth::Eight)).is_err());
    }

    #[test]
    fn a_writer_that_is_dropped_leaves_a_file_without_an_end() {
        let mut file = Vec::new();
        let mut writer = PngWriter::new(&mut file, srgb(4, 3, BitDepth::Eight)).unwrap();
        writer.write_rows(&[7; 24]).unwrap();
        drop(writer);
        assert!(file.starts_with(b"\x89PNG"));
        assert!(!file.windows(4).any(|name| name == b"IEND"));
    }

    #[test]
    fn a_writer_can_be_dropped_with_a_full_disk() {
        let mut writer = PngWriter::new(Disk(1000), srgb(1000, 30, BitDepth::Eight)).unwrap();
        assert!(writer.write_rows(&noise(90_000)).is_err());
    }

    proptest! {
        #[test]
        fn what_was_written_is_read_back(
            (width, height, bits, pixels) in
                (1u32..40, 1u32..20, any::<bool>()).prop_flat_map(|(width, height, deep)| {
                let bits = if deep { BitDepth::Sixteen } else { BitDepth::Eight };
                let bytes = (width * height) as usize * bits.bytes_per_pixel();
                let any_pixels = prop::collection::vec(prop_oneof![Just(0), Just(255), any::<u8>()], bytes);
                (Just(width), Just(height), Just(bits), any_pixels)
            })
        ) {
            let (info, back) = decoded(&encoded(width, height, bits, &pixels));
            prop_assert_eq!((info.width, info.height), (width, height));
            prop_assert_eq!(info.color_type, png::ColorType::Rgb);
            prop_assert_eq!(back, pixels);
        }
    }
}
