//! Where a place lies as an object sees it: inside, outside, or on its surface, whatever rounding makes of it.
//!
//! It is found in the world's axes, so that it does not depend on where the camera stands.

use crate::vector::{Vector, dot, l1_norm, largest, sub};

/// A place that is closer to a surface than this share of its distance from the object and of the object's size
/// lies on it.
pub(crate) const ON_SURFACE: f64 = 1.0 / (1_u64 << 47) as f64;

/// The same of the coordinates, which come from decimal numbers.
pub(crate) const COORDINATE: f64 = 1.0 / (1_u64 << 52) as f64;

/// On which side of a surface a place lies; of a plane, the outside is where its normal points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    Inside,
    On,
    Outside,
}

/// A place close to a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Contact {
    pub(crate) side: Side,
    /// How far beyond the surface it is; less than 0 inside.
    pub(crate) height: f64,
    /// Of a box: the place from its centre along its axes. Of a plane: first, how far before it. Of a face in
    /// whose plane the place lies they are those of the face exactly.
    pub(crate) local: Vector,
}

/// What rounding may do to the distance of a place from the surface of an object of some size at another place.
pub(crate) fn rounding(place: Vector, center: Vector, size: f64) -> f64 {
    ON_SURFACE * (l1_norm(sub(place, center)) + size) + COORDINATE * (largest(place) + largest(center))
}

/// The same of a flat face of an object, given by its normal, and by half the object's size along that and in all.
///
/// What the object has along the face counts no more than the coordinates of the place: however far away along a floor the
/// place is by which it is given, and however far the floor reaches, that says nothing of its height.
pub(crate) fn rounding_across(normal: Vector, place: Vector, center: Vector, (half, size): (f64, f64)) -> f64 {
    let way = sub(place, center);
    let away = (l1_norm(way) + size).min(spread(normal, way) + half + l1_norm(place));
    let coordinates = largest(center).min(spread(normal, center) + largest(place));
    ON_SURFACE * away + COORDINATE * (largest(place) + coordinates)
}

/// The sum of |n_i v_i|.
pub(crate) fn spread(normal: Vector, v: Vector) -> f64 {
    dot(normal.map(f64::abs), v.map(f64::abs))
}

impl Side {
    /// Whether a light on this side lights what the eye sees: both inside, both outside, or the light on the
    /// surface.
    #[inline(always)]
    pub(crate) fn sees_from(self, eye_is_outside: bool) -> bool {
        self == Side::On || (self == Side::Outside) == eye_is_outside
    }

    fn of(height: f64) -> Side {
        if height > 0.0 {
            Side::Outside
        } else if height < 0.0 {
            Side::Inside
        } else {
            Side::On
        }
    }
}

impl Contact {
    pub(crate) fn new(height: f64, local: Vector) -> Contact {
        Contact {
            side: Side::of(height),
            height,
            local,
        }
    }

    /// Whether the place is on the surface, or within some distance of it.
    pub(crate) fn is_within(&self, distance: f64) -> bool {
        self.height.abs() <= distance
    }
}

#[cfg(test)]
mod tests;
