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
//! So Paeth it is for [`Compression::Fast`]: nearly the smallest file that fdeflate makes, in a little more time than
//! the quickest; larger IDAT chunks gain nothing.
//!
//! The tables are those of the crate `png`. Its files are written here bit for bit, in 0.66 to 0.76 of its time for
//! rows: segments of rows are filtered with the widest vectors, encoded by several threads, and joined at bits.
//!
//! [`Compression::Small`] takes a filter for each segment of 256 KiB, by trial: a rendered picture of 8 bits has long
//! runs and repeated patterns, which a filter for each row destroys. Times are multiples of those of `Fast`, measured
//! in turn; KB of the file; the mean share is that of the 17 scenes in bytes of `Fast`.
//!
//! | small, 8 bits, zlib level 6    | first     | still-life | city      | mean share |
//! |--------------------------------|-----------|------------|-----------|------------|
//! | no filter                      | 114       | 242        | 446       | 0.77       |
//! | adaptive by row, fewest runs   | 117       | 280        | 447       | 0.69       |
//! | **none, Sub or Up by segment** | 21x / 114 | 12x / 251  | 24x / 434 | 0.66       |
//! | the same, level 9              | 109       | 238        | 394       |            |
//!
//! | small, 16 bits, zlib level 6   | first      | still-life | city       |
//! |--------------------------------|------------|------------|------------|
//! | adaptive by row, fewest runs   | 1143       | 2259       | 3324       |
//! | **none, Sub or Up by segment** | 23x / 1035 | 36x / 1944 | 27x / 3043 |
//! | the same, level 9              | 1000       | 1871       | 2955       |
//!
//! Segments of 512 KiB or 1 MiB make no smaller files. Level 9 takes 1.4 to 2.8 times as long as level 6.

mod fast;
mod small;
#[cfg(test)]
mod tests;
mod zlib;

use std::io::{self, Write};
use std::mem;
use std::str::FromStr;
use std::time::{Duration, Instant};

use rayon::prelude::*;

use crate::memory::{Growing, filled, reserve};
use crate::names::UnknownName;
use crate::output::develop::BitDepth;

use zlib::{Codec, ROWS, Rows, Segment, ZlibStream};

pub use png::DecodingError;

/// The size of an IDAT chunk: encoded data goes to the sink in such pieces.
const CHUNK: usize = 1 << 15;

/// The bytes of a chunk without data: its length, name and checksum.
const EMPTY_CHUNK: usize = 12;

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

/// The compression of a file. Pixels are the same, and bytes depend neither on the machine nor on how many threads
/// there are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Compression {
    /// Quick to write.
    #[default]
    Fast,
    /// Fewer bytes, which take many times as long to write.
    Small,
}

impl Compression {
    const fn codec(self) -> Codec {
        match self {
            Compression::Fast => fast::CODEC,
            Compression::Small => small::CODEC,
        }
    }
}

impl FromStr for Compression {
    type Err = UnknownName;

    fn from_str(name: &str) -> Result<Compression, UnknownName> {
        match name {
            "fast" => Ok(Compression::Fast),
            "small" => Ok(Compression::Small),
            _ => Err(UnknownName),
        }
    }
}

/// Writes a picture of 8 or 16 bits a channel as a PNG.
///
/// It buffers a row and a chunk of encoded data, and for small files four segments of rows for each thread. An
/// incomplete file has no IEND chunk, so that no reader takes it for a complete one.
pub struct PngWriter<W: Write> {
    sink: W,
    codec: Codec,
    stream: ZlibStream,
    /// Rows that are not encoded yet.
    waiting: Vec<u8>,
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
    pub fn new(mut sink: W, header: Header<'_>, compression: Compression) -> io::Result<Self> {
        sink.write_all(&chunks_before_pixels(header)?)?;
        let bytes_per_pixel = header.color.channels() * header.bits.bytes();
        Ok(PngWriter {
            sink,
            codec: compression.codec(),
            stream: ZlibStream::default(),
            waiting: Vec::new(),
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
        let segment_bytes = row_bytes * (self.codec.segment / row_bytes).max(1);
        let threads = rayon::current_thread_index().map_or(1, |_| rayon::current_num_threads());
        let group_bytes = segment_bytes * 4 * threads;
        for group in rows.chunks(group_bytes) {
            self.rows_left -= (group.len() / row_bytes) as u32;
            if self.codec.is_seamless {
                self.encode(group, segment_bytes)?;
                continue;
            }
            let mut waiting = mem::take(&mut self.waiting);
            reserve(&mut waiting, group.len(), ROWS)?;
            waiting.extend_from_slice(group);
            let ready = match waiting.len() {
                all if self.rows_left == 0 => all,
                few if few < group_bytes => 0,
                many => many - many % segment_bytes,
            };
            self.encode(&waiting[..ready], segment_bytes)?;
            waiting.drain(..ready);
            self.waiting = waiting;
        }
        Ok(())
    }

    /// Encode the next rows in segments.
    fn encode(&mut self, rows: &[u8], segment_bytes: usize) -> io::Result<()> {
        let row_bytes = self.above.len();
        let above = |start: usize| if start == 0 { &self.above } else { &rows[start - row_bytes..start] };
        let encode = |(i, segment): (usize, &[u8])| {
            let start = Instant::now();
            let rows =
                Rows { rows: segment, above: above(i * segment_bytes), bytes_per_pixel: self.bytes_per_pixel };
            Ok(((self.codec.encode)(rows)?, start.elapsed()))
        };
        let segments: io::Result<Vec<(Segment, Duration)>> = if rayon::current_thread_index().is_some() {
            rows.par_chunks(segment_bytes).enumerate().map(encode).collect()
        } else {
            rows.chunks(segment_bytes).enumerate().map(encode).collect()
        };
        for (segment, encoding) in segments? {
            let start = Instant::now();
            self.stream.append(&segment)?;
            self.write_chunks(CHUNK)?;
            self.encoding += encoding + start.elapsed();
        }
        if let Some(last) = rows.len().checked_sub(row_bytes) {
            self.above.copy_from_slice(&rows[last..]);
        }
        Ok(())
    }

    /// Write waiting codes as IDAT chunks, while there are at least so many bytes.
    fn write_chunks(&mut self, least: usize) -> io::Result<()> {
        let mut rest = self.stream.waiting.as_slice();
        while rest.len() >= least {
            let data = rest.split_off(..CHUNK.min(rest.len())).unwrap_or_default();
            write_chunk(&mut self.sink, *b"IDAT", data)?;
        }
        let written = self.stream.waiting.len() - rest.len();
        self.stream.waiting.drain(..written);
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
        self.stream.end(self.codec.end)?;
        self.write_chunks(1)?;
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
pub fn encode(header: Header<'_>, pixels: &[u8], compression: Compression) -> io::Result<Vec<u8>> {
    let mut writer = PngWriter::new(Growing::default(), header, compression)?;
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
