//! A tree of balls around the spheres and boxes of a scene, and the cones that walk it.
//!
//! Nodes have up to eight children, which are tested together; a child is a node or a single object. Bounds are
//! float64 and the tests generous, so that what the kernel can hit is never left out: the tree decides how fast a
//! picture is, not what is in it.

use crate::points::Ball;
use crate::scene::Shape;
use crate::vector::{add, dot, length, scale, sub};
use crate::world::Vector;

/// Children of a node.
const WIDTH: usize = 8;

/// Of a child's number: it is an object.
const LEAF: u32 = 1 << 31;

/// Candidate places for a cut along an axis.
const BINS: usize = 16;

/// Above this many objects the halves of a tree are built by two threads.
const WORTH_A_THREAD: usize = 4096;

/// The kernel's float32 may hit what is missed by this share of its distance and size.
const GENEROUS: f64 = 1e-6;

#[derive(Clone, Debug)]
struct Node {
    /// Of each child: the ball around it. A missing child has a radius of -inf, which nothing meets.
    x: [f64; WIDTH],
    y: [f64; WIDTH],
    z: [f64; WIDTH],
    radius: [f64; WIDTH],
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
    apex: Vector,
    /// Unit vector.
    axis: Vector,
    cos: f64,
    sin: f64,
    /// Along the axis, what is nearer is in the cone.
    reach: f64,
}

impl Cone {
    /// The cone from the origin around the rays of a block: `reach` is half its side at distance 1.
    pub(crate) fn of_block(middle: Vector, reach: f64) -> Cone {
        let axis = scale(middle, 1.0 / length(middle));
        let cos = CORNERS
            .map(|(i, j)| {
                let corner = [middle[0] + i * reach, middle[1] + j * reach, 1.0];
                dot(axis, corner) / length(corner)
            })
            .into_iter()
            .fold(1.0, f64::min);
        Cone::new([0.0; 3], axis, cos, f64::INFINITY)
    }

    /// The cone from an apex around a ball, up to its far end.
    pub(crate) fn from_apex(apex: Vector, ball: Ball) -> Cone {
        let toward = sub(ball.center, apex);
        let distance = length(toward);
        // sin = radius / distance; an apex in the ball sees it all around.
        let sin = ball.radius / distance;
        let cos = if sin < 1.0 {
            (1.0 - sin * sin).sqrt()
        } else {
            -1.0
        };
        let reach = distance + ball.radius;
        Cone::new(apex, scale(toward, 1.0 / distance), cos, reach)
    }

    fn new(apex: Vector, axis: Vector, cos: f64, reach: f64) -> Cone {
        // A wide cone is taken for all directions: it is not worth a test that holds for obtuse angles.
        let wide = !(cos > 0.1);
        let axis = if wide { [0.0; 3] } else { axis };
        Cone {
            apex,
            axis,
            cos: if wide { 0.0 } else { cos },
            sin: if wide { 0.0 } else { (1.0 - cos * cos).max(0.0).sqrt() },
            reach,
        }
    }

    /// The largest v . axis of the rays of a block, which turns a depth into a distance along the axis.
    pub(crate) fn along_axis_per_depth(&self, middle: Vector, reach: f64) -> f64 {
        CORNERS
            .map(|(i, j)| dot(self.axis, [middle[0] + i * reach, middle[1] + j * reach, 1.0]))
            .into_iter()
            .fold(0.0, f64::max)
    }

    /// How far along the axis each child of a node begins, and whether the cone meets it.
    ///
    /// A ball at distance d along the axis and p from it is met if p cos - d sin <= R: its centre is no farther
    /// than R from the cone's surface.
    #[inline(always)]
    fn meet(&self, node: &Node) -> ([f64; WIDTH], [bool; WIDTH]) {
        let mut near = [0.0; WIDTH];
        let mut met = [false; WIDTH];
        for i in 0..WIDTH {
            let c = [
                node.x[i] - self.apex[0],
                node.y[i] - self.apex[1],
                node.z[i] - self.apex[2],
            ];
            let d = dot(c, self.axis);
            let cc = dot(c, c);
            let p2 = cc - d * d;
            let p = if p2 > 0.0 { p2.sqrt() } else { 0.0 };
            let radius = node.radius[i] + GENEROUS * (node.radius[i] + cc.sqrt());
            near[i] = d - radius;
            met[i] = (p * self.cos - d * self.sin <= radius) & (d >= -radius);
        }
        (near, met)
    }
}

