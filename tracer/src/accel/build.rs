//! Building the tree, by the surface area heuristic.
//!
//! Large lists are halved again and again for their cuts, and subtrees are built side by side, at cuts that depend
//! on the number of items alone: the tree is the same for any number of threads.

use crate::accel::node::{LEAF, Node, WIDTH};
use crate::bounds::BoundingSphere;
use crate::memory::{OutOfMemory, par_collect, reserve, with_capacity};
use crate::vector::to_f32;
use rayon::prelude::*;

/// Named in the error if memory runs out.
pub(crate) const TREE: &str = "the tree over the objects";

/// Candidate positions of a cut along an axis.
const BINS: usize = 16;

/// A tree has at most about one node for this number of items.
const NODES_PER_ITEM: usize = 4;

/// Subtrees over more objects than this are built by several threads.
const WORTH_A_THREAD: usize = 4096;

/// Lists of more items than this are cut by several threads.
const WORTH_HALVING: usize = 1 << 15;

/// Coordinates beyond this would overflow float32 when squared.
const MOST_FAR: f64 = 1e18;

/// The bounding sphere of an object on its way into the tree.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Item {
    pub(crate) center: [f32; 3],
    /// NaN for an object without bounds.
    pub(crate) radius: f32,
    pub(crate) object: u32,
}

impl Item {
    pub(crate) fn new(object: u32, bounds: Option<BoundingSphere>) -> Item {
        let Some(BoundingSphere { center, radius }) = bounds else {
            return Item { center: [0.0; 3], radius: f32::NAN, object };
        };
        // Sizes near the largest numbers may make a sphere that is none.
        if !center.iter().all(|x| x.abs() <= MOST_FAR) || radius.is_nan() {
            return Item { center: [0.0; 3], radius: f32::INFINITY, object };
        }
        Item { center: to_f32(center), radius: radius as f32, object }
    }

    pub(crate) fn is_unbounded(&self) -> bool {
        self.radius.is_nan()
    }
}

/// An axis-aligned bounding box, with a fourth coordinate so that it fits vector registers.
#[derive(Clone, Copy, Debug)]
struct Aabb {
    low: [f32; 4],
    high: [f32; 4],
}

impl Aabb {
    const EMPTY: Aabb = Aabb { low: [f32::INFINITY; 4], high: [f32::NEG_INFINITY; 4] };

    #[inline(always)]
    fn around([x, y, z]: [f32; 3], radius: f32) -> Aabb {
        Aabb { low: [x - radius, y - radius, z - radius, 0.0], high: [x + radius, y + radius, z + radius, 0.0] }
    }

    #[inline(always)]
    fn joined(&self, other: &Aabb) -> Aabb {
        let lower = |a: f32, b: f32| if b < a { b } else { a };
        let higher = |a: f32, b: f32| if b > a { b } else { a };
        Aabb {
            low: std::array::from_fn(|i| lower(self.low[i], other.low[i])),
            high: std::array::from_fn(|i| higher(self.high[i], other.high[i])),
        }
    }

    fn size(&self) -> [f32; 3] {
        std::array::from_fn(|i| self.high[i] - self.low[i])
    }

    /// Half the surface area; 0 if empty.
    fn area(&self) -> f64 {
        let [x, y, z] = self.size().map(f64::from);
        if x >= 0.0 { x * y + y * z + z * x } else { 0.0 }
    }
}

/// The number of some items, and the bounding boxes of the spheres and of their centres.
#[derive(Clone, Copy, Debug)]
struct Extent {
    count: usize,
    spheres: Aabb,
    centers: Aabb,
}

impl Extent {
    const EMPTY: Extent = Extent { count: 0, spheres: Aabb::EMPTY, centers: Aabb::EMPTY };

    fn of(items: &[Item]) -> Extent {
        if items.len() > WORTH_HALVING {
            let (left, right) = items.split_at(items.len() / 2);
            let (left, right) = rayon::join(|| Extent::of(left), || Extent::of(right));
            return left.joined(&right);
        }
        items.iter().fold(Extent::EMPTY, Extent::with)
    }

    #[inline(always)]
    fn with(self, item: &Item) -> Extent {
        let sphere = Aabb::around(item.center, item.radius);
        self.joined(&Extent { count: 1, spheres: sphere, centers: Aabb::around(item.center, 0.0) })
    }

    #[inline(always)]
    fn joined(&self, other: &Extent) -> Extent {
        Extent {
            count: self.count + other.count,
            spheres: self.spheres.joined(&other.spheres),
            centers: self.centers.joined(&other.centers),
        }
    }

    fn cost(&self) -> f64 {
        self.count as f64 * self.spheres.area()
    }
}

