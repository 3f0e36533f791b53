//! A bounding volume hierarchy of spheres over the finite shapes of a scene, and the cones and pyramids that traverse
//! it.
//!
//! Nodes have up to eight children, which are tested together; a child is a node or a single object. Bounds and
//! tests are float32, and conservative by more than their rounding: the tree affects how fast a picture is, never
//! its content.

use crate::accel::build::{Item, TREE, build, partition};
use crate::accel::node::{LEAF, Node, WIDTH};
use crate::bounds::BoundingSphere;
use crate::budget::WorkCounter;
use crate::memory::{OutOfMemory, par_collect};
use rayon::prelude::*;

pub(crate) mod build;
pub(crate) mod cone;
pub(crate) mod node;
pub(crate) mod pyramid;

/// A part of space that rays from one point go through.
pub(crate) trait Volume {
    /// The length along the axis: what begins beyond is outside.
    fn range(&self) -> f32;

    /// Return where each child of a node begins along the axis, never below 0, and, one byte per child, which ones
    /// the volume may intersect before a limit.
    ///
    /// Mark it `#[inline(always)]`: it is compiled for each SIMD level.
    fn intersect(&self, node: &Node, limit: f32) -> ([f32; WIDTH], u64);
}

/// The tree; empty without objects.
#[derive(Clone, Debug)]
pub(crate) struct Bvh {
    nodes: Vec<Node>,
}

impl Bvh {
    /// Build the tree over the bounded ones of some objects, with the threads of the current rayon pool. Return it, and
    /// the objects in the order of the leaves, followed by those without bounds. The number of a leaf is its position in
    /// that order.
    ///
    /// # Errors
    ///
    /// If there is not enough memory for it.
    pub(crate) fn new(
        bounds: impl IndexedParallelIterator<Item = Option<BoundingSphere>>,
    ) -> Result<(Bvh, Vec<u32>), OutOfMemory> {
        let item = |(object, bounds): (usize, Option<BoundingSphere>)| Item::new(object as u32, bounds);
        let mut items = par_collect(bounds.enumerate().map(item), TREE)?;
        let mut count = items.len();
        if items.par_iter().any(Item::is_unbounded) {
            count = partition(&mut items, |item| !item.is_unbounded());
        }
        let (bounded, unbounded) = items.split_at_mut(count);
        unbounded.sort_unstable_by_key(|item| item.object);
        let nodes = build(bounded)?;
        Ok((Bvh { nodes }, par_collect(items.par_iter().map(|item| item.object), TREE)?))
    }

    /// Give the leaves other numbers, those at their positions in a list.
    pub(crate) fn renumber(&mut self, numbers: &[u32]) {
        self.nodes.par_iter_mut().flat_map_iter(|node| &mut node.child).for_each(|child| {
            if *child & LEAF != 0 {
                *child = LEAF | numbers[(*child & !LEAF) as usize];
            }
        });
    }

    /// Whether a tight volume saves more visits than it takes to make one.
    #[inline(always)]
    pub(crate) fn is_deep(&self) -> bool {
        self.nodes.len() > 1
    }

    /// Start a traversal of the objects that a volume may intersect.
    #[inline(always)]
    pub(crate) fn traverse<'a, V: Volume>(&'a self, volume: &'a V, stack: &'a mut Stack) -> Traversal<'a, V> {
        stack.waiting.clear();
        Traversal { nodes: &self.nodes, volume, next: if self.nodes.is_empty() { DONE } else { 0 }, stack }
    }
}

/// Take the first of the children that a volume intersects.
#[inline(always)]
pub(crate) fn next_child(met: &mut u64) -> Option<usize> {
    let i = met.trailing_zeros() as usize / 8;
    *met &= met.wrapping_sub(1);
    (i < WIDTH).then_some(i)
}

/// A list of objects with their bounds, which are tested eight at a time.
#[derive(Clone, Debug, Default)]
pub(crate) struct ObjectList {
    nodes: Vec<Node>,
    count: usize,
}

impl ObjectList {
    pub(crate) fn clear(&mut self) {
        self.nodes.clear();
        self.count = 0;
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.count == 0
    }

    #[inline(always)]
    pub(crate) fn push(&mut self, object: u32, bounds: Option<BoundingSphere>) {
        let i = self.count % WIDTH;
        if i == 0 {
            self.nodes.push(Node::empty());
        }
        let item = Item::new(object, bounds);
        let node = self.nodes.last_mut().expect("it has a place left");
        // Every volume intersects an object without bounds.
        node.put(i, (item.center, if item.is_unbounded() { f32::INFINITY } else { item.radius }), object);
        self.count += 1;
    }

    /// The nodes, whose children are numbers of objects.
    pub(crate) fn nodes(&self) -> &[Node] {
        &self.nodes
    }
}

/// The state kept between traversals.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stack {
    /// The nodes and objects left to visit: in the upper bits, those of the distance along the volume's axis where
    /// each begins; in the lower bits, its number.
    waiting: Vec<u64>,
    /// Counts the steps of all traversals, which end at once when the limit is exceeded.
    pub(crate) work: WorkCounter,
    /// The steps that each object takes.
    pub(crate) steps_per_object: u64,
}

/// Marks the end: greater than every entry.
const DONE: u64 = u64::MAX;

/// A traversal of the tree, roughly from near to far.
#[derive(Debug)]
pub(crate) struct Traversal<'a, V> {
    nodes: &'a [Node],
    volume: &'a V,
    /// The entry to visit next, or `DONE`.
    next: u64,
    /// The entries to visit after it, the nearest last.
    stack: &'a mut Stack,
}

impl<V: Volume> Traversal<'_, V> {
    /// The next object, unless all others begin beyond a distance along the volume's axis.
    #[inline(always)]
    pub(crate) fn next(&mut self, limit: f32) -> Option<u32> {
        let limit = limit.min(self.volume.range());
        // Counted here and added at once: the limit is checked for objects only.
        let mut opened = 0;
        loop {
            let next = self.next;
            if next == DONE {
                self.stack.work.take(opened);
                return None;
            }
            let number = next as u32;
            if (next >> 32) as u32 > limit.to_bits() {
                self.next = self.stack.waiting.pop().unwrap_or(DONE);
            } else if number & LEAF != 0 {
                self.next = self.stack.waiting.pop().unwrap_or(DONE);
                let may = self.stack.work.take(opened + self.stack.steps_per_object);
                return may.then_some(number & !LEAF);
            } else {
                opened += 1;
                self.open(number, limit);
            }
        }
    }

    /// Go on with the nearest child of a node, and put the others on the stack.
    #[inline(always)]
    fn open(&mut self, number: u32, limit: f32) {
        let node = &self.nodes[number as usize];
        let (near, mut met) = self.volume.intersect(node, limit);
        let mut found = [0; WIDTH];
        let mut count = 0;
        while let Some(i) = next_child(&mut met) {
            let entry = u64::from(near[i].to_bits()) << 32 | u64::from(node.child[i]);
            // Insertion, the nearest last.
            let mut j = count;
            while j > 0 && found[j - 1] < entry {
                found[j] = found[j - 1];
                j -= 1;
            }
            found[j] = entry;
            count += 1;
        }
        let stack = &mut self.stack.waiting;
        if count == 0 {
            self.next = stack.pop().unwrap_or(DONE);
        } else {
            self.next = found[count - 1];
            stack.extend_from_slice(&found[..count - 1]);
        }
    }
}

#[cfg(test)]
mod tests;
