//! The rays from the points of a face to one lamp.

use crate::bvh::{Cone, Stack};
use crate::grid::Lanes;
use crate::points::{Ball, Points};
use crate::scene::{Lamp, Scene};
use crate::vector::{sub, taxi};

/// Rounding in float64 is less than this share of the distances from the eye.
pub(crate) const ROUNDING: f64 = 1e-13;

/// Points, a lamp, and the light that it brings to them.
pub(crate) struct Shadow<'a> {
    pub(crate) points: &'a Points,
    pub(crate) lamp: &'a Lamp,
    /// The squared distance of each to the lamp.
    pub(crate) squared: &'a Lanes,
    /// cos(theta) / r^2, and 0 where the lamp is hidden.
    pub(crate) light: &'a mut Lanes,
    /// A ball around the points.
    pub(crate) ball: Ball,
}

impl Shadow<'_> {
    #[inline(always)]
    pub(crate) fn darken(&mut self, lane: usize, hidden: bool) {
        let light = self.light[lane];
        self.light[lane] = if hidden { 0.0 } else { light };
    }

    /// Whether no light is left.
    #[inline(always)]
    pub(crate) fn is_dark(&self) -> bool {
        let mut bits = 0;
        for light in &self.light[..self.points.padded()] {
            bits |= light.to_bits();
        }
        bits == 0
    }

    /// What float64 may have taken from the places of the points and of an object of some size: what is closer touches.
    #[inline(always)]
    pub(crate) fn rounding_at_points(&self, size: f64) -> f64 {
        ROUNDING * (taxi(self.points.reference) + size)
    }

    /// What float64 may have taken from the places of the lamp and of an object of some size.
    #[inline(always)]
    pub(crate) fn rounding_at_lamp(&self, size: f64) -> f64 {
        ROUNDING * (taxi(self.lamp.position) + size)
    }

    /// Darken the points from which another object hides the lamp.
    ///
    /// Neither `receiver`, on which they lie, counts, nor the body of the lamp: see `Lighting::add`.
    #[inline(always)]
    pub(crate) fn cast(&mut self, scene: &Scene, receiver: u32, stack: &mut Stack) {
        for &i in &scene.planes {
            if i != receiver {
                scene.shapes[i as usize].hide(self.lamp.contact(i), self);
            }
        }
        if self.is_dark() {
            return;
        }
        let farthest = taxi(sub(self.ball.center, self.points.reference)) + self.ball.radius;
        let cone = Cone::from_apex(self.lamp.position, self.ball, farthest);
        let mut walk = scene.bvh.walk(&cone, stack);
        while let Some(i) = walk.next(f32::INFINITY) {
            if i == receiver || i == self.lamp.body {
                continue;
            }
            scene.shapes[i as usize].hide(self.lamp.contact(i), self);
            if self.is_dark() {
                return;
            }
        }
    }
}
