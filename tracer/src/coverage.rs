//! How many pixels each object would cover if it were alone.
//!
//! What the eye sees of a sphere, a plane or a box fills a convex cone of directions. So rays through the corners of a
//! rectangle of the image plane tell of all rays between them: if all four are in the cone, all others are. An object
//! is looked for in ever smaller squares of tiles, and only the tiles on its outline are tested ray by ray, as the
//! picture is: the work grows with the outline and not with the area.
//!
//! Rectangles end at the edges of pixels and rays go through their centres: half a pixel is more than what rounding
//! makes of the difference between this, in float64, and the kernel.

use crate::budget::{WorkMeter, steps_of};
use crate::cuboid::Cuboid;
use crate::grid::{HitBuffer, LANES, NO_FACE, Rays, SIDE};
use crate::plane::Plane;
use crate::render::Monitor;
use crate::scene::Shape;
use crate::simd::Kernel;
use crate::sphere::Sphere;
use crate::tile::{Tile, View};
use crate::vector::{add, cross, dot, length, rotate, scale, sub};
use crate::world::{Vector, Window};

/// The steps of one tile's test: to generate the rays, to test them, and to count.
const TILE_STEPS: u64 = 2 * steps_of(LANES);

/// The place in a pixel where it is decided what it shows.
const CENTRE: (f64, f64) = (0.5, 0.5);

/// Counts the pixels that some shapes cover.
pub(crate) struct Coverage<'a> {
    pub(crate) shapes: &'a [Shape],
    pub(crate) view: View,
    pub(crate) window: Window,
    pub(crate) monitor: &'a Monitor,
    /// Of each shape.
    pub(crate) covered: &'a mut [u64],
}

impl Kernel for Coverage<'_> {
    #[inline(always)]
    fn run(self) {
        let mut search = Search {
            view: self.view,
            window: self.window,
            rays: Rays::new(),
            hits: HitBuffer::new(),
            waiting: Vec::new(),
        };
        for (shape, covered) in self.shapes.iter().zip(self.covered) {
            if self.monitor.stopped() {
                return;
            }
            let mut meter = self.monitor.budget().meter();
            *covered = search.count(shape, &mut meter, || self.monitor.cancelled());
            self.monitor.budget().spend(meter);
        }
    }
}

/// A search through the tiles of a window.
struct Search {
    view: View,
    window: Window,
    rays: Rays,
    hits: HitBuffer,
    /// The squares that are yet to be looked at.
    waiting: Vec<Square>,
}

/// A square of tiles, a power of two of them in each row.
#[derive(Clone, Copy)]
struct Square {
    /// Its first column and row, pixels.
    corner: (u32, u32),
    /// Its width and height, pixels.
    side: u32,
}

impl Search {
    /// Count the pixels of a shape.
    #[inline(always)]
    fn count(&mut self, shape: &Shape, meter: &mut WorkMeter, cancelled: impl Fn() -> bool) -> u64 {
        let outline = Outline::new(shape);
        let mut covered = 0;
        self.waiting.clear();
        self.waiting.push(self.all());
        while let Some(square) = self.waiting.pop() {
            if !meter.take(1) || cancelled() {
                return 0;
            }
            let Some(part) = self.wanted(square) else { continue };
            match outline.in_rectangle(&self.rectangle(part)) {
                Share::Nothing => {}
                Share::All => covered += u64::from(part.width) * u64::from(part.height),
                Share::Some if square.side == SIDE => {
                    if !meter.take(TILE_STEPS) {
                        return 0;
                    }
                    covered += self.count_tile(shape, square.corner);
                }
                Share::Some => {
                    let (x, y) = square.corner;
                    let side = square.side / 2;
                    for corner in [(x, y), (x + side, y), (x, y + side), (x + side, y + side)] {
                        self.waiting.push(Square { corner, side });
                    }
                }
            }
        }
        covered
    }

    /// A square around the window.
    fn all(&self) -> Square {
        let Window { x, y, width, height } = self.window;
        let corner = (x - x % SIDE, y - y % SIDE);
        let longest = (x + width - corner.0).max(y + height - corner.1);
        let side = SIDE * longest.div_ceil(SIDE).next_power_of_two();
        Square { corner, side }
    }

    /// The part of a square that is in the window.
    fn wanted(&self, square: Square) -> Option<Window> {
        let Window { x, y, width, height } = self.window;
        let (left, top) = (square.corner.0.max(x), square.corner.1.max(y));
        let right = (square.corner.0 + square.side).min(x + width);
        let bottom = (square.corner.1 + square.side).min(y + height);
        (left < right && top < bottom).then(|| Window {
            x: left,
            y: top,
            width: right - left,
            height: bottom - top,
        })
    }

    /// What some pixels are on the image plane (document, section 2.1).
    fn rectangle(&self, part: Window) -> Rectangle {
        let (half_width, half_height) = self.view.half_pixel;
        let (width, height) = (f64::from(self.view.width), f64::from(self.view.height));
        let x = |column: u32| (2.0 * f64::from(column) - width) * half_width;
        let y = |row: u32| (height - 2.0 * f64::from(row)) * half_height;
        Rectangle {
            low: [x(part.x), y(part.y + part.height)],
            high: [x(part.x + part.width), y(part.y)],
            half_pixel: [half_width, half_height],
        }
    }