const CORNERS: [(f64, f64); 4] = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];

impl Bvh {
    /// The tree over the spheres and boxes among shapes.
    pub(crate) fn new(shapes: &[Shape]) -> Bvh {
        let mut items: Vec<Item> = shapes
            .iter()
            .enumerate()
            .filter_map(|(i, shape)| Some(Item { ball: ball_around(shape)?, object: i as u32 }))
            .collect();
        let mut nodes = Vec::new();
        if !items.is_empty() {
            build(&mut items, &mut nodes);
        }
        Bvh { nodes }
    }

    /// Start a walk through what a cone may meet.
    #[inline(always)]
    pub(crate) fn walk<'a>(&'a self, cone: &'a Cone, stack: &'a mut Stack) -> Walk<'a> {
        stack.0.clear();
        if !self.nodes.is_empty() {
            stack.0.push((f64::NEG_INFINITY, 0));
        }
        Walk {
            nodes: &self.nodes,
            cone,
            stack,
        }
    }
}

/// What waits to be visited in a walk: where it begins along the cone's axis, and its number. Kept from walk to walk.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stack(Vec<(f64, u32)>);

/// A walk through a tree, roughly from near to far.
#[derive(Debug)]
pub(crate) struct Walk<'a> {
    nodes: &'a [Node],
    cone: &'a Cone,
    stack: &'a mut Stack,
}

impl Walk<'_> {
    /// The next object, unless all that is left begins beyond a distance along the cone's axis.
    #[inline(always)]
    pub(crate) fn next(&mut self, limit: f64) -> Option<u32> {
        let limit = limit.min(self.cone.reach);
        while let Some((begin, number)) = self.stack.0.pop() {
            if begin > limit {
                continue;
            }
            if number & LEAF != 0 {
                return Some(number & !LEAF);
            }
            self.open(&self.nodes[number as usize], limit);
        }
        None
    }

    /// Put the children of a node on the stack, the nearest last, where it is popped first.
    #[inline(always)]
    fn open(&mut self, node: &Node, limit: f64) {
        let (near, met) = self.cone.meet(node);
        let stack = &mut self.stack.0;
        let first = stack.len();
        for i in 0..WIDTH {
            if met[i] && near[i] <= limit {
                stack.push((near[i], node.child[i]));
                let mut j = stack.len() - 1;
                while j > first && stack[j - 1].0 < stack[j].0 {
                    stack.swap(j - 1, j);
                    j -= 1;
                }
            }
        }
    }
}

fn ball_around(shape: &Shape) -> Option<Ball> {
    match shape {
        Shape::Sphere(sphere) => Some(Ball {
            center: sphere.center,
            radius: sphere.radius,
        }),
        Shape::Cuboid(cuboid) => Some(Ball {
            center: cuboid.center,
            radius: cuboid.bounding_radius(),
        }),
        Shape::Plane(_) => None,
    }
}

/// An object on its way into the tree.
#[derive(Clone, Copy, Debug)]
struct Item {
    ball: Ball,
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

    fn with(mut self, ball: &Ball) -> Extent {
        for i in 0..3 {
            self.low[i] = self.low[i].min(ball.center[i] - ball.radius);
            self.high[i] = self.high[i].max(ball.center[i] + ball.radius);
        }
        self
    }

    fn of(items: &[Item]) -> Extent {
        items
            .iter()
            .fold(Extent::NONE, |extent, item| extent.with(&item.ball))
    }

    fn joined(mut self, other: &Extent) -> Extent {
        for i in 0..3 {
            self.low[i] = self.low[i].min(other.low[i]);
            self.high[i] = self.high[i].max(other.high[i]);
        }
        self
    }

    /// Half its surface.
    fn area(&self) -> f64 {
        let [x, y, z] = sub(self.high, self.low);
        x * y + y * z + z * x
    }
}

