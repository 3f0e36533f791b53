//! The cones of directions in which convex shapes appear to the eye.
//!
//! Rays through the corners of a rectangle of the image plane bound all rays between them: if all four are in a
//! convex cone, all others are. Rectangles end at the edges of pixels and rays go through their centres: half a
//! pixel is more than the rounding between this test, in float64, and the kernel.

use crate::vector::{Vector, add, cross, dot, length, scale, sub};

/// How much of a rectangle a shape covers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Overlap {
    None,
    /// Unknown: test the rays.
    Partial,
    Full,
}

/// A rectangle of the image plane: the rays v = (x, y, 1).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rectangle {
    pub(crate) low: [f64; 2],
    pub(crate) high: [f64; 2],
    pub(crate) half_pixel: [f64; 2],
}

impl Rectangle {
    /// The rays through its corners.
    fn corners(&self) -> [Vector; 4] {
        let ([left, bottom], [right, top]) = (self.low, self.high);
        [[left, bottom, 1.0], [right, bottom, 1.0], [left, top, 1.0], [right, top, 1.0]]
    }

    /// The ray through its middle.
    fn middle(&self) -> Vector {
        [(self.low[0] + self.high[0]) / 2.0, (self.low[1] + self.high[1]) / 2.0, 1.0]
    }

    /// The smallest value of n . v.
    fn least(&self, n: Vector) -> f64 {
        let end = |axis: usize| if n[axis] > 0.0 { self.low[axis] } else { self.high[axis] };
        n[0] * end(0) + n[1] * end(1) + n[2]
    }

    /// The change of n . v over half a pixel.
    fn beside(&self, n: Vector) -> f64 {
        n[0].abs() * self.half_pixel[0] + n[1].abs() * self.half_pixel[1]
    }

    /// Whether n . v < 0 for all rays, and for those half a pixel beside them.
    fn is_beyond(&self, n: Vector) -> bool {
        -self.least([-n[0], -n[1], -n[2]]) + self.beside(n) < 0.0
    }

    /// Compare with a disc of the image plane.
    fn in_disc(&self, center: [f64; 2], radius: f64) -> Overlap {
        let (mut nearest, mut farthest) = ([0.0; 3], [0.0; 3]);
        for axis in 0..2 {
            let (low, high) = (self.low[axis] - center[axis], self.high[axis] - center[axis]);
            farthest[axis] = low.abs().max(high.abs());
            nearest[axis] = (low - self.half_pixel[axis]).max(-high - self.half_pixel[axis]).max(0.0);
        }
        if length(nearest) > radius {
            Overlap::None
        } else if length(farthest) < radius {
            Overlap::Full
        } else {
            Overlap::Partial
        }
    }

    /// The largest |v|.
    fn longest(&self) -> f64 {
        let extent = |axis: usize| self.low[axis].abs().max(self.high[axis].abs());
        length([extent(0), extent(1), 1.0])
    }
}

/// The cone of directions in which a shape appears.
pub(crate) enum Outline {
    /// The eye is well inside.
    Everywhere,
    Circular(CircularCone),
    /// A shape appears where n . v > 0 for the normals n of these planes through the eye, and rays meet it.
    Between(Vec<Vector>),
    /// A plane appears where n . v > 0, the normal n pointing away from the eye.
    HalfSpace(Vector),
    /// Parallel rays meet it where (x, y) is within a radius of a centre.
    Disc([f64; 2], f64),
    /// Behind the plane on which parallel rays start.
    Nowhere,
    /// The eye is on the surface, within rounding, or a length is not `USUAL`.
    Unknown,
}

/// An eye this close to a surface, as a share of the size, may be inside or outside.
const NEAR: f64 = 1e-6;

/// Lengths for which the kernel cannot overflow.
const USUAL: std::ops::Range<f64> = 1e-12..1e12;

impl Outline {
    /// The outline of a plane.
    pub(crate) fn of_plane(normal: Vector, offset: f64) -> Outline {
        let usual = USUAL.contains(&offset.abs());
        if usual { Outline::HalfSpace(scale(normal, offset.signum())) } else { Outline::Unknown }
    }

    /// The outline of a shape between planes. `beyond` is above 1 if the eye is outside, below 1 if it is inside; all
    /// lengths have to be usual.
    pub(crate) fn between(beyond: f64, lengths: &[f64], planes: impl FnOnce() -> Vec<Vector>) -> Outline {
        let usual = lengths.iter().all(|length| USUAL.contains(length));
        if usual && beyond < 1.0 - NEAR {
            return Outline::Everywhere;
        }
        if usual && beyond > 1.0 + NEAR { Outline::Between(planes()) } else { Outline::Unknown }
    }

    /// The outline of a plane for parallel rays, which it meets ahead where (offset - n_x x - n_y y) / n_z > 0.
    pub(crate) fn of_plane_in_parallel(normal: Vector, offset: f64) -> Outline {
        let [x, y, z] = normal;
        let usual = z.abs() > NOT_PARALLEL && offset.abs() < USUAL.end;
        if usual { Outline::HalfSpace(scale([-x, -y, offset], z.signum())) } else { Outline::Unknown }
    }

    /// The outline of a sphere for parallel rays.
    pub(crate) fn of_sphere_in_parallel(center: Vector, radius: f64) -> Outline {
        let [x, y, z] = center;
        let usual = USUAL.contains(&radius) && length(center) < USUAL.end;
        Outline::ahead(z, radius, usual, || Outline::Disc([x, y], radius))
    }

