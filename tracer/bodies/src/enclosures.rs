//! The search for boxes that hold others.
//!
//! A grid for each power of two holds the boxes of that size by their centers. Whatever holds a box has its center in
//! one of eight cells of each grid, so a search among many boxes takes about constant time.

use crate::boxes::{Boxes, Triple};
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};
use std::sync::Arc;

/// The numbers of a cell along the axes, as the bits of floats.
type Cell = [u64; 3];

/// The cells of a grid that are not empty, with the indices of their boxes.
type Grid = HashMap<Cell, Vec<usize>, BuildHasherDefault<CellHasher>>;

/// The exponents that the sizes of cells may have.
const LEVELS: (i32, i32) = (-1000, 1000);

/// Finds boxes that hold others, with a limited number of comparisons.
#[derive(Clone, Debug)]
pub struct Enclosures {
    boxes: Arc<Boxes>,
    /// The grids with the exponents of their cells' size, in the order of their first boxes.
    grids: Vec<(i32, Grid)>,
    occupied: Occupied,
    /// The comparisons that are left.
    left: i64,
}

impl Enclosures {
    /// Returns a search among some of many boxes.
    pub fn new(boxes: Arc<Boxes>, chosen: &[usize], comparisons: u32) -> Enclosures {
        let mut grids: Vec<(i32, Grid)> = Vec::new();
        let mut occupied = Occupied::for_cells(chosen.len());
        for &index in chosen {
            let (center, half) = boxes.get(index);
            let level = level(largest(half));
            let place = grids.iter().position(|(own, _)| *own == level).unwrap_or_else(|| {
                grids.push((level, Grid::default()));
                grids.len() - 1
            });
            let cell = center.map(|c| bits((c / size(level)).floor()));
            grids[place].1.entry(cell).or_default().push(index);
            occupied.add(level, cell);
        }
        Enclosures { boxes, grids, occupied, left: comparisons.into() }
    }

    /// Returns the number of all boxes, chosen or not.
    pub fn len(&self) -> usize {
        self.boxes.len()
    }

    /// Whether there are no boxes.
    pub fn is_empty(&self) -> bool {
        self.boxes.is_empty()
    }

    /// Whether a search ended early, because it would have taken too many comparisons.
    pub fn gave_up(&self) -> bool {
        self.left < 0
    }

    /// Returns the first box that holds another and is one that is looked for; None without one.
    ///
    /// # Errors
    ///
    /// The first one of `is_wanted`.
    pub fn around<E>(
        &mut self,
        (center, half): (Triple, Triple),
        mut is_wanted: impl FnMut(usize) -> Result<bool, E>,
    ) -> Result<Option<usize>, E> {
        let extent = largest(half);
        let least = if extent > 0.0 { level(extent) } else { LEVELS.0 };
        for (level, grid) in self.grids.iter().filter(|(level, _)| *level >= least) {
            let cells = near(center, size(*level)).filter(|cell| self.occupied.may_have(*level, *cell));
            for index in cells.filter_map(|cell| grid.get(&cell)).flatten() {
                self.left -= 1;
                if self.left < 0 {
                    return Ok(None);
                }
                if holds(self.boxes.get(*index), (center, half)) && is_wanted(*index)? {
                    return Ok(Some(*index));
                }
            }
        }
        Ok(None)
    }

    /// Returns the first of some boxes that another holds, by its place among them, and that other one. It takes no
    /// box after that.
    ///
    /// # Errors
    ///
    /// The first one of `inner`, or of `is_wanted`, which gets the inner box and the outer one.
    pub fn first_inside<E>(
        &mut self,
        inner: impl IntoIterator<Item = Result<usize, E>>,
        mut is_wanted: impl FnMut(usize, usize) -> Result<bool, E>,
    ) -> Result<Option<(usize, usize)>, E> {
        for (place, inner) in inner.into_iter().enumerate() {
            let inner = inner?;
            let found =
                self.around(self.boxes.get(inner), |outer| Ok(outer != inner && is_wanted(inner, outer)?))?;
            if let Some(outer) = found {
                return Ok(Some((place, outer)));
            }
            if self.gave_up() {
                break;
            }
        }
        Ok(None)
    }
}

