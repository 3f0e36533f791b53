//! The rays from the points of a face to one light.

use crate::bounds::BoundingSphere;
use crate::shapes::points::{Points, ROUNDING};
use crate::tile::Lanes;
use crate::vector::{Vector, l1_norm};

/// Points, and the irradiance from one light at each.
pub(crate) struct Shadow<'a> {
    pub(crate) points: &'a Points,
    /// The position of the light.
    pub(crate) light: Vector,
    /// The squared distance of each to the light.
    pub(crate) squared: &'a Lanes,
    /// cos(theta) / r^2, and 0 where the light is hidden.
    pub(crate) irradiance: &'a mut Lanes,
    /// A bounding sphere of the points.
    pub(crate) bounds: BoundingSphere,
}

impl Shadow<'_> {
    #[inline(always)]
    pub(crate) fn darken(&mut self, lane: usize, hidden: bool) {
        let irradiance = self.irradiance[lane];
        self.irradiance[lane] = if hidden { 0.0 } else { irradiance };
    }

    /// Whether all points are dark.
    #[inline(always)]
    pub(crate) fn is_dark(&self) -> bool {
        let mut bits = 0;
        for irradiance in &self.irradiance[..self.points.padded()] {
            bits |= irradiance.to_bits();
        }
        bits == 0
    }

    /// The float64 rounding of the distance between the points and an object of some size: within it they touch.
    #[inline(always)]
    pub(crate) fn rounding_at_points(&self, size: f64) -> f64 {
        ROUNDING * (l1_norm(self.points.reference) + size)
    }

    /// The same for the distance between the light and an object.
    #[inline(always)]
    pub(crate) fn rounding_at_light(&self, size: f64) -> f64 {
        ROUNDING * (l1_norm(self.light) + size)
    }
}