/// The items of one child, the position of the first among all items, and their extent.
struct Part<'a> {
    items: &'a mut [Item],
    first: usize,
    extent: Extent,
}

impl<'a> Part<'a> {
    fn new(items: &'a mut [Item], first: usize) -> Part<'a> {
        Part { extent: Extent::of(items), items, first }
    }

    /// The bounding sphere of the items around the middle of their bounding box.
    fn bounds(&self) -> ([f32; 3], f32) {
        if let [item] = &*self.items {
            return (item.center, item.radius);
        }
        let Aabb { low, high } = self.extent.spheres;
        let middle = |i: usize| {
            let middle = (low[i] + high[i]) * 0.5;
            // The box around an infinite sphere has no middle.
            if middle.is_finite() { middle } else { 0.0 }
        };
        let center = [middle(0), middle(1), middle(2)];
        (center, reach(self.items, center))
    }

    /// The number of a leaf, if there is a single item.
    fn leaf(&self) -> Option<u32> {
        (self.items.len() == 1).then_some(LEAF | self.first as u32)
    }

    /// Cut the items in two.
    fn cut(self) -> [Part<'a>; 2] {
        let Part { items, first, extent } = self;
        let bins = Bins::along(&extent.centers);
        let extents = bins.fill(items);
        let last = cheapest_cut(&extents);
        let middle = partition(items, &|item| bins.bin(item) <= last);
        if middle == 0 || middle == items.len() {
            // All are in one bin: any halves will do.
            let middle = items.len() / 2;
            let (left, right) = items.split_at_mut(middle);
            return [Part::new(left, first), Part::new(right, first + middle)];
        }
        let joined = |extents: &[Extent]| extents.iter().fold(Extent::EMPTY, |all, extent| all.joined(extent));
        let (left, right) = items.split_at_mut(middle);
        [
            Part { items: left, first, extent: joined(&extents[..=last]) },
            Part { items: right, first: first + middle, extent: joined(&extents[last + 1..]) },
        ]
    }
}

/// The largest distance of a point on the items' spheres from a center.
fn reach(items: &[Item], center: [f32; 3]) -> f32 {
    if items.len() > WORTH_HALVING {
        let (left, right) = items.split_at(items.len() / 2);
        let (left, right) = rayon::join(|| reach(left, center), || reach(right, center));
        return left.max(right);
    }
    items.iter().fold(0.0, |reach: f32, item| {
        let [x, y, z] = std::array::from_fn(|i| item.center[i] - center[i]);
        reach.max((x * x + y * y + z * z).sqrt() + item.radius)
    })
}

/// Build the nodes of a tree over items, the root first. The number of a leaf is the position of its item in the end.
pub(crate) fn build(items: &mut [Item]) -> Result<Vec<Node>, OutOfMemory> {
    if items.is_empty() {
        return Ok(Vec::new());
    }
    let mut pieces = build_pieces(Part::new(items, 0))?;
    if pieces.len() == 1 {
        return Ok(pieces.swap_remove(0));
    }
    let mut count = 0;
    let start = |piece: &Vec<Node>| (count, count += piece.len()).0;
    let starts: Vec<usize> = pieces.iter().map(start).collect();
    let node = |i: usize| {
        let piece = starts.partition_point(|&start| start <= i) - 1;
        pieces[piece][i - starts[piece]].moved(starts[piece] as u32)
    };
    par_collect((0..count).into_par_iter().map(node), TREE)
}

/// Build the nodes of a tree in pieces that several threads work on. Nodes are numbered from the first of their piece on.
fn build_pieces(part: Part<'_>) -> Result<Vec<Vec<Node>>, OutOfMemory> {
    if part.items.len() <= WORTH_A_THREAD {
        let mut nodes = with_capacity(part.items.len() / NODES_PER_ITEM, TREE)?;
        append(part, &mut nodes)?;
        return Ok(vec![nodes]);
    }
    let build = |part: Part<'_>| {
        let (bounds, leaf) = (part.bounds(), part.leaf());
        Ok((bounds, leaf, if leaf.is_some() { Vec::new() } else { build_pieces(part)? }))
    };
    let children: Result<Vec<_>, OutOfMemory> = eight_parts(part).into_par_iter().map(build).collect();
    let (mut root, mut pieces, mut next) = (Node::empty(), vec![Vec::new()], 1);
    for (i, (bounds, leaf, subtree)) in children?.into_iter().enumerate() {
        root.put(i, bounds, leaf.unwrap_or(next));
        next += subtree.iter().map(|piece| piece.len() as u32).sum::<u32>();
        pieces.extend(subtree);
    }
    pieces[0].push(root);
    Ok(pieces)
}