/// The ball around items: around the middle of their extent, as large as they need.
fn ball_around_items(items: &[Item]) -> Ball {
    if let [item] = items {
        return item.ball;
    }
    let extent = Extent::of(items);
    let center = scale(add(extent.low, extent.high), 0.5);
    let radius = items.iter().fold(0.0, |radius: f64, item| {
        radius.max(length(sub(item.ball.center, center)) + item.ball.radius)
    });
    Ball { center, radius }
}

/// Append the nodes of a tree over items, the root first.
fn build(items: &mut [Item], nodes: &mut Vec<Node>) {
    let place = nodes.len();
    let mut node = Node {
        x: [0.0; WIDTH],
        y: [0.0; WIDTH],
        z: [0.0; WIDTH],
        radius: [f64::NEG_INFINITY; WIDTH],
        child: [0; WIDTH],
    };
    nodes.push(node.clone());
    let mut parts = eight_parts(items);
    let subtrees = build_all(&mut parts);
    for (i, (part, subtree)) in parts.iter().zip(subtrees).enumerate() {
        let ball = ball_around_items(part);
        [node.x[i], node.y[i], node.z[i]] = ball.center;
        node.radius[i] = ball.radius;
        node.child[i] = match part {
            [item] => LEAF | item.object,
            _ => nodes.len() as u32,
        };
        let shift = nodes.len() as u32;
        nodes.extend(subtree.into_iter().map(|node| node.moved(shift)));
    }
    nodes[place] = node;
}

impl Node {
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

/// The trees over parts; those of single items are empty.
fn build_all(parts: &mut [&mut [Item]]) -> Vec<Vec<Node>> {
    if parts.len() > 1 && parts.iter().map(|part| part.len()).sum::<usize>() > WORTH_A_THREAD {
        let (left, right) = parts.split_at_mut(parts.len() / 2);
        let (mut first, second) = rayon::join(|| build_all(left), || build_all(right));
        first.extend(second);
        return first;
    }
    parts
        .iter_mut()
        .map(|part| {
            let mut nodes = Vec::new();
            if part.len() > 1 {
                build(part, &mut nodes);
            }
            nodes
        })
        .collect()
}

/// Cut items into at most eight parts, the one with the largest surface first.
fn eight_parts(items: &mut [Item]) -> Vec<&mut [Item]> {
    let mut parts = vec![items];
    while parts.len() < WIDTH {
        let largest = (0..parts.len())
            .filter(|&i| parts[i].len() > 1)
            .map(|i| (Extent::of(parts[i]).area(), i))
            .max_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, i)) = largest else { break };
        let part = parts.swap_remove(i);
        let middle = cut(part);
        let (left, right) = part.split_at_mut(middle);
        parts.push(left);
        parts.push(right);
    }
    parts
}

/// Sort items into two parts and return where the second begins.
///
/// The surface area heuristic, in bins (I. Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies",
/// 2007): the cost of a cut is the sum over its parts of surface times count.
fn cut(items: &mut [Item]) -> usize {
    let centers = items.iter().fold(Extent::NONE, |extent, item| {
        extent.with(&Ball {
            center: item.ball.center,
            radius: 0.0,
        })
    });
    let size = sub(centers.high, centers.low);
    let axis = (0..3).fold(0, |a, b| if size[b] > size[a] { b } else { a });
    let bin = |item: &Item| {
        let place = (item.ball.center[axis] - centers.low[axis]) / size[axis];
        ((place * BINS as f64) as usize).min(BINS - 1)
    };
    let mut bins = [(0_usize, Extent::NONE); BINS];
    for item in items.iter() {
        let (count, extent) = &mut bins[bin(item)];
        *count += 1;
        *extent = extent.with(&item.ball);
    }
    let best = cheapest_cut(&bins);
    let mut middle = 0;
    for i in 0..items.len() {
        if bin(&items[i]) <= best {
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
    let cost_of = |bins: &[(usize, Extent)]| {
        let (count, extent) = bins.iter().fold((0, Extent::NONE), |(n, a), (m, b)| {
            (n + m, a.joined(b))
        });
        if count == 0 { 0.0 } else { extent.area() * count as f64 }
    };
    let costs = (0..BINS - 1).map(|i| (cost_of(&bins[..=i]) + cost_of(&bins[i + 1..]), i));
    costs.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0, |(_, i)| i)
}