    /// Test the rays of a tile.
    #[inline(always)]
    fn count_tile(&mut self, shape: &Shape, corner: (u32, u32)) -> u64 {
        let tile = Tile {
            view: self.view,
            corner,
            window: self.window,
        };
        self.rays.generate(self.view, corner, CENTRE);
        self.hits.clear(&self.rays);
        shape.intersect(0, &self.rays, &mut self.hits);
        let mut met = 0;
        for span in tile.spans() {
            for face in &self.hits.face[span.lane..span.lane + span.count] {
                met += u64::from(*face != NO_FACE);
            }
        }
        met
    }
}

/// How much of a rectangle a shape covers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Share {
    Nothing,
    /// Perhaps nothing or all: the rays have to be tested.
    Some,
    All,
}

/// A rectangle of the image plane: the rays v = (x, y, 1).
#[derive(Clone, Copy, Debug)]
struct Rectangle {
    low: [f64; 2],
    high: [f64; 2],
    half_pixel: [f64; 2],
}

impl Rectangle {
    /// The rays through its corners.
    fn corners(&self) -> [Vector; 4] {
        let ([left, bottom], [right, top]) = (self.low, self.high);
        [
            [left, bottom, 1.0],
            [right, bottom, 1.0],
            [left, top, 1.0],
            [right, top, 1.0],
        ]
    }

    /// The ray through its middle.
    fn middle(&self) -> Vector {
        [
            (self.low[0] + self.high[0]) / 2.0,
            (self.low[1] + self.high[1]) / 2.0,
            1.0,
        ]
    }

    /// The smallest value of n . v.
    fn least(&self, n: Vector) -> f64 {
        let end = |axis: usize| if n[axis] > 0.0 { self.low[axis] } else { self.high[axis] };
        n[0] * end(0) + n[1] * end(1) + n[2]
    }

    /// Whether n . v < 0 for all rays, and for those half a pixel beside them.
    fn is_beyond(&self, n: Vector) -> bool {
        let beside = n[0].abs() * self.half_pixel[0] + n[1].abs() * self.half_pixel[1];
        -self.least([-n[0], -n[1], -n[2]]) + beside < 0.0
    }

    /// The largest |v|.
    fn longest(&self) -> f64 {
        let extent = |axis: usize| self.low[axis].abs().max(self.high[axis].abs());
        length([extent(0), extent(1), 1.0])
    }
}

/// The cone of directions in which a shape is seen.
enum Outline {
    /// The eye is well inside.
    Everywhere,
    Ball(BallOutline),
    Box(BoxOutline),
    Plane(PlaneOutline),
    /// The eye is on the surface, within rounding, or a size is beyond what the kernel is sure to meet.
    Unknown,
}

/// What is this near to a surface, as a share of the size, may be inside or outside.
const NEAR: f64 = 1e-6;

/// Lengths of the scene between which the kernel overflows nowhere.
const USUAL: std::ops::Range<f64> = 1e-12..1e12;

impl Outline {
    fn new(shape: &Shape) -> Outline {
        match shape {
            Shape::Sphere(sphere) => BallOutline::of(sphere),
            Shape::Plane(plane) => PlaneOutline::of(plane),
            Shape::Cuboid(cuboid) => BoxOutline::of(cuboid),
        }
    }

    fn in_rectangle(&self, rectangle: &Rectangle) -> Share {
        match self {
            Outline::Everywhere => Share::All,
            Outline::Ball(ball) => ball.in_rectangle(rectangle),
            Outline::Box(cuboid) => cuboid.in_rectangle(rectangle),
            Outline::Plane(plane) => plane.in_rectangle(rectangle),
            Outline::Unknown => Share::Some,
        }
    }
}

/// A sphere is seen within an angle around its centre, whose sine is radius over distance.
struct BallOutline {
    /// The unit vector to the centre.
    axis: Vector,
    sine: f64,
    cosine: f64,
}

impl BallOutline {
    fn of(sphere: &Sphere) -> Outline {
        let distance = length(sphere.center);
        let sine = sphere.radius / distance;
        let usual = USUAL.contains(&sphere.radius) && distance < USUAL.end;
        if usual && sine > 1.0 + NEAR {
            return Outline::Everywhere;
        }
        if usual && sine < 1.0 - NEAR {
            return Outline::Ball(BallOutline {
                axis: scale(sphere.center, 1.0 / distance),
                sine,
                cosine: (1.0 - sine * sine).sqrt(),
            });
        }
        Outline::Unknown
    }

