//! The rays from the points of a face to one light.

use crate::bounds::BoundingSphere;
use crate::shapes::points::{Points, ROUNDING};
use crate::tile::Lanes;
use crate::vector::{Vector, l1_norm};

/// Points, a light, and the light that it brings to them.
pub(crate) struct Shadow<'a> {
    pub(crate) points: &'a Points,
    /// Where the light stands.
    pub(crate) light: Vector,
    /// The squared distance of each to the light.
    pub(crate) squared: &'a Lanes,
    /// cos(theta) / r^2, and 0 where the light is hidden.
    pub(crate) irradiance: &'a mut Lanes,
    /// A sphere around the points.
    pub(crate) bounds: BoundingSphere,
}

impl Shadow<'_> {
    #[inline(always)]
    pub(crate) fn darken(&mut self, lane: usize, hidden: bool) {
        let irradiance = self.irradiance[lane];
        self.irradiance[lane] = if hidden { 0.0 } else { irradiance };
    }

    /// Whether no light is left.
    #[inline(always)]
    pub(crate) fn is_dark(&self) -> bool {
        let mut bits = 0;
        for irradiance in &self.irradiance[..self.points.padded()] {
            bits |= irradiance.to_bits();
        }
        bits == 0
    }

    /// What float64 may have taken from the places of the points and of an object of some size: what is closer
    /// touches.
    #[inline(always)]
    pub(crate) fn rounding_at_points(&self, size: f64) -> f64 {
        ROUNDING * (l1_norm(self.points.reference) + size)
    }

    /// What float64 may have taken from the places of the light and of an object of some size.
    #[inline(always)]
    pub(crate) fn rounding_at_light(&self, size: f64) -> f64 {
        ROUNDING * (l1_norm(self.light) + size)
    }
}
