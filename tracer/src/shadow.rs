//! The rays from the points of a face to one light.

use crate::bvh::{Cone, Stack};
use crate::grid::Lanes;
use crate::points::{BoundingSphere, Points};
use crate::scene::{Light, Scene};
use crate::vector::{l1_norm, sub};

/// Rounding in float64 is less than this share of the distances from the eye.
pub(crate) const ROUNDING: f64 = 1e-13;

/// Points, a light, and the light that it brings to them.
pub(crate) struct Shadow<'a> {
    pub(crate) points: &'a Points,
    pub(crate) light: &'a Light,
    /// The squared distance of each to the light.
    pub(crate) squared: &'a Lanes,
    /// cos(theta) / r^2, and 0 where the light is hidden.
    pub(crate) irradiance: &'a mut Lanes,
    /// A ball around the points.
    pub(crate) ball: BoundingSphere,
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

    /// What float64 may have taken from the places of the points and of an object of some size: what is closer touches.
    #[inline(always)]
    pub(crate) fn rounding_at_points(&self, size: f64) -> f64 {
        ROUNDING * (l1_norm(self.points.reference) + size)
    }

    /// What float64 may have taken from the places of the light and of an object of some size.
    #[inline(always)]
    pub(crate) fn rounding_at_light(&self, size: f64) -> f64 {
        ROUNDING * (l1_norm(self.light.position) + size)
    }

    /// Darken the points from which another object hides the light.
    ///
    /// Neither `receiver`, on which they lie, counts, nor the body of the light: see `Lighting::add`.
    #[inline(always)]
    pub(crate) fn cast(&mut self, scene: &Scene, receiver: u32, stack: &mut Stack) {
        for &i in &scene.planes {
            if i != receiver {
                scene.shapes[i as usize].occlude(self.light.contact(i), self);
            }
        }
        if self.is_dark() {
            return;
        }
        let farthest = l1_norm(sub(self.ball.center, self.points.reference)) + self.ball.radius;
        let cone = Cone::from_apex(self.light.position, self.ball, farthest);
        let mut traversal = scene.bvh.traverse(&cone, stack);
        while let Some(i) = traversal.next(f32::INFINITY) {
            if i == receiver || i == self.light.body {
                continue;
            }
            scene.shapes[i as usize].occlude(self.light.contact(i), self);
            if self.is_dark() {
                return;
            }
        }
    }
}
