//! The rays of a tile, sorted by the face they hit.

use crate::tile::hits::HitBuffer;
use crate::tile::{LANES, Tile};

/// Rays that hit the same face.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Group {
    /// The face, or `NO_FACE`.
    pub(crate) face: u32,
    /// The smallest depth of all the tile's rays, requested or not, so that it does not depend on a crop.
    pub(crate) t: f32,
    /// The range of its lanes in `Groups::order`.
    first: usize,
    end: usize,
}

/// Neighbouring lanes that hit the same face.
#[derive(Clone, Copy, Debug)]
struct Run {
    group: usize,
    first: usize,
    end: usize,
}

/// The groups of a tile, in the order of their first rays.
#[derive(Clone, Debug)]
pub(crate) struct Groups {
    pub(crate) list: Vec<Group>,
    runs: Vec<Run>,
    order: [u8; LANES],
}

impl Groups {
    pub(crate) fn new() -> Groups {
        Groups { list: Vec::new(), runs: Vec::new(), order: [0; LANES] }
    }

    /// The requested lanes of a group, in order.
    #[inline(always)]
    pub(crate) fn lanes(&self, group: usize) -> &[u8] {
        let Group { first, end, .. } = self.list[group];
        &self.order[first..end]
    }

    /// Group the requested lanes of a tile.
    #[inline(always)]
    pub(crate) fn collect(&mut self, hits: &HitBuffer, tile: Tile) {
        self.list.clear();
        let whole = tile.is_whole();
        if is_uniform(&hits.face) && whole {
            self.order = std::array::from_fn(|lane| lane as u8);
            self.list.push(Group { face: hits.face[0], t: hits.closest(), first: 0, end: LANES });
            return;
        }
        self.find(hits);
        self.sort(|lane| whole || tile.wants(lane));
    }

    /// Sort the requested lanes by group.
    #[inline(always)]
    fn sort(&mut self, wants: impl Fn(usize) -> bool) {
        for &Run { group, first, end } in &self.runs {
            self.list[group].end += (first..end).filter(|&lane| wants(lane)).count();
        }
        // Counting sort: counts become ranges, which the lanes then fill.
        let mut first = 0;
        for group in &mut self.list {
            let count = group.end;
            (group.first, group.end) = (first, first);
            first += count;
        }
        for &Run { group, first, end } in &self.runs {
            let filled = &mut self.list[group].end;
            for (slot, lane) in self.order[*filled..].iter_mut().zip((first..end).filter(|&lane| wants(lane))) {
                *slot = lane as u8;
                *filled += 1;
            }
        }
    }

    /// Find the group of each run, with a hash table of twice as many slots as there can be faces. Runs, since lanes
    /// one by one would each wait until the depth of their group is stored.
    #[inline(always)]
    fn find(&mut self, hits: &HitBuffer) {
        const SLOTS: usize = 2 * LANES;
        let mut table = [0_u16; SLOTS]; // group + 1
        self.runs.clear();
        let mut end = 0;
        while end < LANES {
            let (first, face, mut closest) = (end, hits.face[end], hits.t[end]);
            end += 1;
            while end < LANES && hits.face[end] == face {
                closest = if hits.t[end] < closest { hits.t[end] } else { closest };
                end += 1;
            }
            // Fibonacci hashing (D. Knuth, "The Art of Computer Programming", volume 3, section 6.4).
            let mut slot = (face.wrapping_mul(0x9e37_79b1) >> 23) as usize % SLOTS;
            while table[slot] != 0 && self.list[usize::from(table[slot]) - 1].face != face {
                slot = (slot + 1) % SLOTS;
            }
            if table[slot] == 0 {
                self.list.push(Group { face, t: f32::INFINITY, first: 0, end: 0 });
                table[slot] = self.list.len() as u16;
            }
            let group = usize::from(table[slot]) - 1;
            let t = &mut self.list[group].t;
            *t = if closest < *t { closest } else { *t };
            self.runs.push(Run { group, first, end });
        }
    }
}

#[inline(always)]
fn is_uniform(faces: &[u32; LANES]) -> bool {
    let mut difference = 0;
    for face in faces {
        difference |= face ^ faces[0];
    }
    difference == 0
}

#[cfg(test)]
mod tests;
