//! The files of a sample, and archives and arrays of them.

use rtcli_tracer::memory::{OutOfMemory, reserve};
use rtcli_tracer::{Pass, Stopped};

use crate::pass_file::{array_file, bytes_of, level_file, shape, type_of};
use crate::picture::Picture;

/// The level of compression, 0 to 10. Of 64 x 64 pixels of 3D Shapes, 12,288 bytes, level 1 makes 2,510 in 36 us, level 2
/// 2,007 in 56 us, and level 4 1,787 in 83 us.
const LEVEL: u8 = 2;

/// The size of a block of a tar file.
const BLOCK: usize = 512;

/// The names of the picture among parts and arrays.
const IMAGE: &str = "image";
const IMAGES: &str = "images";

/// The outputs of a sample beside its labels.
#[derive(Clone, Copy, Debug, Default)]
pub struct Outputs {
    /// Its files: the picture, passes as levels of PNGs, and labels that say how to read these.
    pub files: bool,
    /// Members of a tar file: labels, picture and passes.
    pub tar: bool,
    /// The files that stand in a table: picture and passes.
    pub parts: bool,
    /// The picture and passes as compressed arrays.
    pub arrays: bool,
    /// The picture as an array.
    pub levels: bool,
}

impl Outputs {
    /// Whether there is any.
    pub fn any(self) -> bool {
        self.files || self.tar || self.parts || self.arrays || self.levels
    }
}

/// The name of a file's contents, the end of its own name, and its bytes.
pub type Part = (&'static str, &'static str, Vec<u8>);

/// The name of an array, its lengths, NumPy's name of the type of its values, and their bytes.
pub type Array = (&'static str, Vec<usize>, &'static str, Vec<u8>);

/// The ends of the names of a sample's files, and their bytes.
pub type Files = Vec<(String, Vec<u8>)>;

/// Returns how the names of a sample's files start.
pub fn key_of(index: u64) -> String {
    format!("{index:08}")
}

