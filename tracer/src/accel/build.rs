//! Building the tree, by the surface area heuristic.
//!
//! A large list is first sorted into the cells of a grid, which are cut in place of the items: its upper levels go through
//! all items only for that. Subtrees are built side by side. All depends on the items alone: the tree is the same for any
//! number of threads.

use crate::accel::node::{LEAF, Node, WIDTH};
use crate::bounds::BoundingSphere;
use crate::memory::{OutOfMemory, collect, filled, par_collect, reserve, with_capacity};
use crate::vector::to_f32;
use rayon::prelude::*;

/// Named in the error if memory runs out.
pub(crate) const TREE: &str = "the tree over the objects";

/// Candidate positions of a cut along an axis.
const BINS: usize = 16;

/// A tree has about one node for this number of items, or fewer.
const ITEMS_PER_NODE: usize = 4;

/// Subtrees over more items than this begin with a grid, and are built by several threads.
const WORTH_A_THREAD: usize = 4096;

/// The least number of items in a cell, on average, and the most bits of its number.
const ITEMS_PER_CELL: usize = 64;
const MOST_BITS: u32 = 13;

/// Items that one thread goes through at a time.
const CHUNK: usize = 1 << 16;

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

    /// The largest distance of its corners from a point.
    fn reach(&self, point: [f32; 3]) -> f32 {
        let [x, y, z] = [0, 1, 2].map(|i| (point[i] - self.low[i]).max(self.high[i] - point[i]));
        (x * x + y * y + z * z).sqrt()
    }

    /// Half the surface area; 0 if empty.
    fn area(&self) -> f64 {
        let [x, y, z] = self.size().map(f64::from);
        if x >= 0.0 { x * y + y * z + z * x } else { 0.0 }
    }
}

/// What is put into bins.
trait Bounded: Sync {
    /// A coordinate of the center.
    fn center(&self, axis: usize) -> f32;

    fn extent(&self) -> Extent;
}

impl Bounded for Item {
    #[inline(always)]
    fn center(&self, axis: usize) -> f32 {
        self.center[axis]
    }

    #[inline(always)]
    fn extent(&self) -> Extent {
        let (spheres, centers) = (Aabb::around(self.center, self.radius), Aabb::around(self.center, 0.0));
        Extent { count: 1, spheres, centers }
    }
}