    /// The outline of a box for parallel rays: that of its shadow on the image plane.
    pub(crate) fn of_box_in_parallel(center: Vector, axes: [Vector; 3], half: Vector) -> Outline {
        let usual = half.iter().all(|h| USUAL.contains(h)) && length(center) < USUAL.end;
        let along = (0..3).map(|i| half[i] * axes[i][2].abs()).sum();
        let shadow = || corners(center, axes, half).map(|[x, y, _]| [x, y, 1.0]);
        Outline::ahead(center[2], along, usual, || Outline::Between(outline_planes(&shadow())))
    }

    /// The outline for parallel rays of a shape in a cylinder around the axis `half`, half its length: that of the
    /// rectangle around its shadow.
    pub(crate) fn of_cylinder_in_parallel(center: Vector, half: Vector, radius: f64) -> Outline {
        let [x, y, z] = half;
        let size = length(half);
        let usual = USUAL.contains(&radius) && USUAL.contains(&size) && length(center) < USUAL.end;
        let seen = libm::hypot(x, y);
        let along = if seen > NEAR * size { [x / seen, y / seen] } else { [1.0, 0.0] };
        let ends = seen + radius * (z / size).abs();
        let sides = || {
            let beside = |[x, y]: [f64; 2], extent: f64| {
                let middle = x * center[0] + y * center[1];
                [[x, y, extent - middle], [-x, -y, extent + middle]]
            };
            [beside(along, ends), beside([-along[1], along[0]], radius)].concat()
        };
        Outline::ahead(center[2], z.abs() + radius, usual, || Outline::Between(sides()))
    }

    /// The outline of a shape that is wholly ahead of the plane on which parallel rays start, or wholly behind it.
    fn ahead(center: f64, half: f64, usual: bool, outline: impl Fn() -> Outline) -> Outline {
        let rounding = NEAR * (center.abs() + half);
        if usual && center + half < -rounding {
            Outline::Nowhere
        } else if usual && center - half > rounding {
            outline()
        } else {
            Outline::Unknown
        }
    }

    /// Return how much of a rectangle the shape covers; `is_met` returns whether the ray through a point (x, y, 1) of the
    /// image plane meets it.
    pub(crate) fn in_rectangle(&self, rectangle: &Rectangle, is_met: impl Fn(Vector) -> bool) -> Overlap {
        match self {
            Outline::Everywhere => Overlap::Full,
            Outline::Circular(cone) => cone.in_rectangle(rectangle),
            Outline::Between(planes) if planes.iter().any(|&plane| rectangle.is_beyond(plane)) => Overlap::None,
            Outline::Between(_) if rectangle.corners().into_iter().all(is_met) => Overlap::Full,
            Outline::HalfSpace(normal) if rectangle.is_beyond(*normal) => Overlap::None,
            Outline::HalfSpace(normal) if rectangle.least(*normal) > NOT_PARALLEL * rectangle.longest() => {
                Overlap::Full
            }
            Outline::Between(_) | Outline::HalfSpace(_) | Outline::Unknown => Overlap::Partial,
            Outline::Disc(center, radius) => rectangle.in_disc(*center, *radius),
            Outline::Nowhere => Overlap::None,
        }
    }
}

/// A sphere appears within an angle around its centre, whose sine is radius over distance.
pub(crate) struct CircularCone {
    /// The unit vector to the centre.
    axis: Vector,
    sine: f64,
    cosine: f64,
}

impl CircularCone {
    pub(crate) fn outline(center: Vector, radius: f64) -> Outline {
        let distance = length(center);
        let sine = radius / distance;
        let usual = USUAL.contains(&radius) && distance < USUAL.end;
        if usual && sine > 1.0 + NEAR {
            return Outline::Everywhere;
        }
        if usual && sine < 1.0 - NEAR {
            return Outline::Circular(CircularCone {
                axis: scale(center, 1.0 / distance),
                sine,
                cosine: (1.0 - sine * sine).sqrt(),
            });
        }
        Outline::Unknown
    }

    fn in_rectangle(&self, rectangle: &Rectangle) -> Overlap {
        // The plane through the eye that touches the sphere where the rectangle is: n = sine axis - cosine side.
        let middle = rectangle.middle();
        let side = sub(middle, scale(self.axis, dot(self.axis, middle)));
        let away = length(side);
        if away > 0.0 {
            let touching = sub(scale(self.axis, self.sine), scale(side, self.cosine / away));
            if rectangle.is_beyond(touching) {
                return Overlap::None;
            }
        }
        // |axis x v| <= sine |v|, on the side of the axis.
        let inside = |v: Vector| {
            let across = cross(self.axis, v);
            dot(self.axis, v) > 0.0 && dot(across, across) <= self.sine * self.sine * dot(v, v)
        };
        if rectangle.corners().into_iter().all(inside) { Overlap::Full } else { Overlap::Partial }
    }
}

/// The kernel treats rays as parallel to a plane if the sine of the angle between them is below half of this.
const NOT_PARALLEL: f64 = 2e-6;

/// The corners of a box; the numbers of an edge's ends differ by one bit.
pub(crate) fn corners(center: Vector, axes: [Vector; 3], half: Vector) -> [Vector; 8] {
    std::array::from_fn(|number| {
        (0..3).fold(center, |corner, i| {
            let side = if number >> i & 1 == 0 { -half[i] } else { half[i] };
            add(corner, scale(axes[i], side))
        })
    })
}

/// The planes through the eye and an edge that have all corners of a box on one side.
pub(crate) fn outline_planes(corners: &[Vector; 8]) -> Vec<Vector> {
    let mut planes = Vec::with_capacity(6);
    for first in 0..8 {
        for bit in [1, 2, 4] {
            let second = first | bit;
            if second == first {
                continue;
            }
            let normal = cross(corners[first], corners[second]);
            let side = |i: usize| {
                if i == first || i == second { 0.0 } else { dot(normal, corners[i]) }
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
