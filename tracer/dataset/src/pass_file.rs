//! A pass as a file: levels of a PNG, or NumPy's format.

use rtcli_plain::decode_json;
use rtcli_tracer::develop::BitDepth;
use rtcli_tracer::memory::{OutOfMemory, reserve, with_capacity};
use rtcli_tracer::pass_picture::pass_picture;
use rtcli_tracer::png::{self, Color, Compression, Header};
use rtcli_tracer::{Pass, Stopped};

use crate::picture::{PassValues, Picture};

/// The bytes that a header of NumPy's format, with what stands before it, is a multiple of; and the room that it leaves
/// for the first length of an array to grow: `numpy.lib.format` 1.0.
const ALIGNMENT: usize = 64;
const GROWTH: usize = 21;

/// Named in the error if memory runs out.
const FILE: &str = "a file";

/// Returns the end of the name and the bytes of the file of a pass that stands in an archive or a table: a 16-bit PNG of
/// ids that fit it, else NumPy's format.
pub fn array_file(picture: &Picture<'_>, pass: Pass) -> Result<(&'static str, Vec<u8>), Stopped> {
    let (width, height) = picture.size();
    match picture.pass(pass) {
        Some(PassValues::Ids(ids)) if ids.iter().all(|&id| id <= u32::from(u16::MAX)) => {
            let header = Header { width, height, color: Color::Grey, bits: BitDepth::Sixteen, texts: &[] };
            let mut levels = with_capacity(2 * ids.len(), FILE)?;
            levels.extend(ids.iter().flat_map(|&id| (id as u16).to_be_bytes()));
            Ok((".png", png::encode(header, &levels, Compression::Fast)?))
        }
        values => {
            let shape = shape(picture, pass);
            let mut file = npy_header(type_of(pass), &shape);
            reserve(&mut file, 4 * shape.iter().product::<usize>(), FILE)?;
            extend_with(&mut file, values);
            Ok((".npy", file))
        }
    }
}

/// Returns a pass of floats as a PNG of levels, as `rtcli.image.write` makes it, and how to get its values from them, in
/// JSON; None of ids.
pub fn level_file(picture: &mut Picture<'_>, pass: Pass) -> Result<Option<(Vec<u8>, String)>, Stopped> {
    let mut texts = picture.texts()?.to_vec();
    let Some(PassValues::Floats(values)) = picture.pass(pass) else { return Ok(None) };
    let Some(levels) = pass_picture(pass, values, None)? else { return Ok(None) };
    let decode = decode_json(&levels.decode);
    if let Some((_, metadata)) = texts.last_mut() {
        metadata.truncate(metadata.len() - 1);
        metadata.push_str(&format!(r#","pass":{{"name":"{}",{}}}"#, pass.name(), &decode[1..]));
    }
    let (width, height) = picture.size();
    let color = if pass.channels() == 1 { Color::Grey } else { Color::Triple };
    let header = Header { width, height, color, bits: levels.bits, texts: &texts };
    Ok(Some((png::encode(header, &levels.levels, Compression::Fast)?, decode)))
}

/// Returns the lengths of the array of a pass.
pub fn shape(picture: &Picture<'_>, pass: Pass) -> Vec<usize> {
    let (width, height) = picture.size();
    let mut shape = vec![height as usize, width as usize];
    shape.extend((pass.channels() > 1).then(|| pass.channels()));
    shape
}

/// Returns NumPy's name of the type of the values of a pass, the low byte first.
pub fn type_of(pass: Pass) -> &'static str {
    match pass.value_type() {
        rtcli_tracer::ValueType::Float => "<f4",
        rtcli_tracer::ValueType::Integer => "<u4",
    }
}

/// Returns the values of a pass, the low byte first.
pub fn bytes_of(values: Option<&PassValues>) -> Result<Vec<u8>, OutOfMemory> {
    let count = match values {
        Some(PassValues::Floats(values)) => values.len(),
        Some(PassValues::Ids(values)) => values.len(),
        None => 0,
    };
    let mut bytes = with_capacity(4 * count, FILE)?;
    extend_with(&mut bytes, values);
    Ok(bytes)
}

fn extend_with(bytes: &mut Vec<u8>, values: Option<&PassValues>) {
    match values {
        Some(PassValues::Floats(values)) => bytes.extend(values.iter().flat_map(|value| value.to_le_bytes())),
        Some(PassValues::Ids(values)) => bytes.extend(values.iter().flat_map(|value| value.to_le_bytes())),
        None => (),
    }
}

/// Returns what stands before the values of an array, as `numpy.save` writes it.
fn npy_header(type_name: &str, shape: &[usize]) -> Vec<u8> {
    let lengths: Vec<_> = shape.iter().map(usize::to_string).collect();
    let mut header =
        format!("{{'descr': '{type_name}', 'fortran_order': False, 'shape': ({}), }}", lengths.join(", "));
    header.extend(std::iter::repeat_n(' ', GROWTH.saturating_sub(lengths[0].len())));
    let mut file = b"\x93NUMPY\x01\x00".to_vec();
    let before = file.len() + 2;
    let padding = ALIGNMENT - (before + header.len() + 1) % ALIGNMENT;
    header.extend(std::iter::repeat_n(' ', padding));
    header.push('\n');
    file.extend((header.len() as u16).to_le_bytes());
    file.extend(header.as_bytes());
    file
}

#[cfg(test)]
mod tests {
    use super::npy_header;

    /// By NumPy 2.
    #[test]
    fn headers_of_arrays_are_those_of_numpy() {
        let header = npy_header("<f4", &[32, 48, 3]);
        assert_eq!(header.len(), 128);
        assert_eq!(&header[..10], b"\x93NUMPY\x01\x00\x76\x00");
        let text = str::from_utf8(&header[10..]).unwrap();
        assert!(text.starts_with("{'descr': '<f4', 'fortran_order': False, 'shape': (32, 48, 3), }  "), "{text}");
        assert!(text.ends_with(" \n"));
    }
}