impl Bounded for Cell<'_> {
    fn center(&self, axis: usize) -> f32 {
        let Aabb { low, high } = self.extent.centers;
        (low[axis] + high[axis]) * 0.5
    }

    fn extent(&self) -> Extent {
        self.extent
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

    fn of<T: Bounded + Sync>(items: &[T]) -> Extent {
        let join = |extent: Extent, other: Extent| extent.joined(&other);
        let of_chunk = |items: &[T]| items.iter().map(T::extent).fold(Extent::EMPTY, join);
        if items.len() <= CHUNK {
            return of_chunk(items);
        }
        items.par_chunks(CHUNK).map(of_chunk).reduce(|| Extent::EMPTY, join)
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

/// The items of one cell of a grid, and the position of the first among all items.
struct Cell<'a> {
    items: &'a mut [Item],
    first: usize,
    extent: Extent,
}

/// The items of one child.
struct Part<'a, 'b> {
    contents: Contents<'a, 'b>,
    extent: Extent,
}

enum Contents<'a, 'b> {
    /// Items, and the position of the first among all items.
    Items(&'a mut [Item], usize),
    /// Those of some cells.
    Cells(&'a mut [Cell<'b>]),
}

impl<'a, 'b> Part<'a, 'b> {
    fn of_items(items: &'a mut [Item], first: usize) -> Part<'a, 'b> {
        Part { extent: Extent::of(items), contents: Contents::Items(items, first) }
    }

    fn of_cells(cells: &'a mut [Cell<'b>]) -> Part<'a, 'b> {
        Part { extent: Extent::of(cells), contents: Contents::Cells(cells) }
    }

    /// The number of a leaf, if there is a single item.
    fn leaf(&self) -> Option<u32> {
        let first = match &self.contents {
            Contents::Items(_, first) => *first,
            Contents::Cells(cells) => cells[0].first,
        };
        (self.extent.count == 1).then_some(LEAF | first as u32)
    }

    /// The bounding sphere of the items around the middle of their bounding box.
    fn bounds(&self) -> ([f32; 3], f32) {
        let Aabb { low, high } = self.extent.spheres;
        let center = [0, 1, 2].map(|i| {
            let middle = (low[i] + high[i]) * 0.5;
            // The box around an infinite sphere has no middle.
            if middle.is_finite() { middle } else { 0.0 }
        });
        match &self.contents {
            Contents::Items([item], _) => (item.center, item.radius),
            Contents::Items(items, _) => (center, reach(items, center)),
            Contents::Cells(cells) => {
                let reaches = cells.iter().map(|cell| match &*cell.items {
                    // Of a large tree, close enough.
                    _ if self.extent.count > WORTH_A_THREAD => cell.extent.spheres.reach(center),
                    items => reach(items, center),
                });
                (center, reaches.fold(0.0, f32::max))
            }
        }
    }

    /// Cut the items in two.
    fn cut(self) -> [Part<'a, 'b>; 2] {
        let extent = &self.extent;
        match self.contents {
            Contents::Items(items, first) => {
                let (middle, extents) = cut(items, extent);
                let (left, right) = items.split_at_mut(middle);
                let [left, right] = [Contents::Items(left, first), Contents::Items(right, first + middle)];
                [Part { contents: left, extent: extents[0] }, Part { contents: right, extent: extents[1] }]
            }
            Contents::Cells([cell]) => {
                Part { contents: Contents::Items(&mut *cell.items, cell.first), extent: cell.extent }.cut()
            }
            Contents::Cells(cells) => {
                let (middle, extents) = cut(cells, extent);
                let (left, right) = cells.split_at_mut(middle);
                let [left, right] = [Contents::Cells(left), Contents::Cells(right)];
                [Part { contents: left, extent: extents[0] }, Part { contents: right, extent: extents[1] }]
            }
        }
    }

    /// Return a part for each item.
    fn taken_apart(self) -> Vec<Part<'a, 'b>> {
        let singles = |items: &'a mut [Item], first: usize| {
            items.chunks_mut(1).zip(first..).map(|(item, first)| Part::of_items(item, first))
        };
        match self.contents {
            Contents::Items(items, first) => singles(items, first).collect(),
            Contents::Cells(cells) => {
                cells.iter_mut().flat_map(|cell| singles(&mut *cell.items, cell.first)).collect()
            }
        }
    }
}

/// The largest distance of a point on the items' spheres from a center.
fn reach(items: &[Item], center: [f32; 3]) -> f32 {
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
    let mut pieces = build_pieces(Part::of_items(items, 0))?;
    if pieces.len() == 1 {
        return Ok(pieces.swap_remove(0));
    }
    let (mut starts, mut count) = (Vec::new(), 0);
    for piece in &pieces {
        starts.push(count);
        count += piece.len();
    }
    let node = |i: usize| {
        let piece = starts.partition_point(|&start| start <= i) - 1;
        pieces[piece][i - starts[piece]].moved(starts[piece] as u32)
    };
    par_collect((0..count).into_par_iter().map(node), TREE)
}

/// Build the nodes of a tree in pieces that several threads work on. Nodes are numbered from the first of their piece on.
fn build_pieces(part: Part<'_, '_>) -> Result<Vec<Vec<Node>>, OutOfMemory> {
    if part.extent.count <= WORTH_A_THREAD {
        let mut nodes = with_capacity(part.extent.count / ITEMS_PER_NODE, TREE)?;
        append(part, &mut nodes)?;
        return Ok(vec![nodes]);
    }
    match part.contents {
        Contents::Items(items, first) => {
            let mut cells = into_cells(items, first, &part.extent)?;
            build_children(Part::of_cells(&mut cells))
        }
        Contents::Cells(_) => build_children(part),
    }
}