/// Whether a box holds another.
fn holds((center, half): (Triple, Triple), (inner, inner_half): (Triple, Triple)) -> bool {
    (0..3).all(|i| (inner[i] - center[i]).abs() + inner_half[i] <= half[i])
}

fn largest(half: Triple) -> f64 {
    half[0].max(half[1]).max(half[2])
}

/// Returns the exponent of a power of two that is at least twice an extent: the size of a cell.
fn level(extent: f64) -> i32 {
    (libm::frexp(extent).1 + 1).clamp(LEVELS.0, LEVELS.1)
}

fn size(level: i32) -> f64 {
    libm::ldexp(1.0, level)
}

/// Returns the cells whose points are at most half a cell away along each axis.
fn near(center: Triple, size: f64) -> impl Iterator<Item = Cell> {
    let [xs, ys, zs] = center.map(|c| {
        let (low, high) = (((c - size / 2.0) / size).floor(), ((c + size / 2.0) / size).floor());
        // The order decides which of several boxes is found first.
        [Some(low), (low < high).then_some(high)]
    });
    let all = |[first, second]: [Option<f64>; 2]| first.into_iter().chain(second).map(bits);
    all(xs).flat_map(move |x| all(ys).flat_map(move |y| all(zs).map(move |z| [x, y, z])))
}

/// Returns the bits of a number, the same for both zeros.
fn bits(number: f64) -> u64 {
    (number + 0.0).to_bits()
}

/// Bits that tell of most empty cells that they are empty, in so little memory that it stays close to the processor.
#[derive(Clone, Debug)]
struct Occupied {
    words: Vec<u64>,
}

impl Occupied {
    /// Returns bits for some number of cells, about 16 for each.
    fn for_cells(count: usize) -> Occupied {
        Occupied { words: vec![0; (count / 4).next_power_of_two()] }
    }

    fn add(&mut self, level: i32, cell: Cell) {
        let (word, bit) = self.place(level, cell);
        self.words[word] |= bit;
    }

    fn may_have(&self, level: i32, cell: Cell) -> bool {
        let (word, bit) = self.place(level, cell);
        self.words[word] & bit != 0
    }

    fn place(&self, level: i32, cell: Cell) -> (usize, u64) {
        let mut hasher = CellHasher(level.unsigned_abs().into());
        cell.iter().for_each(|&word| hasher.write_u64(word));
        let hash = hasher.finish();
        ((hash >> 6) as usize & (self.words.len() - 1), 1 << (hash & 63))
    }
}

/// Hashes cells in a few steps. Cells made to collide do no harm, since comparisons are limited.
#[derive(Clone, Copy, Debug, Default)]
struct CellHasher(u64);

impl Hasher for CellHasher {
    fn finish(&self) -> u64 {
        self.0 ^ (self.0 >> 32)
    }

    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.write_u64(byte.into());
        }
    }

    fn write_u64(&mut self, word: u64) {
        self.0 = (self.0 ^ word ^ (word >> 40)).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29);
    }
}

#[cfg(test)]
mod tests {
    use super::{Boxes, Enclosures};
    use std::convert::Infallible;
    use std::sync::Arc;

    fn cubes(cubes: &[(f64, f64)]) -> Arc<Boxes> {
        Arc::new(Boxes::new(
            cubes.iter().map(|&(x, _)| [x, 0.0, 0.0]).collect(),
            cubes.iter().map(|&(_, half)| [half; 3]).collect(),
        ))
    }

    fn any(_: usize) -> Result<bool, Infallible> {
        Ok(true)
    }

