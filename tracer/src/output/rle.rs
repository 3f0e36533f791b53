//! Masks of objects as compressed run-length encodings of COCO.
//!
//! A mask is read column by column. Its runs, of pixels outside and inside by turns, are written as in COCO's
//! `maskApi.c` (`rleToString`): from the fourth on as the difference from the run two before, in groups of 5 bits, the
//! low ones first, each as a character from 48 on, with bit 5 set if more follow.

/// Return the encoding of each object's mask, of the ids 1 to `count`. `ids` are rows of a width; others are ignored.
pub fn masks(ids: &[u32], width: usize, count: usize) -> Vec<String> {
    let mut runs = vec![Runs::default(); count];
    let height = ids.len().checked_div(width).unwrap_or(0);
    for (place, id) in (0..width).flat_map(|x| (0..height).map(move |y| y * width + x)).map(|i| ids[i]).enumerate()
    {
        if let Some(runs) = (id as usize).checked_sub(1).and_then(|object| runs.get_mut(object)) {
            runs.push(place as i64);
        }
    }
    runs.into_iter().map(|runs| runs.encode(ids.len() as i64)).collect()
}

/// The lengths of runs outside and inside by turns, up to a place.
#[derive(Clone, Default)]
struct Runs {
    lengths: Vec<i64>,
    end: i64,
}

impl Runs {
    /// Add a pixel inside.
    fn push(&mut self, place: i64) {
        match self.lengths.last_mut() {
            Some(length) if place == self.end => *length += 1,
            _ => self.lengths.extend([place - self.end, 1]),
        }
        self.end = place + 1;
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
    use super::masks;

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
    fn writes_long_runs_in_several_characters() {
        let ids: Vec<u32> = (0..10_000).map(|i| u32::from((1_000..9_000).contains(&i))).collect();
        assert_eq!(masks(&ids, 1, 1), ["Xo0Pj7Xo0"]);
    }
}