/// Build a root and the trees over its children side by side.
fn build_children(part: Part<'_, '_>) -> Result<Vec<Vec<Node>>, OutOfMemory> {
    let build = |part: Part<'_, '_>| {
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
fn append(part: Part<'_, '_>, nodes: &mut Vec<Node>) -> Result<(), OutOfMemory> {
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
fn eight_parts<'a, 'b>(part: Part<'a, 'b>) -> Vec<Part<'a, 'b>> {
    let mut parts = Vec::with_capacity(WIDTH);
    parts.push(part);
    while parts.len() < WIDTH {
        let largest = (0..parts.len())
            .filter(|&i| parts[i].extent.count > WIDTH)
            .max_by(|&a, &b| parts[a].extent.spheres.area().total_cmp(&parts[b].extent.spheres.area()));
        let Some(i) = largest else { break };
        let part = parts.swap_remove(i);
        parts.extend(part.cut());
    }
    while let Some(i) =
        (0..parts.len()).filter(|&i| parts[i].extent.count > 1).min_by_key(|&i| parts[i].extent.count)
    {
        if parts.len() - 1 + parts[i].extent.count > WIDTH {
            break;
        }
        let part = parts.swap_remove(i);
        parts.extend(part.taken_apart());
    }
    parts
}

/// Sort items into the cells of a grid, and return those cells that hold some.
///
/// A grid takes the place of the cuts of large lists, each of which goes through all items. It depends on the items alone,
/// and so do the chunks in which several threads sort them.
fn into_cells<'a>(items: &'a mut [Item], mut first: usize, extent: &Extent) -> Result<Vec<Cell<'a>>, OutOfMemory> {
    let grid = Grid::over(&extent.centers, items.len());
    let mut sorted = par_collect(items.par_iter().copied(), TREE)?;
    let chunks = sorted.par_chunks_mut(CHUNK).zip(items.par_chunks(CHUNK));
    let ends: Result<Vec<_>, OutOfMemory> = chunks.map(|(sorted, items)| grid.sort(items, sorted)).collect();
    let ends = ends?;
    // The part of a chunk in a cell.
    let run = |chunk: usize, cell: usize| {
        let start = if cell > 0 { ends[chunk][cell - 1] } else { 0 };
        &sorted[CHUNK * chunk..][start as usize..ends[chunk][cell] as usize]
    };
    let mut cells = with_capacity(grid.cells, TREE)?;
    let mut rest = items;
    for cell in 0..grid.cells {
        let count = (0..ends.len()).map(|chunk| run(chunk, cell).len()).sum();
        let items = rest.split_off_mut(..count).expect("the items of all cells");
        if count > 0 {
            cells.push((cell, Cell { items, first, extent: Extent::EMPTY }));
        }
        first += count;
    }
    let fill = |(number, mut cell): (usize, Cell<'a>)| {
        let mut start = 0;
        for chunk in 0..ends.len() {
            let run = run(chunk, number);
            cell.items[start..start + run.len()].copy_from_slice(run);
            start += run.len();
        }
        cell.extent = Extent::of(cell.items);
        cell
    };
    par_collect(cells.into_par_iter().map(fill), TREE)
}

/// A grid over the centers of items, whose cells are about as long as wide. Their order is a Morton curve: each bit of a
/// cell's number halves the part of space that the higher bits give.
///
/// Trees over cells of such a grid: J. Pantaleoni, D. Luebke, "HLBVH: Hierarchical LBVH Construction for Real-Time Ray
/// Tracing of Dynamic Geometry", 2010.
struct Grid {
    cells: usize,
    low: [f32; 3],
    per_length: [f32; 3],
    /// The bits of the cell's number for each place along an axis.
    places: [Vec<u32>; 3],
}

impl Grid {
    fn over(centers: &Aabb, count: usize) -> Grid {
        let bits = (count / ITEMS_PER_CELL).max(1).ilog2().min(MOST_BITS);
        let mut sides = centers.size();
        let mut places = [const { Vec::new() }; 3];
        places.iter_mut().for_each(|places| places.push(0));
        for bit in (0..bits).rev() {
            let axis = longest(sides);
            sides[axis] *= 0.5;
            places[axis] = places[axis].iter().flat_map(|&place| [place, place | 1 << bit]).collect();
        }
        let per_length = std::array::from_fn(|i| places[i].len() as f32 / centers.size()[i]);
        let low = std::array::from_fn(|i| centers.low[i]);
        Grid { cells: 1 << bits, low, per_length, places }
    }

    #[inline(always)]
    fn cell(&self, item: &Item) -> u32 {
        let bits: [u32; 3] = std::array::from_fn(|i| {
            let place = ((item.center[i] - self.low[i]) * self.per_length[i]) as usize;
            self.places[i][place.min(self.places[i].len() - 1)]
        });
        bits[0] | bits[1] | bits[2]
    }

    /// Sort items by their cells, and return where each cell ends.
    fn sort(&self, items: &[Item], sorted: &mut [Item]) -> Result<Vec<u32>, OutOfMemory> {
        let cells = collect(items.iter().map(|item| self.cell(item)), TREE)?;
        let mut ends = filled(self.cells, 0, TREE)?;
        cells.iter().for_each(|&cell| ends[cell as usize] += 1);
        let mut start = 0;
        for end in &mut ends {
            start += *end;
            *end = start - *end;
        }
        for (item, &cell) in items.iter().zip(&cells) {
            let next = &mut ends[cell as usize];
            sorted[*next as usize] = *item;
            *next += 1;
        }
        Ok(ends)
    }
}

/// Order items or cells so that a cut divides them, and return where it is and the extents of both parts.
fn cut<T: Bounded>(items: &mut [T], extent: &Extent) -> (usize, [Extent; 2]) {
    let bins = Bins::along(&extent.centers);
    let extents = bins.fill(items);
    let last = cheapest_cut(&extents);
    let middle = partition(items, |item| bins.bin(item) <= last);
    if middle == 0 || middle == items.len() {
        // All are in one bin: any halves will do.
        let (left, right) = items.split_at(items.len() / 2);
        return (left.len(), [Extent::of(left), Extent::of(right)]);
    }
    let joined = |extents: &[Extent]| extents.iter().fold(Extent::EMPTY, |all, extent| all.joined(extent));
    (middle, [joined(&extents[..=last]), joined(&extents[last + 1..])])
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
        let axis = longest(size);
        Bins { axis, low: centers.low[axis], per_length: BINS as f32 / size[axis] }
    }

    #[inline(always)]
    fn bin(&self, item: &impl Bounded) -> usize {
        let along = (item.center(self.axis) - self.low) * self.per_length;
        (along as usize).min(BINS - 1)
    }

    /// Return the extent of the items in each bin.
    fn fill(&self, items: &[impl Bounded]) -> [Extent; BINS] {
        let mut bins = [Extent::EMPTY; BINS];
        for item in items {
            let bin = &mut bins[self.bin(item)];
            *bin = bin.joined(&item.extent());
        }
        bins
    }
}

/// The longest of three sides.
fn longest(sides: [f32; 3]) -> usize {
    (0..3).fold(0, |a, b| if sides[b] > sides[a] { b } else { a })
}

/// Move the items of the left part to the front, and return their number.
pub(crate) fn partition<T>(items: &mut [T], is_left: impl Fn(&T) -> bool) -> usize {
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
