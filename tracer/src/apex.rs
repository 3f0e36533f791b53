//! The apex of a pencil of shadow rays: the position of a light, or a direction in which it is infinitely far away.

use crate::vector::{Vector, scale, sub, to_f32};

/// A point of the projective space, in homogeneous coordinates: `(at, weight)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Apex {
    /// A position, or a unit vector.
    pub(crate) at: Vector,
    /// 1 for a position, 0 for a direction.
    pub(crate) weight: f64,
}

impl Apex {
    /// The apex at a position.
    pub(crate) const fn point(position: Vector) -> Apex {
        Apex { at: position, weight: 1.0 }
    }

    /// The apex infinitely far away in a direction, a unit vector: all rays are parallel.
    pub(crate) const fn direction(toward: Vector) -> Apex {
        Apex { at: toward, weight: 0.0 }
    }

    /// Whether it is infinitely far away.
    #[inline(always)]
    pub(crate) fn is_direction(&self) -> bool {
        self.weight == 0.0
    }

    /// The vector from a point to the apex: of any length if it is infinitely far away.
    #[inline(always)]
    pub(crate) fn from(&self, point: Vector) -> Vector {
        sub(self.at, scale(point, self.weight))
    }

    /// The same in float32.
    #[inline(always)]
    pub(crate) fn from_f32(&self, point: Vector) -> [f32; 3] {
        to_f32(self.from(point))
    }
}
