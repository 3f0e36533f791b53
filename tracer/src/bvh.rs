//! A tree of balls around the spheres and boxes of a scene, and the cones that walk it.
//!
//! Nodes have up to eight children, which are tested together; a child is a node or a single object. Bounds and
//! tests are float32 and generous by more than their rounding, so that what the kernel can hit is never left out:
//! the tree decides how fast a picture is, not what is in it.

use crate::budget::WorkMeter;
use crate::grid::Rays;
use crate::memory::{OutOfMemory, collect, push, reserve};
use crate::points::BoundingSphere;
use crate::scene::Shape;
use crate::vector::{add, dot, length, scale, sub, to_f32};
use crate::world::Vector;
use rayon::prelude::*;

/// What there may be not enough memory for.
const TREE: &str = "the tree over the objects";

/// Children of a node.
const WIDTH: usize = 8;

/// Of a child's number: it is an object.
const LEAF: u32 = 1 << 31;

/// Candidate places for a cut along an axis.
const BINS: usize = 16;

/// Above this many objects the parts of a tree are built by several threads.
const WORTH_A_THREAD: usize = 4096;

/// Rounding, here and in the kernel, is less than this share of the distances and sizes that come in.
const CONSERVATIVE: f32 = 2e-6;

#[derive(Clone, Debug)]
struct Node {
    /// Of each child: the ball around it. A missing child has a radius of -inf, which nothing meets.
    x: [f32; WIDTH],
    y: [f32; WIDTH],
    z: [f32; WIDTH],
    radius: [f32; WIDTH],
    child: [u32; WIDTH],
}

/// The tree; empty without objects.
#[derive(Clone, Debug)]
pub(crate) struct Bvh {
    nodes: Vec<Node>,
}

/// All that is seen from a point in the directions around an axis, up to a distance.
#[derive(Clone, Debug)]
pub(crate) struct Cone {
    apex: [f32; 3],
    /// Unit vector.
    axis: [f32; 3],
    cos: f32,
    sin: f32,
    /// Along the axis, what is nearer is in the cone.
    reach: f32,
    /// What rounding may do to the apex and the points.
    slack: f32,
}

impl Cone {
    /// The cone around the rays of a tile.
    pub(crate) fn of_tile(rays: &Rays) -> Cone {
        let (middle, reach) = (rays.middle, rays.reach);
        let axis = scale(middle, 1.0 / length(middle));
        let cos = CORNERS
            .map(|(i, j)| {
                let corner = [middle[0] + i * reach.0, middle[1] + j * reach.1, 1.0];
                dot(axis, corner) / length(corner)
            })
            .into_iter()
            .fold(1.0, f64::min);
        Cone::new([0.0; 3], axis, cos, f64::INFINITY)
    }

    /// The cone from an apex around a ball of points, up to its far end.
    ///
    /// `farthest` is how far they are from what they are relative to, which tells what float32 has taken from them.
    pub(crate) fn from_apex(apex: Vector, ball: BoundingSphere, farthest: f64) -> Cone {
        let toward = sub(ball.center, apex);
        let distance = length(toward);
        // sin = radius / distance; an apex in the ball sees it all around.
        let sin = ball.radius / distance;
        let cos = if sin < 1.0 { (1.0 - sin * sin).sqrt() } else { -1.0 };
        let reach = distance + ball.radius;
        let mut cone = Cone::new(apex, scale(toward, 1.0 / distance), cos, reach);
        cone.slack += farthest as f32 * CONSERVATIVE;
        cone
    }

    /// A cone of no length: it meets what its apex is in, or close to.
    pub(crate) fn around(apex: Vector, slack: f64) -> Cone {
        Cone {
            apex: to_f32(apex),
            axis: [0.0; 3],
            cos: 1.0,
            sin: 0.0,
            reach: 0.0,
            slack: length(apex) as f32 * CONSERVATIVE + slack as f32,
        }
    }

