//! Volumes around objects and points.

use crate::vector::{Vector, dot, length};

/// A sphere around objects or points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BoundingSphere {
    pub(crate) center: Vector,
    pub(crate) radius: f64,
}

impl BoundingSphere {
    /// The depth of the middle ray from which float32 continues: where the sphere begins, or 0 if it is close
    /// relative to its size.
    #[inline(always)]
    pub(crate) fn begin(&self, middle: Vector) -> f32 {
        let size = length(middle);
        let begin = dot(self.center, middle) / size - self.radius;
        if begin > self.radius { (begin / size) as f32 } else { 0.0 }
    }
}
