//! Where a point lies relative to a surface: inside, outside, or on it within rounding.
//!
//! Contacts are found in the world's axes, so that they do not depend on the camera.

use crate::vector::{Vector, dot, l1_norm, largest, sub};

/// A point lies on a surface if it is closer to it than this share of its distance from the object plus the
/// object's size, plus `COORDINATE` times its coordinates and the object's, which come from decimal numbers.
pub(crate) const ON_SURFACE: f64 = 1.0 / (1_u64 << 47) as f64;

/// The rounding of a coordinate, as a share of it.
pub(crate) const COORDINATE: f64 = 1.0 / (1_u64 << 52) as f64;

/// The side of a surface that a point lies on. A plane's normal points outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    Inside,
    On,
    Outside,
}

/// A point close to a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Contact {
    pub(crate) side: Side,
    /// The signed distance from the surface, negative inside.
    pub(crate) height: f64,
    /// The point relative to a box's centre, along its axes; a coordinate within rounding of a face's is exactly
    /// the face's.
    pub(crate) local: Vector,
}

/// Return the rounding of the distance between a point and the surface of an object.
pub(crate) fn rounding(point: Vector, center: Vector, size: f64) -> f64 {
    ON_SURFACE * (l1_norm(sub(point, center)) + size) + COORDINATE * (largest(point) + largest(center))
}

/// Return the rounding of the distance between a point and a flat face with a normal; `half` is half the object's
/// size along the normal, `size` half its size along all axes.
///
/// Sizes and distances along the face count no more than the coordinates of the point: neither the extent of a
/// floor nor the distance to the point that defines it affects its height.
pub(crate) fn rounding_across(normal: Vector, point: Vector, center: Vector, (half, size): (f64, f64)) -> f64 {
    let way = sub(point, center);
    let away = (l1_norm(way) + size).min(spread(normal, way) + half + l1_norm(point));
    let coordinates = largest(center).min(spread(normal, center) + largest(point));
    ON_SURFACE * away + COORDINATE * (largest(point) + coordinates)
}

/// The sum of |n_i v_i|.
pub(crate) fn spread(normal: Vector, v: Vector) -> f64 {
    dot(normal.map(f64::abs), v.map(f64::abs))
}

impl Side {
    /// Whether a light on this side illuminates a face that is seen from inside or outside: both are inside, both
    /// are outside, or the light is on the surface.
    #[inline(always)]
    pub(crate) fn illuminates(self, seen_from_inside: bool) -> bool {
        self == Side::On || (self == Side::Inside) == seen_from_inside
    }
}

impl Contact {
    pub(crate) fn new(height: f64, local: Vector) -> Contact {
        let side = if height > 0.0 {
            Side::Outside
        } else if height < 0.0 {
            Side::Inside
        } else {
            Side::On
        };
        Contact { side, height, local }
    }

    /// Whether the point is within a distance of the surface.
    pub(crate) fn is_within(&self, distance: f64) -> bool {
        self.height.abs() <= distance
    }
}

#[cfg(test)]
mod tests;
