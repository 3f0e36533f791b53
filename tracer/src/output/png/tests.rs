//! Written files against their pixels, the crate `png`, and disks that are too small.

use super::*;
use proptest::prelude::*;

const COMPRESSIONS: [Compression; 2] = [Compression::Fast, Compression::Small];

fn srgb(width: u32, height: u32, bits: BitDepth) -> Header<'static> {
    Header { width, height, color: Color::Srgb, bits, texts: &[] }
}

fn encoded(width: u32, height: u32, bits: BitDepth, pixels: &[u8]) -> Vec<u8> {
    encode(srgb(width, height, bits), pixels, Compression::Fast).unwrap()
}

fn small(header: Header<'_>, pixels: &[u8]) -> Vec<u8> {
    encode(header, pixels, Compression::Small).unwrap()
}

fn decoded(file: &[u8]) -> (png::OutputInfo, Vec<u8>) {
    let mut reader = png::Decoder::new(io::Cursor::new(file)).read_info().unwrap();
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
    let header = srgb(300, 1000, BitDepth::Eight);
    let pixels = varied(300 * 3, 1000);
    for compression in COMPRESSIONS {
        for rows in [1, 7, 291, 292, 999] {
            let mut writer = PngWriter::new(Vec::new(), header, compression).unwrap();
            for band in pixels.chunks(300 * 3 * rows) {
                writer.write_rows(band).unwrap();
            }
            let expected = encode(header, &pixels, compression).unwrap();
            assert!(writer.finish().unwrap() == expected, "{compression:?}, {rows} rows");
        }
    }
}

#[test]
fn a_small_file_is_the_same_for_any_number_of_threads() {
    for (width, height, bits) in
        [(700, 900, BitDepth::Eight), (1, 1, BitDepth::Eight), (300, 700, BitDepth::Sixteen)]
    {
        let header = srgb(width, height, bits);
        let pixels = varied(width as usize * bits.bytes_per_pixel(), height as usize);
        let expected = small(header, &pixels);
        for threads in [1, 2, 3, 16] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let file = pool.install(|| small(header, &pixels));
            assert!(file == expected, "{width}x{height}, {threads} threads");
        }
    }
}

/// Its checksum was found on x86-64 Linux: another one tells that a machine makes other files.
#[test]
fn a_small_file_is_the_same_on_every_machine() {
    let file = small(srgb(300, 700, BitDepth::Sixteen), &varied(300 * 6, 700));
    assert_eq!((file.len(), crc32fast::hash(&file)), (7515, 845_957_401));
}

