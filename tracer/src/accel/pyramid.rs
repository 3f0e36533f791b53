//! The pyramids that traverse the tree for the points of a flat face.

use crate::accel::Volume;
use crate::accel::node::{CONSERVATIVE, Node, WIDTH};
use crate::apex::Apex;
use crate::shapes::points::{PlaneEquation, Points};
use crate::vector::{Vector, cross, dot, l1_norm, length, scale, sub, to_f32};

/// A face seen at less than about 6 degrees from its normal has no long side.
const SLANTED: f64 = 0.1;

/// A rectangle around the points of a flat face. A slanted face is long in the direction in which it recedes from
/// the eye: there a sphere around its points would be wide on all sides.
#[derive(Clone, Debug)]
pub(crate) struct Footprint {
    plane: PlaneEquation,
    /// Unit vectors in the plane: the direction in which it recedes, and the one across.
    axes: [Vector; 2],
    reference: Vector,
    /// The extents of the points along the axes, relative to the reference.
    extents: [[f32; 2]; 2],
    /// The largest distance of the points from the reference: their float32 rounding is a share of it.
    farthest: f32,
}

impl Footprint {
    #[inline(always)]
    pub(crate) fn new(plane: PlaneEquation, points: &Points) -> Footprint {
        let normal = plane.normal;
        let in_plane = |v: Vector| sub(v, scale(normal, dot(normal, v)));
        let receding = in_plane(points.reference);
        let along = if length(receding) > SLANTED * length(points.reference) {
            receding
        } else {
            in_plane(if normal[0].abs() < 0.7 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] })
        };
        let along = scale(along, 1.0 / length(along));
        let axes = [along, cross(normal, along)];
        let extents = axes.map(|axis| points.extent(to_f32(axis)));
        let farthest = extents.as_flattened().iter().fold(0.0, |most: f32, end| most + end.abs());
        Footprint { plane, axes, reference: points.reference, extents, farthest }
    }
}

/// All that is between an apex and the rectangle around a face's points; a prism if the apex is infinitely far away.
#[derive(Clone, Debug)]
pub(crate) struct Pyramid {
    /// The apex; a point of the face if it is infinitely far away.
    origin: [f32; 3],
    /// The footprint's axes, and the normal of the face away from the origin.
    axes: [[f32; 3]; 3],
    /// Two sides for each axis of the footprint: the components of the outward normal along that axis and along the
    /// face's normal, and the distance from the origin.
    sides: [[[f32; 3]; 2]; 2],
    /// The height of the apex above the face.
    range: f32,
    /// How far an emitter reaches beyond the apex.
    beyond: f32,
    /// The rounding of the apex and the points.
    slack: f32,
}

impl Pyramid {
    /// The pyramid from an apex on the eye's side of a face.
    ///
    /// With the apex at height h above the plane, a point of it at the coordinate a along an axis, relative to the
    /// apex, and the depth y below the apex: the plane through the apex and all points with the same a has the
    /// normal (h, -a). If the apex is infinitely far away in a direction with the components h and -a, y is the height
    /// above a point of the face.
    ///
    /// A plane that an emitter of a size touches from inside, a ball wholly above the face or directions up to an
    /// angle, is turned outward by the angle whose sine is that size over the length of (a, h).
    pub(crate) fn new(apex: Apex, emitter: f64, footprint: &Footprint) -> Pyramid {
        let Footprint { plane, axes: [along, across], reference, extents, farthest } = footprint;
        let height = plane.height_of_apex(apex).max(0.0);
        let from = scale(apex.way_from(*reference), -1.0);
        let (origin, away, range) = if apex.is_direction() {
            (sub(*reference, scale(plane.normal, plane.height(*reference))), plane.normal, f64::INFINITY)
        } else {
            (apex.at, scale(plane.normal, -1.0), height)
        };
        let side = |sign: f64, start: f64, end: f32| {
            let end = f64::from(end);
            let a = start + apex.weight * end;
            let (size, turn) = ((height * height + a * a).sqrt(), if apex.is_direction() { -1.0 } else { 1.0 });
            let sin = emitter / size;
            let cos = (1.0 - sin * sin).sqrt();
            let normal = [sign * height * cos + a * sin, turn * (height * sin - sign * a * cos)];
            let [along, up] = normal.map(|component| component / size);
            let beyond = if apex.is_direction() { along * end } else { emitter };
            // In any direction if the footprint is inside the emitter.
            if sin < 1.0 { [along, up, beyond].map(|x| x as f32) } else { [0.0; 3] }
        };
        let sides = |axis: Vector, [low, high]: [f32; 2]| {
            let start = dot(axis, from);
            [side(-1.0, start, low), side(1.0, start, high)]
        };
        Pyramid {
            origin: to_f32(origin),
            axes: [*along, *across, away].map(to_f32),
            sides: [sides(*along, extents[0]), sides(*across, extents[1])],
            range: range as f32 * (1.0 + CONSERVATIVE),
            beyond: if apex.is_direction() { 0.0 } else { emitter as f32 },
            slack: (l1_norm(origin) as f32 + farthest) * CONSERVATIVE,
        }
    }
}

impl Volume for Pyramid {
    #[inline(always)]
    fn range(&self) -> f32 {
        self.range
    }

    #[inline(always)]
    fn intersect(&self, node: &Node, limit: f32) -> ([f32; WIDTH], u64) {
        let mut near = [0.0; WIDTH];
        let mut met = [0_u8; WIDTH];
        let [along, across, down] = self.axes;
        let [[behind, ahead], [left, right]] = self.sides;
        for i in 0..WIDTH {
            let ([x, y, z], radius) = node.child_from(self.origin, self.slack, i);
            let a = x * along[0] + y * along[1] + z * along[2];
            let b = x * across[0] + y * across[1] + z * across[2];
            let d = x * down[0] + y * down[1] + z * down[2];
            near[i] = if d > radius { d - radius } else { 0.0 };
            let hit = (d + self.beyond >= -radius)
                & (near[i] <= limit)
                & (a * behind[0] + d * behind[1] <= radius + behind[2])
                & (a * ahead[0] + d * ahead[1] <= radius + ahead[2])
                & (b * left[0] + d * left[1] <= radius + left[2])
                & (b * right[0] + d * right[1] <= radius + right[2]);
            met[i] = u8::from(hit);
        }
        (near, u64::from_le_bytes(met))
    }
}
