//! Building the tree, by the surface area heuristic.

use crate::accel::node::{CONSERVATIVE, LEAF, Node, WIDTH};
use crate::bounds::{Aabb, BoundingSphere};
use crate::memory::{OutOfMemory, reserve};
use crate::vector::{add, length, scale, sub, to_f32};
use rayon::prelude::*;

/// Named in the error if memory runs out.
pub(crate) const TREE: &str = "the tree over the objects";

/// Candidate positions of a cut along an axis.
const BINS: usize = 16;

/// Subtrees over more objects than this are built by several threads.
const WORTH_A_THREAD: usize = 4096;

/// An object on its way into the tree.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Item {
    pub(crate) bounds: BoundingSphere,
    pub(crate) object: u32,
}

/// The items of one child, and their bounding box.
pub(crate) struct Part<'a> {
    items: &'a mut [Item],
    extent: Aabb,
}

impl<'a> Part<'a> {
    pub(crate) fn new(items: &'a mut [Item]) -> Part<'a> {
        let extent =
            items.iter().fold(Aabb::EMPTY, |extent, item| extent.with(item.bounds.center, item.bounds.radius));
        Part { items, extent }
    }

    /// The bounding sphere of the items around the middle of their bounding box.
    fn bounds(&self) -> BoundingSphere {
        if let [item] = &*self.items {
            return item.bounds;
        }
        let center = scale(add(self.extent.low, self.extent.high), 0.5);
        let radius = self.items.iter().fold(0.0, |radius: f64, item| {
            radius.max(length(sub(item.bounds.center, center)) + item.bounds.radius)
        });
        BoundingSphere { center, radius }
    }
}

/// Append the nodes of a tree over items, the root first.
pub(crate) fn build(part: Part<'_>, nodes: &mut Vec<Node>) -> Result<(), OutOfMemory> {
    let number = nodes.len();
    reserve(nodes, 1, TREE)?;
    nodes.push(Node::empty());
    let large = part.items.len() > WORTH_A_THREAD;
    let parts = eight_parts(part);
    for (i, part) in parts.iter().enumerate() {
        let bounds = part.bounds();
        let node = &mut nodes[number];
        [node.x[i], node.y[i], node.z[i]] = to_f32(bounds.center);
        node.radius[i] =
            (bounds.radius + length(bounds.center) * f64::from(CONSERVATIVE)) as f32 * (1.0 + CONSERVATIVE);
        if let [item] = &*part.items {
            node.child[i] = LEAF | item.object;
        }
    }
    if large {
        let subtrees: Result<Vec<Vec<Node>>, OutOfMemory> = parts
            .into_par_iter()
            .map(|part| {
                let mut nodes = Vec::new();
                if part.items.len() > 1 {
                    build(part, &mut nodes)?;
                }
                Ok(nodes)
            })
            .collect();
        for (i, subtree) in subtrees?.into_iter().enumerate() {
            let begin = nodes.len() as u32;
            if !subtree.is_empty() {
                nodes[number].child[i] = begin;
            }
            reserve(nodes, subtree.len(), TREE)?;
            nodes.extend(subtree.into_iter().map(|node| node.moved(begin)));
        }
        return Ok(());
    }
    for (i, part) in parts.into_iter().enumerate() {
        if part.items.len() > 1 {
            nodes[number].child[i] = nodes.len() as u32;
            build(part, nodes)?;
        }
    }
    Ok(())
}

/// Cut items into at most eight parts, the one with the largest surface first.
fn eight_parts(part: Part<'_>) -> Vec<Part<'_>> {
    if part.items.len() <= WIDTH {
        return part.items.chunks_mut(1).map(Part::new).collect();
    }
    let mut parts = vec![part];
    while parts.len() < WIDTH {
        let largest = (0..parts.len())
            .filter(|&i| parts[i].items.len() > 1)
            .max_by(|&a, &b| parts[a].extent.area().total_cmp(&parts[b].extent.area()));
        let Some(i) = largest else { break };
        let part = parts.swap_remove(i);
        let middle = cut(part.items);
        let (left, right) = part.items.split_at_mut(middle);
        parts.push(Part::new(left));
        parts.push(Part::new(right));
    }
    parts
}

/// Sort items into two parts and return where the second begins.
///
/// The surface area heuristic, in bins (I. Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies",
/// 2007): the cost of a cut is the sum over its parts of surface times count.
fn cut(items: &mut [Item]) -> usize {
    let centers = items.iter().fold(Aabb::EMPTY, |extent, item| extent.with(item.bounds.center, 0.0));
    let size = sub(centers.high, centers.low);
    let axis = (0..3).fold(0, |a, b| if size[b] > size[a] { b } else { a });
    let per_size = BINS as f64 / size[axis];
    let bin = |item: &Item| {
        let along = (item.bounds.center[axis] - centers.low[axis]) * per_size;
        (along as usize).min(BINS - 1)
    };
    let mut bins = [(0_usize, Aabb::EMPTY); BINS];
    for item in items.iter() {
        let (count, extent) = &mut bins[bin(item)];
        *count += 1;
        *extent = extent.with(item.bounds.center, item.bounds.radius);
    }
    let last = cheapest_cut(&bins);
    let mut middle = 0;
    for i in 0..items.len() {
        if bin(&items[i]) <= last {
            items.swap(i, middle);
            middle += 1;
        }
    }
    if middle == 0 || middle == items.len() {
        // All are in one bin: any halves will do.
        return items.len() / 2;
    }
    middle
}

/// The last bin of the left part.
fn cheapest_cut(bins: &[(usize, Aabb); BINS]) -> usize {
    let joined = |a: (usize, Aabb), b: &(usize, Aabb)| (a.0 + b.0, a.1.joined(&b.1));
    let cost = |(count, extent): (usize, Aabb)| count as f64 * extent.area();
    let mut right_cost = [0.0; BINS];
    let mut right = (0, Aabb::EMPTY);
    for i in (1..BINS).rev() {
        right = joined(right, &bins[i]);
        right_cost[i] = cost(right);
    }
    let (mut best, mut cheapest) = (0, f64::INFINITY);
    let mut left = (0, Aabb::EMPTY);
    for i in 0..BINS - 1 {
        left = joined(left, &bins[i]);
        let total = cost(left) + right_cost[i + 1];
        if total < cheapest {
            (best, cheapest) = (i, total);
        }
    }
    best
}