#[test]
fn a_small_file_has_the_filter_that_suits_its_rows() {
    let header = Header { width: 100, height: 100, color: Color::Grey, bits: BitDepth::Eight, texts: &[] };
    // The last step of SplitMix64 (G. Steele, D. Lea and C. Flood, 2014), by which no filter gains.
    let random = |i: usize| {
        let z = (i as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let z = (z ^ z >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        ((z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB) >> 56) as u8
    };
    let picture = |level: &dyn Fn(usize, usize) -> u8| -> Vec<u8> {
        (0..100 * 100).map(|i| level(i % 100, i / 100)).collect()
    };
    let unlike = picture(&|x, y| random(100 * y + x));
    let across = picture(&|x, y| random(y).wrapping_mul(x as u8));
    let down = picture(&|x, y| random(x).wrapping_mul(y as u8));
    for (pixels, filter) in [(unlike, 0), (across, 1), (down, 2)] {
        let file = small(header, &pixels);
        let data = file.windows(4).position(|name| name == b"IDAT").unwrap() + 4;
        let rows = miniz_oxide::inflate::decompress_to_vec_zlib(&file[data..]).unwrap();
        assert!(rows.chunks(101).all(|row| row[0] == filter), "{filter}");
    }
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
        settings.set_depth(if bits == BitDepth::Eight { png::BitDepth::Eight } else { png::BitDepth::Sixteen });
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
    let mut writer = PngWriter::new(Vec::new(), srgb(1000, 200, BitDepth::Sixteen), Compression::Fast).unwrap();
    for row in noise(6000 * 200).chunks(6000) {
        writer.write_rows(row).unwrap();
        assert!(writer.stream.waiting.len() < CHUNK && writer.stream.waiting.capacity() <= 4 * CHUNK);
        assert_eq!(writer.waiting.capacity(), 0);
    }
    assert!(writer.sink.len() > 1_000_000);
}

#[test]
fn rows_of_a_small_file_wait_for_some_segments() {
    let mut writer = PngWriter::new(Vec::new(), srgb(1000, 1000, BitDepth::Sixteen), Compression::Small).unwrap();
    for row in noise(6000 * 1000).chunks(6000) {
        writer.write_rows(row).unwrap();
        assert!(writer.waiting.len() <= 4 << 18 && writer.waiting.capacity() <= 4 << 19);
    }
    assert!(writer.sink.len() > CHUNK);
}

#[test]
fn the_widest_picture_can_be_written() {
    let pixels = noise(2 * 65_535 * 8);
    let header = Header { width: 65_535, height: 2, color: Color::SrgbAlpha, bits: BitDepth::Sixteen, texts: &[] };
    for compression in COMPRESSIONS {
        let (info, back) = decoded(&encode(header, &pixels, compression).unwrap());
        assert_eq!((info.width, info.height), (65_535, 2));
        assert!(back == pixels);
    }
}

#[test]
fn a_full_disk_is_an_error_wherever_it_happens() {
    let (header, pixels) = (srgb(30, 1000, BitDepth::Eight), noise(30 * 3 * 1000));
    for compression in COMPRESSIONS {
        let size = encode(header, &pixels, compression).unwrap().len();
        for room in (0..size).step_by(5003).chain(size - 100..size) {
            let written = PngWriter::new(Disk(room), header, compression).and_then(|mut writer| {
                writer.write_rows(&pixels)?;
                writer.finish()
            });
            let error = written.expect_err("the disk was too small");
            assert_eq!(error.kind(), io::ErrorKind::StorageFull, "{compression:?}, room for {room} bytes");
        }
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
    let mut writer = PngWriter::new(Unflushable, srgb(1, 1, BitDepth::Eight), Compression::Fast).unwrap();
    writer.write_rows(&[0; 3]).unwrap();
    assert!(writer.finish().is_err());
}

#[test]
fn missing_rows_are_an_error() {
    let mut writer = PngWriter::new(Vec::new(), srgb(4, 3, BitDepth::Eight), Compression::Fast).unwrap();
    writer.write_rows(&[0; 24]).unwrap();
    assert!(writer.finish().is_err());
}

#[test]
fn too_many_rows_or_parts_of_rows_are_an_error() {
    let mut writer = PngWriter::new(Vec::new(), srgb(4, 3, BitDepth::Eight), Compression::Fast).unwrap();
    assert!(writer.write_rows(&[0; 48]).is_err());
    assert!(writer.write_rows(&[0; 13]).is_err());
    writer.write_rows(&[0; 36]).unwrap();
    assert!(writer.write_rows(&[0; 12]).is_err());
    writer.finish().unwrap();
}

#[test]
fn a_picture_without_pixels_is_an_error() {
    assert!(PngWriter::new(Vec::new(), srgb(0, 1, BitDepth::Eight), Compression::Fast).is_err());
    assert!(PngWriter::new(Vec::new(), srgb(1, 0, BitDepth::Eight), Compression::Fast).is_err());
}

#[test]
fn a_writer_that_is_dropped_leaves_a_file_without_an_end() {
    let mut file = Vec::new();
    let mut writer = PngWriter::new(&mut file, srgb(4, 3, BitDepth::Eight), Compression::Fast).unwrap();
    writer.write_rows(&[7; 24]).unwrap();
    drop(writer);
    assert!(file.starts_with(b"\x89PNG"));
    assert!(!file.windows(4).any(|name| name == b"IEND"));
}

#[test]
fn a_writer_can_be_dropped_with_a_full_disk() {
    let mut writer = PngWriter::new(Disk(1000), srgb(1000, 30, BitDepth::Eight), Compression::Fast).unwrap();
    assert!(writer.write_rows(&noise(90_000)).is_err());
}

/// A picture, and the number of rows to write at a time.
#[derive(Clone, Debug)]
struct AnyPicture {
    color: Color,
    bits: BitDepth,
    size: (u32, u32),
    pixels: Vec<u8>,
    rows: usize,
}

impl AnyPicture {
    fn header(&self) -> Header<'static> {
        let (width, height) = self.size;
        Header { width, height, color: self.color, bits: self.bits, texts: &[] }
    }
}

fn any_picture() -> impl Strategy<Value = AnyPicture> {
    let color = prop::sample::select(vec![Color::Grey, Color::Triple, Color::Srgb, Color::SrgbAlpha]);
    let bits = prop::sample::select(vec![BitDepth::Eight, BitDepth::Sixteen]);
    (color, bits, 1u32..40, 1u32..20, 1usize..20).prop_flat_map(|(color, bits, width, height, rows)| {
        let bytes = (width * height) as usize * color.channels() * bits.bytes();
        prop::collection::vec(prop_oneof![Just(0), Just(255), any::<u8>()], bytes)
            .prop_map(move |pixels| AnyPicture { color, bits, size: (width, height), pixels, rows })
    })
}

proptest! {
    #[test]
    fn what_was_written_is_read_back(picture in any_picture()) {
        let row_bytes = picture.pixels.len() / picture.size.1 as usize;
        for compression in COMPRESSIONS {
            let mut writer = PngWriter::new(Vec::new(), picture.header(), compression).unwrap();
            for band in picture.pixels.chunks(row_bytes * picture.rows) {
                writer.write_rows(band).unwrap();
            }
            let (info, back) = decoded(&writer.finish().unwrap());
            prop_assert_eq!((info.width, info.height), picture.size);
            prop_assert_eq!(info.color_type.samples(), picture.color.channels());
            prop_assert_eq!(&back, &picture.pixels);
        }
    }

    #[test]
    fn a_small_file_is_no_larger_than_a_fast_one(picture in any_picture()) {
        let fast = encode(picture.header(), &picture.pixels, Compression::Fast).unwrap();
        prop_assert!(small(picture.header(), &picture.pixels).len() <= fast.len());
    }
}