    #[test]
    fn a_box_is_found_around_another_of_any_size() {
        let boxes = cubes(&[(0.0, 5.0), (20.0, 5.0), (40.0, 300.0)]);
        let mut search = Enclosures::new(boxes, &[0, 1], 100);
        assert_eq!(search.around(([2.0, 1.0, -1.0], [3.0; 3]), any), Ok(Some(0)));
        assert_eq!(search.around(([2.0, 1.0, -1.0], [3.1; 3]), any), Ok(None));
        assert_eq!(search.around(([19.0, 0.0, 0.0], [0.0; 3]), any), Ok(Some(1)));
        assert_eq!(search.around(([19.0, 0.0, 0.0], [1e-300; 3]), any), Ok(Some(1)));
        assert_eq!(search.around(([40.0, 0.0, 0.0], [0.0; 3]), any), Ok(None), "it was not chosen");
    }

    #[test]
    fn a_box_that_is_not_wanted_is_passed_over() {
        let mut search = Enclosures::new(cubes(&[(0.0, 5.0), (0.5, 5.0), (0.0, 90.0)]), &[0, 1, 2], 100);
        assert_eq!(search.around(([0.5, 0.0, 0.0], [1.0; 3]), |index| Ok::<_, ()>(index == 2)), Ok(Some(2)));
        assert_eq!(search.around(([0.5, 0.0, 0.0], [1.0; 3]), |_| Err("no")), Err("no"));
    }

    #[test]
    fn the_first_of_several_boxes_inside_others_is_found() {
        let mut search =
            Enclosures::new(cubes(&[(0.0, 5.0), (1.0, 1.0), (9.0, 1.0), (2.0, 1.0)]), &[0, 1, 2, 3], 100);
        let wanted = |_, _| Ok::<_, Infallible>(true);
        assert_eq!(search.first_inside([0, 2, 3, 1].map(Ok), wanted), Ok(Some((2, 0))));
        assert_eq!(search.first_inside([1].map(Ok), wanted), Ok(Some((0, 0))));
        assert_eq!(search.first_inside([0, 2].map(Ok), wanted), Ok(None));
    }

    #[test]
    fn no_box_is_taken_after_the_first_inside_another() {
        let mut search = Enclosures::new(cubes(&[(0.0, 5.0), (1.0, 1.0), (9.0, 1.0)]), &[0, 1, 2], 100);
        let inner = [Ok(2), Ok(1), Err("unknown")];
        assert_eq!(search.first_inside(inner, |_, _| Ok(true)), Ok(Some((1, 0))));
        assert_eq!(search.first_inside(inner, |_, _| Ok(false)), Err("unknown"));
    }

    #[test]
    fn of_several_boxes_the_one_in_the_lowest_cell_is_found() {
        // The cells have a size of 16: their numbers are -1, 0, 0 and 1.
        let mut search =
            Enclosures::new(cubes(&[(-1.0, 5.0), (1.0, 5.0), (15.0, 5.0), (17.0, 5.0)]), &[0, 1, 2, 3], 99);
        assert_eq!(search.around(([0.0; 3], [1.0; 3]), any), Ok(Some(0)));
        assert_eq!(search.around(([16.0, 0.0, 0.0], [1.0; 3]), any), Ok(Some(2)));
    }

    #[test]
    fn a_search_that_takes_too_long_is_given_up() {
        let mut search = Enclosures::new(cubes(&[(0.0, 5.0), (0.1, 5.0), (0.2, 5.0)]), &[0, 1, 2], 7);
        let none = |_, _| Ok::<_, Infallible>(false);
        assert_eq!(search.first_inside([0, 1].map(Ok), none), Ok(None));
        assert!(!search.gave_up());
        assert_eq!(search.first_inside([2].map(Ok), none), Ok(None));
        assert!(search.gave_up());
        assert_eq!(search.around(([0.0; 3], [1.0; 3]), any), Ok(None));
    }
}