    fn in_rectangle(&self, rectangle: &Rectangle) -> Share {
        // The plane through the eye that touches the sphere where the rectangle is: n = sine axis - cosine side.
        let middle = rectangle.middle();
        let side = sub(middle, scale(self.axis, dot(self.axis, middle)));
        let away = length(side);
        if away > 0.0 {
            let touching = sub(scale(self.axis, self.sine), scale(side, self.cosine / away));
            if rectangle.is_beyond(touching) {
                return Share::Nothing;
            }
        }
        // |axis x v| <= sine |v|, on the side of the axis.
        let inside = |v: Vector| {
            let across = cross(self.axis, v);
            dot(self.axis, v) > 0.0 && dot(across, across) <= self.sine * self.sine * dot(v, v)
        };
        if rectangle.corners().into_iter().all(inside) {
            Share::All
        } else {
            Share::Some
        }
    }
}

/// A plane is seen where n . v > 0, the normal pointing away from the eye.
struct PlaneOutline {
    normal: Vector,
}

/// The kernel takes rays for parallel to a plane below half of this sine of the angle between them.
const NOT_PARALLEL: f64 = 2e-6;

impl PlaneOutline {
    fn of(plane: &Plane) -> Outline {
        let away = plane.offset.signum();
        if USUAL.contains(&plane.offset.abs()) {
            Outline::Plane(PlaneOutline {
                normal: scale(plane.normal, away),
            })
        } else {
            Outline::Unknown
        }
    }

    fn in_rectangle(&self, rectangle: &Rectangle) -> Share {
        if rectangle.is_beyond(self.normal) {
            Share::Nothing
        } else if rectangle.least(self.normal) > NOT_PARALLEL * rectangle.longest() {
            Share::All
        } else {
            Share::Some
        }
    }
}

/// A box is seen between planes through the eye and those of its edges that make its outline.
struct BoxOutline {
    /// Normals of these planes, towards the box.
    sides: Vec<Vector>,
    /// The eye from its centre, along its axes.
    eye: Vector,
    axes: [Vector; 3],
    half: Vector,
}

impl BoxOutline {
    fn of(cuboid: &Cuboid) -> Outline {
        let Cuboid { center, axes, half, .. } = *cuboid;
        let eye = rotate(&axes, scale(center, -1.0));
        let usual = half.iter().all(|h| USUAL.contains(h)) && length(center) < USUAL.end;
        // How far the eye is beyond the face that it is beyond the most, in half sizes.
        let beyond = (0..3).fold(f64::NEG_INFINITY, |most, i| most.max(eye[i].abs() / half[i]));
        if usual && beyond < 1.0 - NEAR {
            return Outline::Everywhere;
        }
        if usual && beyond > 1.0 + NEAR {
            return Outline::Box(BoxOutline {
                sides: outline_planes(&corners(cuboid)),
                eye,
                axes,
                half,
            });
        }
        Outline::Unknown
    }

    fn in_rectangle(&self, rectangle: &Rectangle) -> Share {
        if self.sides.iter().any(|&side| rectangle.is_beyond(side)) {
            Share::Nothing
        } else if rectangle.corners().into_iter().all(|v| self.is_met(v)) {
            Share::All
        } else {
            Share::Some
        }
    }

    /// Whether a ray is between all pairs of faces at once, before the eye.
    fn is_met(&self, v: Vector) -> bool {
        let v = rotate(&self.axes, v);
        let (mut enter, mut leave) = (0.0, f64::INFINITY);
        for i in 0..3 {
            let (a, b) = (
                (-self.half[i] - self.eye[i]) / v[i],
                (self.half[i] - self.eye[i]) / v[i],
            );
            let (near, far) = if a < b { (a, b) } else { (b, a) };
            // Also where one is NaN, of a ray in a face.
            if !(near <= leave && far >= enter) {
                return false;
            }
            enter = near.max(enter);
            leave = far.min(leave);
        }
        enter <= leave
    }
}

/// The corners of a box; those of an edge differ by one bit of their numbers.
fn corners(cuboid: &Cuboid) -> [Vector; 8] {
    std::array::from_fn(|number| {
        (0..3).fold(cuboid.center, |corner, i| {
            let half = if number >> i & 1 == 0 {
                -cuboid.half[i]
            } else {
                cuboid.half[i]
            };
            add(corner, scale(cuboid.axes[i], half))
        })
    })
}

/// The planes through the eye and an edge that have all corners of a box on one side.
fn outline_planes(corners: &[Vector; 8]) -> Vec<Vector> {
    let mut planes = Vec::with_capacity(6);
    for first in 0..8 {
        for bit in [1, 2, 4] {
            let second = first | bit;
            if second == first {
                continue;
            }
            let normal = cross(corners[first], corners[second]);
            let side = |i: usize| {
                if i == first || i == second {
                    0.0
                } else {
                    dot(normal, corners[i])
                }
            };
            let (mut low, mut high) = (0.0_f64, 0.0_f64);
            for i in 0..8 {
                low = low.min(side(i));
                high = high.max(side(i));
            }
            if low >= 0.0 && high > 0.0 {
                planes.push(normal);
            } else if high <= 0.0 && low < 0.0 {
                planes.push(scale(normal, -1.0));
            }
        }
    }
    planes
}

#[cfg(test)]
mod tests;
