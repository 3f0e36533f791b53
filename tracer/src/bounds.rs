//! Volumes around objects and points.

use crate::tile::rays::Rays;
use crate::vector::{Vector, dot, length, sub};

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
    pub(crate) fn begin(&self, rays: &Rays) -> f32 {
        let size = length(rays.middle);
        let begin = dot(sub(self.center, rays.origin), rays.middle) / size - self.radius;
        if begin > self.radius { (begin / size) as f32 } else { 0.0 }
    }
}