/// Append the nodes of a tree, the root first.
fn append(part: Part<'_>, nodes: &mut Vec<Node>) -> Result<(), OutOfMemory> {
    let number = nodes.len();
    reserve(nodes, 1, TREE)?;
    nodes.push(Node::empty());
    for (i, part) in eight_parts(part).into_iter().enumerate() {
        let leaf = part.leaf();
        let child = leaf.unwrap_or(nodes.len() as u32);
        nodes[number].put(i, part.bounds(), child);
        if leaf.is_none() {
            append(part, nodes)?;
        }
    }
    Ok(())
}

/// Cut items into at most eight parts, the one with the largest surface first.
///
/// Those that fill a node at most are not cut, but taken apart if there is room for their items.
fn eight_parts(part: Part<'_>) -> Vec<Part<'_>> {
    let mut parts = Vec::with_capacity(WIDTH);
    parts.push(part);
    while parts.len() < WIDTH {
        let largest = (0..parts.len())
            .filter(|&i| parts[i].items.len() > WIDTH)
            .max_by(|&a, &b| parts[a].extent.spheres.area().total_cmp(&parts[b].extent.spheres.area()));
        let Some(i) = largest else { break };
        let part = parts.swap_remove(i);
        parts.extend(part.cut());
    }
    while let Some(i) =
        (0..parts.len()).filter(|&i| parts[i].items.len() > 1).min_by_key(|&i| parts[i].items.len())
    {
        if parts.len() - 1 + parts[i].items.len() > WIDTH {
            break;
        }
        let part = parts.swap_remove(i);
        parts.extend(part.items.chunks_mut(1).zip(part.first..).map(|(item, first)| Part::new(item, first)));
    }
    parts
}

/// Equal intervals along the longest side of the box around the centres.
///
/// The surface area heuristic, in bins (I. Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies",
/// 2007): the cost of a cut is the sum over its parts of surface times count.
struct Bins {
    axis: usize,
    low: f32,
    per_length: f32,
}

impl Bins {
    fn along(centers: &Aabb) -> Bins {
        let size = centers.size();
        let axis = (0..3).fold(0, |a, b| if size[b] > size[a] { b } else { a });
        Bins { axis, low: centers.low[axis], per_length: BINS as f32 / size[axis] }
    }

    #[inline(always)]
    fn bin(&self, item: &Item) -> usize {
        let along = (item.center[self.axis] - self.low) * self.per_length;
        (along as usize).min(BINS - 1)
    }

    /// Return the extent of the items in each bin.
    fn fill(&self, items: &[Item]) -> [Extent; BINS] {
        if items.len() > WORTH_HALVING {
            let (left, right) = items.split_at(items.len() / 2);
            let (left, right) = rayon::join(|| self.fill(left), || self.fill(right));
            return std::array::from_fn(|i| left[i].joined(&right[i]));
        }
        let mut bins = [Extent::EMPTY; BINS];
        for item in items {
            let bin = &mut bins[self.bin(item)];
            *bin = bin.with(item);
        }
        bins
    }
}

/// Move the items of the left part to the front, and return their number.
pub(crate) fn partition(items: &mut [Item], is_left: &(impl Fn(&Item) -> bool + Sync)) -> usize {
    if items.len() > WORTH_HALVING {
        let middle = items.len() / 2;
        let (front, back) = items.split_at_mut(middle);
        let (front, back) = rayon::join(|| partition(front, is_left), || partition(back, is_left));
        // The right part of the front changes places with the left part of the back.
        let count = (middle - front).min(back);
        let (before, after) = items[front..middle + back].split_at_mut(middle - front);
        let start = after.len() - count;
        before[..count].swap_with_slice(&mut after[start..]);
        return front + back;
    }
    let mut middle = 0;
    for i in 0..items.len() {
        // Swapped in any case: a branch would be mispredicted half of the time. Asked before the swap, for whose stores
        // the next load would wait.
        let goes_left = is_left(&items[i]);
        items.swap(i, middle);
        middle += usize::from(goes_left);
    }
    middle
}

/// The last bin of the left part.
fn cheapest_cut(bins: &[Extent; BINS]) -> usize {
    let mut right_cost = [0.0; BINS];
    let mut right = Extent::EMPTY;
    for i in (1..BINS).rev() {
        right = right.joined(&bins[i]);
        right_cost[i] = right.cost();
    }
    let (mut best, mut cheapest) = (0, f64::INFINITY);
    let mut left = Extent::EMPTY;
    for i in 0..BINS - 1 {
        left = left.joined(&bins[i]);
        let total = left.cost() + right_cost[i + 1];
        if total < cheapest {
            (best, cheapest) = (i, total);
        }
    }
    best
}
