//! Volumes around objects and points.

use crate::vector::{Vector, sub};

/// A sphere around objects or points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BoundingSphere {
    pub(crate) center: Vector,
    pub(crate) radius: f64,
}

/// An axis-aligned bounding box of spheres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Aabb {
    pub(crate) low: Vector,
    pub(crate) high: Vector,
}

impl Aabb {
    pub(crate) const EMPTY: Aabb = Aabb { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3] };

    #[inline(always)]
    pub(crate) fn with(self, center: Vector, radius: f64) -> Aabb {
        self.joined(&Aabb { low: center.map(|c| c - radius), high: center.map(|c| c + radius) })
    }

    #[inline(always)]
    pub(crate) fn joined(&self, other: &Aabb) -> Aabb {
        let lower = |a: f64, b: f64| if b < a { b } else { a };
        let higher = |a: f64, b: f64| if b > a { b } else { a };
        Aabb {
            low: std::array::from_fn(|i| lower(self.low[i], other.low[i])),
            high: std::array::from_fn(|i| higher(self.high[i], other.high[i])),
        }
    }

    /// Half the surface area; 0 if empty.
    pub(crate) fn area(&self) -> f64 {
        let [x, y, z] = sub(self.high, self.low);
        if x >= 0.0 { x * y + y * z + z * x } else { 0.0 }
    }
}