/// Returns the files of a sample.
pub fn files(png: Vec<u8>, labels: &str, passes: &[Pass], picture: &mut Picture<'_>) -> Result<Files, Stopped> {
    let mut files = vec![(".png".to_owned(), png)];
    let mut decodes = Vec::new();
    for &pass in passes {
        let (suffix, file, decode) = match level_file(picture, pass)? {
            Some((file, decode)) => (".png", file, decode),
            // The colors that a film gives to ids are in its metadata, which a data set has not.
            None => {
                let (suffix, file) = array_file(picture, pass)?;
                (suffix, file, r#"{"value":"level","nothing":0}"#.to_owned())
            }
        };
        files.push((format!(".{}{suffix}", pass.name()), file));
        decodes.push(format!("\"{}\":{decode}", pass.name()));
    }
    let start = labels.strip_suffix('}').unwrap_or(labels);
    files.push((".json".to_owned(), format!("{start},\"passes\":{{{}}}}}\n", decodes.join(",")).into_bytes()));
    Ok(files)
}

/// Returns the files of a sample that stand in a table.
pub fn parts(png: Vec<u8>, passes: &[Pass], picture: &Picture<'_>) -> Result<Vec<Part>, Stopped> {
    let mut parts = vec![(IMAGE, ".png", png)];
    for &pass in passes {
        let (suffix, file) = array_file(picture, pass)?;
        parts.push((pass.name(), suffix, file));
    }
    Ok(parts)
}

/// Returns the members of a tar file, whose names start with a key, in order.
pub fn tar(key: &str, labels: &str, parts: &[Part]) -> Result<Vec<u8>, OutOfMemory> {
    let labels = format!("{labels}\n");
    let mut members = vec![(".json".to_owned(), labels.as_bytes())];
    for (name, suffix, file) in parts {
        let end = if *name == IMAGE { (*suffix).to_owned() } else { format!(".{name}{suffix}") };
        members.push((end, file));
    }
    members.sort_unstable();
    let mut archive = Vec::new();
    for (end, file) in members {
        reserve(&mut archive, file.len() + 2 * BLOCK, "a file")?;
        archive.extend(member_header(&format!("{key}{end}"), file.len()));
        archive.extend(file);
        archive.resize(archive.len().next_multiple_of(BLOCK), 0);
    }
    Ok(archive)
}

/// Returns the header of a member of a tar file in the format ustar (POSIX.1-1988), without a date and an owner.
fn member_header(name: &str, length: usize) -> [u8; BLOCK] {
    let mut header = [0; BLOCK];
    let mut put = |offset: usize, text: &str| header[offset..offset + text.len()].copy_from_slice(text.as_bytes());
    put(0, name);
    put(100, "0000644\0");
    put(108, "0000000\0");
    put(116, "0000000\0");
    put(124, &format!("{length:011o}\0"));
    put(136, "00000000000\0");
    put(148, "        ");
    put(156, "0");
    put(257, "ustar\x0000");
    let sum: u32 = header.iter().map(|&byte| u32::from(byte)).sum();
    header[148..156].copy_from_slice(format!("{sum:06o}\0 ").as_bytes());
    header
}

/// Returns the picture and passes as arrays, each compressed to a stream of zlib (RFC 1950): the same bytes on every
/// machine, which Python's module `zlib` does not give.
pub fn arrays(passes: &[Pass], picture: &mut Picture<'_>) -> Result<Vec<Array>, Stopped> {
    let image = level_shape(picture);
    let mut arrays = vec![(IMAGES, image, "|u1", deflated(picture.levels()?))];
    for &pass in passes {
        arrays.push((pass.name(), shape(picture, pass), type_of(pass), deflated(&bytes_of(picture.pass(pass))?)));
    }
    Ok(arrays)
}

/// Returns the lengths of the array of the picture.
pub fn level_shape(picture: &Picture<'_>) -> Vec<usize> {
    let (width, height) = picture.size();
    vec![height as usize, width as usize, picture.channels()]
}

fn deflated(bytes: &[u8]) -> Vec<u8> {
    miniz_oxide::deflate::compress_to_vec_zlib(bytes, LEVEL)
}

/// Returns a copy.
pub fn copied(bytes: &[u8]) -> Result<Vec<u8>, OutOfMemory> {
    let mut copy = Vec::new();
    reserve(&mut copy, bytes.len(), "a file")?;
    copy.extend_from_slice(bytes);
    Ok(copy)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::{BLOCK, deflated, tar};

    /// The name, the length and the start of each member, by the description of the format.
    fn members(archive: &[u8]) -> Vec<(String, Vec<u8>)> {
        let (mut members, mut rest) = (Vec::new(), archive);
        while !rest.is_empty() {
            let (header, after) = rest.split_at(BLOCK);
            let text = |range: std::ops::Range<usize>| {
                str::from_utf8(&header[range]).unwrap().trim_end_matches(['\0', ' ']).to_owned()
            };
            let sum: u32 = header
                .iter()
                .enumerate()
                .map(|(i, &byte)| if (148..156).contains(&i) { 32 } else { byte.into() })
                .sum();
            assert_eq!(u32::from_str_radix(&text(148..156), 8).unwrap(), sum);
            let length = usize::from_str_radix(&text(124..136), 8).unwrap();
            members.push((text(0..100), after[..length].to_vec()));
            rest = &after[length.next_multiple_of(BLOCK)..];
        }
        members
    }

    #[test]
    fn members_are_sorted_by_name() {
        let parts = [("image", ".png", vec![1; BLOCK]), ("depth", ".npy", vec![2])];
        let archive = tar("00000007", "{}", &parts).unwrap();
        let names: Vec<_> = members(&archive).into_iter().map(|(name, _)| name).collect();
        assert_eq!(names, ["00000007.depth.npy", "00000007.json", "00000007.png"]);
        assert_eq!(archive.len(), 6 * BLOCK);
    }

    proptest! {
        #[test]
        fn members_hold_their_bytes(png in prop::collection::vec(any::<u8>(), 0..1200), labels in "[a-z]{0,600}") {
            let archive = tar("00000000", &labels, &[("image", ".png", png.clone())]).unwrap();
            let expected = [("00000000.json".into(), format!("{labels}\n").into_bytes()), ("00000000.png".into(), png)];
            prop_assert_eq!(members(&archive), expected);
        }

        #[test]
        fn compressed_bytes_come_back(bytes in prop::collection::vec(0_u8..4, 0..2000)) {
            prop_assert_eq!(miniz_oxide::inflate::decompress_to_vec_zlib(&deflated(&bytes)).unwrap(), bytes);
        }
    }
}