    fn new(apex: Vector, axis: Vector, cos: f64, reach: f64) -> Cone {
        // A wide cone is taken for all directions: it is not worth a test that holds for obtuse angles.
        let narrow = cos > 0.1;
        Cone {
            apex: to_f32(apex),
            axis: if narrow { to_f32(axis) } else { [0.0; 3] },
            cos: if narrow { cos as f32 } else { 0.0 },
            sin: if narrow {
                (1.0 - cos * cos).max(0.0).sqrt() as f32
            } else {
                0.0
            },
            reach: reach as f32 * (1.0 + CONSERVATIVE),
            slack: length(apex) as f32 * CONSERVATIVE,
        }
    }

    /// How far along the axis lies what the rays of a tile meet at a depth, at most.
    #[inline(always)]
    pub(crate) fn along_axis(&self, rays: &Rays, depth: f32) -> f32 {
        let [x, y, _] = to_f32(rays.middle);
        let (right, up) = (rays.reach.0 as f32, rays.reach.1 as f32);
        // v . axis is largest at a corner.
        let [ax, ay, az] = self.axis;
        let largest = ax * x + ay * y + az + right * ax.abs() + up * ay.abs();
        // Infinite times 0, of a wide cone: no limit.
        if depth < f32::INFINITY {
            depth * largest * (1.0 + CONSERVATIVE)
        } else {
            depth
        }
    }

    /// How far along the axis each child of a node begins, and, byte by byte, which of them the cone meets.
    ///
    /// A ball at distance d along the axis and p from it is met if p cos <= R + d sin: its centre is no farther
    /// than R from the cone's surface. Squared, for roots are slow.
    #[inline(always)]
    fn intersect(&self, node: &Node, limit: f32) -> ([f32; WIDTH], u64) {
        let mut near = [0.0; WIDTH];
        let mut met = [0_u8; WIDTH];
        let [ax, ay, az] = self.axis;
        for i in 0..WIDTH {
            let (x, y, z) = (
                node.x[i] - self.apex[0],
                node.y[i] - self.apex[1],
                node.z[i] - self.apex[2],
            );
            let d = x * ax + y * ay + z * az;
            let (px, py, pz) = (x - d * ax, y - d * ay, z - d * az);
            let pp = px * px + py * py + pz * pz;
            let radius = node.radius[i] + (self.slack + CONSERVATIVE * (x.abs() + y.abs() + z.abs()));
            let room = radius + d * self.sin;
            // No child begins behind the apex; so its bits can be compared as an integer's.
            near[i] = if d > radius { d - radius } else { 0.0 };
            let hit =
                (room >= 0.0) & (pp * (self.cos * self.cos) <= room * room) & (d >= -radius) & (near[i] <= limit);
            met[i] = u8::from(hit);
        }
        (near, u64::from_le_bytes(met))
    }
}

const CORNERS: [(f64, f64); 4] = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];

impl Bvh {
    /// The tree over the spheres and boxes among shapes.
    ///
    /// # Errors
    ///
    /// If there is not enough memory for it.
    pub(crate) fn new(shapes: &[Shape]) -> Result<Bvh, OutOfMemory> {
        let items = shapes.iter().enumerate().filter_map(|(i, shape)| {
            Some(Item {
                ball: ball_around(shape)?,
                object: i as u32,
            })
        });
        let mut items = collect(items, TREE)?;
        let mut nodes = Vec::new();
        if !items.is_empty() {
            build(Part::new(&mut items), &mut nodes)?;
        }
        Ok(Bvh { nodes })
    }

    /// Start a walk through what a cone may meet.
    #[inline(always)]
    pub(crate) fn traverse<'a>(&'a self, cone: &'a Cone, stack: &'a mut Stack) -> Traversal<'a> {
        stack.waiting.clear();
        Traversal {
            nodes: &self.nodes,
            cone,
            next: if self.nodes.is_empty() { DONE } else { 0 },
            stack,
        }
    }
}

