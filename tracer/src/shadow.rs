//! The rays from the points of a face to one lamp.

use crate::bvh::{Cone, Stack};
use crate::grid::{LANES, Lanes};
use crate::plane::Plane;
use crate::points::{Ball, Points};
use crate::scene::{Scene, Shape};
use crate::vector::{length, scale, single, sub};
use crate::world::Vector;

/// What the rays from one lamp bring to points.
pub(crate) struct Shadow<'a> {
    pub(crate) points: &'a Points,
    /// Where the lamp stands.
    pub(crate) lamp: Vector,
    /// From the points' reference to the lamp.
    pub(crate) to_lamp: [f32; 3],
    /// The squared distance to the lamp.
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

    /// The share of a length that rounding may take from points: what is closer touches.
    pub(crate) fn slack(&self) -> f64 {
        let offset = sub(self.ball.center, self.points.reference);
        4e-6 * (length(offset) + self.ball.radius)
    }

    /// Darken the points from which another object hides the lamp.
    ///
    /// Neither `receiver`, on which they lie, counts, nor the body of the lamp: see `shade`.
    #[inline(always)]
    pub(crate) fn cast(&mut self, scene: &Scene, receiver: u32, body: u32, stack: &mut Stack) {
        for &i in &scene.planes {
            if let Shape::Plane(plane) = &scene.shapes[i as usize]
                && i != receiver
            {
                plane.hide(self);
            }
        }
        let cone = Cone::from_apex(self.lamp, self.ball);
        let mut walk = scene.bvh.walk(&cone, stack);
        while let Some(i) = walk.next(f64::INFINITY) {
            if i == receiver || i == body {
                continue;
            }
            match &scene.shapes[i as usize] {
                Shape::Sphere(sphere) => sphere.hide(self),
                Shape::Cuboid(cuboid) => cuboid.hide(self),
                Shape::Plane(_) => {}
            }
            if self.is_dark() {
                return;
            }
        }
    }
}

impl Plane {
    /// Darken the points that have the plane between them and the lamp.
    #[inline(always)]
    fn hide(&self, shadow: &mut Shadow<'_>) {
        let lamp = self.height(shadow.lamp);
        if lamp == 0.0 {
            return;
        }
        let toward = scale(self.normal, lamp.signum());
        let ball = lamp.signum() * self.height(shadow.ball.center);
        if ball > shadow.ball.radius {
            return;
        }
        let height = lamp.signum() * self.height(shadow.points.reference);
        let limit = (-height - shadow.slack()) as f32;
        let n = single(toward);
        let points = shadow.points;
        for lane in 0..points.padded() {
            let [x, y, z] = &points.offset;
            let rise = n[0] * x[lane] + n[1] * y[lane] + n[2] * z[lane];
            shadow.darken(lane, rise < limit);
        }
    }
}

/// The squared distance from points to a lamp, and cos(theta) / r^2 where they face it, else 0.
///
/// On a flat face n . w is the same for all points, the lamp's height above it.
#[inline(always)]
pub(crate) fn arriving(
    points: &Points,
    height: Option<f32>,
    to_lamp: [f32; 3],
    squared: &mut Lanes,
    light: &mut Lanes,
) {
    let count = points.padded().min(LANES);
    for lane in 0..count {
        let w = [
            to_lamp[0] - points.offset[0][lane],
            to_lamp[1] - points.offset[1][lane],
            to_lamp[2] - points.offset[2][lane],
        ];
        squared[lane] = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
    }
    match height {
        Some(height) => {
            for lane in 0..count {
                light[lane] = height / (squared[lane] * squared[lane].sqrt());
            }
        }
        None => {
            for lane in 0..count {
                let n = [
                    points.normal[0][lane],
                    points.normal[1][lane],
                    points.normal[2][lane],
                ];
                let toward = n[0] * (to_lamp[0] - points.offset[0][lane])
                    + n[1] * (to_lamp[1] - points.offset[1][lane])
                    + n[2] * (to_lamp[2] - points.offset[2][lane]);
                let facing = if toward > 0.0 { toward } else { 0.0 };
                light[lane] = facing / (squared[lane] * squared[lane].sqrt());
            }
        }
    }
    // 0 / 0, where a lamp lies on the surface.
    for value in &mut light[..count] {
        *value = if *value > 0.0 { *value } else { 0.0 };
    }
}
