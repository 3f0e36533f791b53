//! The cones that traverse the tree: for the rays of a tile, and for the points of a sphere.

use crate::accel::Volume;
use crate::accel::node::{CONSERVATIVE, Node, WIDTH};
use crate::apex::Apex;
use crate::bounds::BoundingSphere;
use crate::tile::rays::Rays;
use crate::vector::{Vector, dot, length, scale, sub, to_f32};

/// All that is seen from a point in the directions around an axis, up to a distance.
#[derive(Clone, Debug)]
pub(crate) struct Cone {
    apex: [f32; 3],
    /// Unit vector.
    axis: [f32; 3],
    cos: f32,
    sin: f32,
    /// The length of the cone along its axis.
    range: f32,
    /// The rounding of the apex and the points.
    slack: f32,
}

/// The sine from which a cone is wide: its cosine is 0.1.
const WIDE: f64 = 0.995;

impl Cone {
    /// The cone around the rays of a tile.
    pub(crate) fn of_tile(rays: &Rays) -> Cone {
        let (middle, half_size) = (rays.middle, rays.half_size);
        if rays.are_parallel() {
            // A cylinder: a cone without an angle, in which all bounds are larger by its radius.
            let mut cone = Cone::new(rays.origin, middle, 1.0, f64::INFINITY);
            cone.slack += length([half_size.0, half_size.1, 0.0]) as f32 * (1.0 + CONSERVATIVE);
            return cone;
        }
        let axis = scale(middle, 1.0 / length(middle));
        let cos: f64 = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)]
            .map(|(i, j)| {
                let corner = [middle[0] + i * half_size.0, middle[1] + j * half_size.1, 1.0];
                dot(axis, corner) / length(corner)
            })
            .into_iter()
            .fold(1.0, f64::min);
        let sin = if cos > 0.0 { (1.0 - cos * cos).max(0.0).sqrt() } else { 1.0 };
        Cone::new([0.0; 3], axis, sin, f64::INFINITY)
    }

    /// The cone from an apex around a bounding sphere of points, up to its far end. `farthest` is the largest
    /// distance of the points from their reference: their float32 rounding is a share of it. If the apex is
    /// infinitely far away the cone begins at the points.
    ///
    /// An emitter is a ball of radius `size` around the apex, or directions up to an angle of that sine. A cone that
    /// begins with a ball, rather than a point, reaches farther by its radius on all sides.
    #[inline(always)]
    pub(crate) fn from_apex(apex: Apex, size: f64, bounds: BoundingSphere, farthest: f64) -> Cone {
        if apex.is_direction() {
            let mut cone = Cone::new(bounds.center, apex.at, size, f64::INFINITY);
            cone.slack += bounds.radius as f32 + farthest as f32 * CONSERVATIVE;
            return cone;
        }
        let apex = apex.at;
        let toward = sub(bounds.center, apex);
        let distance = length(toward);
        // Negative if the emitter is larger.
        let sin = (bounds.radius - size) / distance;
        let range = distance + bounds.radius;
        let mut cone = Cone::new(apex, scale(toward, 1.0 / distance), sin, range);
        cone.slack += size as f32 * (1.0 + CONSERVATIVE) + farthest as f32 * CONSERVATIVE;
        cone
    }

    /// A cone of no length: it intersects the bounds that its apex is in or close to.
    pub(crate) fn around(apex: Vector, slack: f64) -> Cone {
        let mut cone = Cone::new(apex, [0.0; 3], 0.0, 0.0);
        cone.slack += slack as f32;
        cone
    }

    fn new(apex: Vector, axis: Vector, sin: f64, range: f64) -> Cone {
        // A wide cone becomes all directions: obtuse angles are too rare to deserve a test of their own. So does one
        // of NaN, whose ends are one inside the other.
        let narrow = sin.abs() < WIDE;
        Cone {
            apex: to_f32(apex),
            axis: if narrow { to_f32(axis) } else { [0.0; 3] },
            cos: if narrow { (1.0 - sin * sin).sqrt() as f32 } else { 0.0 },
            sin: if narrow { sin as f32 } else { 0.0 },
            range: range as f32 * (1.0 + CONSERVATIVE),
            slack: length(apex) as f32 * CONSERVATIVE,
        }
    }

    /// Return the largest distance along the axis of a hit of a tile's rays at a depth.
    #[inline(always)]
    pub(crate) fn along_axis(&self, rays: &Rays, depth: f32) -> f32 {
        let [x, y, _] = to_f32(rays.middle);
        let (right, up) = (rays.half_size.0 as f32, rays.half_size.1 as f32);
        // v . axis is largest at a corner.
        let [ax, ay, az] = self.axis;
        let largest = ax * x + ay * y + az + right * ax.abs() + up * ay.abs();
        // Infinity times 0, for a wide cone, means no limit.
        if depth < f32::INFINITY { depth * largest * (1.0 + CONSERVATIVE) } else { depth }
    }
}

impl Volume for Cone {
    #[inline(always)]
    fn range(&self) -> f32 {
        self.range
    }

    /// A sphere at distance d along the axis and p from it is hit if p cos <= R + d sin: its centre is within R of
    /// the cone's surface. Both sides are squared, since roots are slow.
    #[inline(always)]
    fn intersect(&self, node: &Node, limit: f32) -> ([f32; WIDTH], u64) {
        let mut near = [0.0; WIDTH];
        let mut met = [0_u8; WIDTH];
        let [ax, ay, az] = self.axis;
        for i in 0..WIDTH {
            let ([x, y, z], radius) = node.child_from(self.apex, self.slack, i);
            let d = x * ax + y * ay + z * az;
            let (px, py, pz) = (x - d * ax, y - d * ay, z - d * az);
            let pp = px * px + py * py + pz * pz;
            let room = radius + d * self.sin;
            // Never negative, so that its bits compare as an integer.
            near[i] = if d > radius { d - radius } else { 0.0 };
            let hit =
                (room >= 0.0) & (pp * (self.cos * self.cos) <= room * room) & (d >= -radius) & (near[i] <= limit);
            met[i] = u8::from(hit);
        }
        (near, u64::from_le_bytes(met))
    }
}
