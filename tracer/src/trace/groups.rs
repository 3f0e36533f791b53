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

/// The groups of a tile, in the order of their first rays.
#[derive(Clone, Debug)]
pub(crate) struct Groups {
    pub(crate) list: Vec<Group>,
    order: [u8; LANES],
}

impl Groups {
    pub(crate) fn new() -> Groups {
        Groups { list: Vec::new(), order: [0; LANES] }
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
        let mut group_of = [0_u8; LANES];
        self.find(hits, &mut group_of);
        self.sort(&group_of, |lane| whole || tile.wants(lane));
    }

    /// Sort the requested lanes by group.
    #[inline(always)]
    fn sort(&mut self, group_of: &[u8; LANES], wants: impl Fn(usize) -> bool) {
        for lane in 0..LANES {
            self.list[usize::from(group_of[lane])].end += usize::from(wants(lane));
        }
        // Counting sort: counts become ranges, which the lanes then fill.
        let mut first = 0;
        for group in &mut self.list {
            let count = group.end;
            (group.first, group.end) = (first, first);
            first += count;
        }
        for lane in 0..LANES {
            if wants(lane) {
                let group = &mut self.list[usize::from(group_of[lane])];
                self.order[group.end] = lane as u8;
                group.end += 1;
            }
        }
    }

    /// Find the group of each lane, with a hash table of twice as many slots as there can be faces.
    #[inline(always)]
    fn find(&mut self, hits: &HitBuffer, group_of: &mut [u8; LANES]) {
        const SLOTS: usize = 2 * LANES;
        let mut table = [0_u16; SLOTS]; // group + 1
        let mut last = 0;
        for lane in 0..LANES {
            let (face, t) = (hits.face[lane], hits.t[lane]);
            if lane == 0 || self.list[last].face != face {
                // Fibonacci hashing (D. Knuth, "The Art of Computer Programming", volume 3, section 6.4).
                let mut slot = (face.wrapping_mul(0x9e37_79b1) >> 23) as usize % SLOTS;
                while table[slot] != 0 && self.list[usize::from(table[slot]) - 1].face != face {
                    slot = (slot + 1) % SLOTS;
                }
                if table[slot] == 0 {
                    self.list.push(Group { face, t: f32::INFINITY, first: 0, end: 0 });
                    table[slot] = self.list.len() as u16;
                }
                last = usize::from(table[slot]) - 1;
            }
            group_of[lane] = last as u8;
            let group = &mut self.list[last];
            group.t = if t < group.t { t } else { group.t };
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
