//! Volumes around objects and points.

use crate::vector::Vector;

/// A sphere around objects or points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BoundingSphere {
    pub(crate) center: Vector,
    pub(crate) radius: f64,
}
