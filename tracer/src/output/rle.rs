//! Masks of objects as compressed run-length encodings of COCO, and the boxes around them.
//!
//! A mask is read column by column. Its runs, of pixels outside and inside by turns, are written as in COCO's
//! `maskApi.c` (`rleToString`): from the fourth on as the difference from the run two before, in groups of 5 bits, the
//! low ones first, each as a character from 48 on, with bit 5 set if more follow.

/// Pixels compared at a time.
const BLOCK: usize = 16;

/// The box around some pixels, if there are any: left, top, width, height.
pub type PixelBox = Option<[usize; 4]>;

/// A mask: its encoding, and the box around it.
pub type Mask = (String, PixelBox);

/// Return the number of pixels of each of the ids 1 to `count`, and the box around them. `ids` are rows of a width.
pub fn boxes(ids: &[u32], width: usize, count: usize) -> Vec<(usize, PixelBox)> {
    // The number of pixels; first and last column; first and last row.
    let mut found = vec![(0, [width, 0], [ids.len(), 0]); count];
    for (y, row) in ids.chunks(width).enumerate() {
        let mut start = 0;
        for run in row.chunk_by(|a, b| a == b) {
            let end = start + run.len();
            if let Some((pixels, columns, rows)) =
                (run[0] as usize).checked_sub(1).and_then(|id| found.get_mut(id))
            {
                *pixels += run.len();
                *columns = [columns[0].min(start), columns[1].max(end)];
                *rows = [rows[0].min(y), y + 1];
            }
            start = end;
        }
    }
    let boxed = |(pixels, [left, right], [top, bottom]): (usize, [usize; 2], [usize; 2])| {
        (pixels, (pixels > 0).then(|| [left, top, right - left, bottom - top]))
    };
    found.into_iter().map(boxed).collect()
}

/// Return the mask of the pixels that are not 0; `pixels` are rows of a width.
pub fn mask(pixels: &[u8], width: usize) -> Mask {
    let height = pixels.len().checked_div(width).unwrap_or(0);
    let mut around = [width, height, 0, 0];
    for (y, row) in pixels.chunks(width).enumerate() {
        // Most rows are empty, which a loop without an exit finds out several pixels at a time.
        if row.iter().fold(0, |any, &pixel| any | pixel) == 0 {
            continue;
        }
        if let Some(first) = row.iter().position(|&pixel| pixel != 0) {
            let last = row.iter().rposition(|&pixel| pixel != 0).unwrap_or(first);
            around = [around[0].min(first), around[1].min(y), around[2].max(last + 1), y + 1];
        }
    }
    let [left, top, right, bottom] = around;
    let mut runs = Runs::default();
    for x in left..right {
        for y in top..bottom {
            if pixels[y * width + x] != 0 {
                runs.push((x * height + y) as i64, 1);
            }
        }
    }
    let boxed = (left < right).then(|| [left, top, right - left, bottom - top]);
    (runs.encode(pixels.len() as i64), boxed)
}

/// Return the encoding of each object's mask, of the ids 1 to `count`. `ids` are rows of a width; others are ignored.
pub fn masks(ids: &[u32], width: usize, count: usize) -> Vec<String> {
    let height = ids.len().checked_div(width).unwrap_or(0);
    let mut runs = vec![Runs::default(); count];
    let starts = starts(ids, width, height);
    for (i, &start) in starts.iter().enumerate() {
        let end = starts.get(i + 1).copied().unwrap_or(ids.len());
        let id = ids[start % height * width + start / height] as usize;
        if let Some(runs) = id.checked_sub(1).and_then(|object| runs.get_mut(object)) {
            runs.push(start as i64, (end - start) as i64);
        }
    }
    runs.into_iter().map(|runs| runs.encode(ids.len() as i64)).collect()
}

/// Return the places, column by column, where a column starts or the id changes. Rows are compared in blocks, most of
/// which are equal.
fn starts(ids: &[u32], width: usize, height: usize) -> Vec<usize> {
    let mut starts: Vec<usize> = (0..width).map(|x| x * height).collect();
    for y in 1..height {
        let (above, row) = (&ids[(y - 1) * width..y * width], &ids[y * width..(y + 1) * width]);
        for (block, (above, row)) in above.chunks(BLOCK).zip(row.chunks(BLOCK)).enumerate() {
            if above != row {
                let changes = (0..row.len()).filter(|&x| above[x] != row[x]);
                starts.extend(changes.map(|x| (block * BLOCK + x) * height + y));
            }
        }
    }
    starts.sort_unstable();
    starts
}

/// The lengths of runs outside and inside by turns, up to a place.
#[derive(Clone, Default)]
struct Runs {
    lengths: Vec<i64>,
    end: i64,
}

impl Runs {
    /// Add some pixels inside.
    fn push(&mut self, place: i64, count: i64) {
        match self.lengths.last_mut() {
            Some(length) if place == self.end => *length += count,
            _ => self.lengths.extend([place - self.end, count]),
        }
        self.end = place + count;
    }

    fn encode(mut self, total: i64) -> String {
        if self.end < total {
            self.lengths.push(total - self.end);
        }
        let mut text = String::new();
        for (i, &length) in self.lengths.iter().enumerate() {
            let mut rest = if i > 2 { length - self.lengths[i - 2] } else { length };
            loop {
                let bits = rest & 0x1f;
                rest >>= 5;
                let ends = if bits & 0x10 == 0 { rest == 0 } else { rest == -1 };
                let character = bits | if ends { 0 } else { 0x20 };
                text.push(char::from(character as u8 + 48));
                if ends {
                    break;
                }
            }
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::{boxes, mask, masks};

    /// Encodings by pycocotools 2.0.
    #[test]
    fn encodes_as_coco_does() {
        #[rustfmt::skip]
        let ids = [
            1, 0, 0, 2,
            1, 1, 0, 2,
            0, 1, 0, 0,
        ];
        assert_eq!(masks(&ids, 4, 3), ["02204", "921", "<"]);
    }

    #[test]
    fn encodes_a_single_mask_as_the_masks_of_ids() {
        #[rustfmt::skip]
        let ids = [
            0, 0, 0, 0,
            0, 1, 0, 0,
            0, 1, 1, 0,
        ];
        let pixels = ids.map(|id| id as u8);
        assert_eq!(mask(&pixels, 4), (masks(&ids, 4, 1).remove(0), Some([1, 1, 2, 2])));
        assert_eq!(mask(&[0; 12], 4), (masks(&[0; 12], 4, 1).remove(0), None));
        assert_eq!(boxes(&ids, 4, 2), [(3, Some([1, 1, 2, 2])), (0, None)]);
    }

    #[test]
    fn writes_long_runs_in_several_characters() {
        let ids: Vec<u32> = (0..10_000).map(|i| u32::from((1_000..9_000).contains(&i))).collect();
        assert_eq!(masks(&ids, 1, 1), ["Xo0Pj7Xo0"]);
    }
}