/// What is kept from walk to walk.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stack {
    /// What waits to be visited: the distance along the cone's axis where it begins, as bits, and below it its number.
    waiting: Vec<u64>,
    /// Counts the steps of all walks; once they run out, walks end at once.
    pub(crate) meter: WorkMeter,
    /// The steps that an object takes which is walked to.
    pub(crate) steps_per_object: u64,
}

/// Comes after all that waits.
const DONE: u64 = u64::MAX;

/// A walk through a tree, roughly from near to far.
#[derive(Debug)]
pub(crate) struct Traversal<'a> {
    nodes: &'a [Node],
    cone: &'a Cone,
    /// What comes next, or `DONE`.
    next: u64,
    /// What comes then, the nearest last.
    stack: &'a mut Stack,
}

impl Traversal<'_> {
    /// The next object, unless all that is left begins beyond a distance along the cone's axis.
    #[inline(always)]
    pub(crate) fn next(&mut self, limit: f32) -> Option<u32> {
        let limit = limit.min(self.cone.reach);
        // Counted here and told the meter at once: it is looked at for objects only.
        let mut opened = 0;
        loop {
            let next = self.next;
            if next == DONE {
                self.stack.meter.take(opened);
                return None;
            }
            let number = next as u32;
            if (next >> 32) as u32 > limit.to_bits() {
                self.next = self.stack.waiting.pop().unwrap_or(DONE);
            } else if number & LEAF != 0 {
                self.next = self.stack.waiting.pop().unwrap_or(DONE);
                let may = self.stack.meter.take(opened + self.stack.steps_per_object);
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
        let (near, mut met) = self.cone.intersect(node, limit);
        let mut found = [0; WIDTH];
        let mut count = 0;
        while met != 0 {
            let i = met.trailing_zeros() as usize / 8 % WIDTH;
            met &= met - 1;
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

fn ball_around(shape: &Shape) -> Option<BoundingSphere> {
    match shape {
        Shape::Sphere(sphere) => Some(BoundingSphere {
            center: sphere.center,
            radius: sphere.radius,
        }),
        Shape::Cuboid(cuboid) => Some(BoundingSphere {
            center: cuboid.center,
            radius: cuboid.bounding_radius(),
        }),
        Shape::Plane(_) => None,
    }
}

/// An object on its way into the tree.
#[derive(Clone, Copy, Debug)]
struct Item {
    ball: BoundingSphere,
    object: u32,
}

/// An axis-aligned box around balls.
#[derive(Clone, Copy, Debug)]
struct Extent {
    low: Vector,
    high: Vector,
}

impl Extent {
    const NONE: Extent = Extent {
        low: [f64::INFINITY; 3],
        high: [f64::NEG_INFINITY; 3],
    };

    #[inline(always)]
    fn with(self, center: Vector, radius: f64) -> Extent {
        self.joined(&Extent {
            low: center.map(|c| c - radius),
            high: center.map(|c| c + radius),
        })
    }

    #[inline(always)]
    fn joined(&self, other: &Extent) -> Extent {
        let lower = |a: f64, b: f64| if b < a { b } else { a };
        let higher = |a: f64, b: f64| if b > a { b } else { a };
        Extent {
            low: std::array::from_fn(|i| lower(self.low[i], other.low[i])),
            high: std::array::from_fn(|i| higher(self.high[i], other.high[i])),
        }
    }

    /// Half its surface; 0 of nothing.
    fn area(&self) -> f64 {
        let [x, y, z] = sub(self.high, self.low);
        if x >= 0.0 { x * y + y * z + z * x } else { 0.0 }
    }
}

/// Items that share a child, and their extent.
struct Part<'a> {
    items: &'a mut [Item],
    extent: Extent,
}

impl<'a> Part<'a> {
    fn new(items: &'a mut [Item]) -> Part<'a> {
        let extent = items.iter().fold(Extent::NONE, |extent, item| {
            extent.with(item.ball.center, item.ball.radius)
        });
        Part { items, extent }
    }

    /// The ball around the items: around the middle of their extent, as large as they need.
    fn ball(&self) -> BoundingSphere {
        if let [item] = &*self.items {
            return item.ball;
        }
        let center = scale(add(self.extent.low, self.extent.high), 0.5);
        let radius = self.items.iter().fold(0.0, |radius: f64, item| {
            radius.max(length(sub(item.ball.center, center)) + item.ball.radius)
        });
        BoundingSphere { center, radius }
    }
}

/// Append the nodes of a tree over items, the root first.
fn build(part: Part<'_>, nodes: &mut Vec<Node>) -> Result<(), OutOfMemory> {
    let place = nodes.len();
    push(nodes, Node::empty(), TREE)?;
    let large = part.items.len() > WORTH_A_THREAD;
    let parts = eight_parts(part);
    for (i, part) in parts.iter().enumerate() {
        let ball = part.ball();
        let node = &mut nodes[place];
        [node.x[i], node.y[i], node.z[i]] = to_f32(ball.center);
        node.radius[i] =
            (ball.radius + length(ball.center) * f64::from(CONSERVATIVE)) as f32 * (1.0 + CONSERVATIVE);
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
                nodes[place].child[i] = begin;
            }
            reserve(nodes, subtree.len(), TREE)?;
            nodes.extend(subtree.into_iter().map(|node| node.moved(begin)));
        }
        return Ok(());
    }
    for (i, part) in parts.into_iter().enumerate() {
        if part.items.len() > 1 {
            nodes[place].child[i] = nodes.len() as u32;
            build(part, nodes)?;
        }
    }
    Ok(())
}

impl Node {
    fn empty() -> Node {
        Node {
            x: [0.0; WIDTH],
            y: [0.0; WIDTH],
            z: [0.0; WIDTH],
            radius: [f32::NEG_INFINITY; WIDTH],
            child: [0; WIDTH],
        }
    }

    /// The node in a list where its tree begins later.
    fn moved(mut self, shift: u32) -> Node {
        for child in &mut self.child {
            if *child & LEAF == 0 {
                *child += shift;
            }
        }
        self
    }
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
    let centers = items
        .iter()
        .fold(Extent::NONE, |extent, item| extent.with(item.ball.center, 0.0));
    let size = sub(centers.high, centers.low);
    let axis = (0..3).fold(0, |a, b| if size[b] > size[a] { b } else { a });
    let per_size = BINS as f64 / size[axis];
    let bin = |item: &Item| {
        let place = (item.ball.center[axis] - centers.low[axis]) * per_size;
        (place as usize).min(BINS - 1)
    };
    let mut bins = [(0_usize, Extent::NONE); BINS];
    for item in items.iter() {
        let (count, extent) = &mut bins[bin(item)];
        *count += 1;
        *extent = extent.with(item.ball.center, item.ball.radius);
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
        // All in one bin: any halves will do.
        return items.len() / 2;
    }
    middle
}

/// The last bin of the left part.
fn cheapest_cut(bins: &[(usize, Extent); BINS]) -> usize {
    let joined = |a: (usize, Extent), b: &(usize, Extent)| (a.0 + b.0, a.1.joined(&b.1));
    let cost = |(count, extent): (usize, Extent)| count as f64 * extent.area();
    let mut right_cost = [0.0; BINS];
    let mut right = (0, Extent::NONE);
    for i in (1..BINS).rev() {
        right = joined(right, &bins[i]);
        right_cost[i] = cost(right);
    }
    let (mut best, mut cheapest) = (0, f64::INFINITY);
    let mut left = (0, Extent::NONE);
    for i in 0..BINS - 1 {
        left = joined(left, &bins[i]);
        let total = cost(left) + right_cost[i + 1];
        if total < cheapest {
            (best, cheapest) = (i, total);
        }
    }
    best
}

#[cfg(test)]
mod tests;
