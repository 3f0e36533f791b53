//! An infinite plane (document, section 2.2.2).

use crate::contact::Contact;
use crate::grid::{HitBuffer, LANES, Rays, offer};
use crate::points::Points;
use crate::shadow::Shadow;
use crate::vector::{dot, scale, to_f32};
use crate::world::Vector;

/// Document, section 2.2.2: a ray with |d . n| below this, for unit d, is parallel to the plane.
const PARALLEL: f32 = 1e-6;

/// The points P with n . P = offset.
#[derive(Clone, Debug)]
pub(crate) struct Plane {
    /// Unit normal.
    pub(crate) normal: Vector,
    /// The eye's distance: positive where the normal points away from the eye.
    pub(crate) offset: f64,
    /// How far from the eye the point is that it was given by.
    pub(crate) reach: f64,
}

impl Plane {
    pub(crate) fn new(normal: Vector, offset: f64, reach: f64) -> Plane {
        Plane { normal, offset, reach }
    }

    /// On which side of the plane a place lies, and how far: positive where the normal points.
    #[inline(always)]
    pub(crate) fn height(&self, place: Vector) -> f64 {
        dot(self.normal, place) - self.offset
    }

    /// How high a light close to the plane is above it, on the eye's side.
    #[inline(always)]
    pub(crate) fn height_of(&self, light: &Contact) -> f64 {
        if self.offset > 0.0 {
            -light.local[0]
        } else {
            light.local[0]
        }
    }

    /// The same plane, with its normal on the eye's side.
    #[inline(always)]
    pub(crate) fn facing_the_eye(&self) -> Plane {
        let sign = if self.offset > 0.0 { -1.0 } else { 1.0 };
        Plane {
            normal: self.normal.map(|component| sign * component),
            offset: sign * self.offset,
            reach: self.reach,
        }
    }

    /// t = offset / (n . v)
    #[inline(always)]
    pub(crate) fn intersect(&self, face: u32, rays: &Rays, hits: &mut HitBuffer) {
        let middle = dot(self.normal, rays.middle) as f32;
        let [nx, ny, _] = to_f32(self.normal);
        let offset = self.offset as f32;
        let mut close = 0;
        for lane in 0..LANES {
            let along = middle + (nx * rays.dx[lane] + ny * rays.dy[lane]);
            let t = offset / along;
            let parallel = along * along < (PARALLEL * PARALLEL) * rays.vv[lane];
            close += offer(
                (&mut hits.t[lane], &mut hits.face[lane]),
                if parallel { 0.0 } else { t },
                face,
            );
        }
        hits.close += close;
    }

    /// t = offset / (n . v), in float64, infinite where it is not ahead; and |n.v|.
    pub(crate) fn depth(&self, v: Vector) -> (f64, f64) {
        let along = dot(self.normal, v);
        let t = self.offset / along;
        (if t > 0.0 { t } else { f64::INFINITY }, along.abs())
    }

    /// Place points on the plane, and return what they are relative to: the point at depth `t` of the middle ray.
    ///
    /// With v = middle + delta and the parameter t + tau:
    ///
    /// tau = (offset - t (n . v)) / (n . v),  P - reference = t delta + tau v
    #[inline(always)]
    pub(crate) fn place(&self, t: f64, rays: &Rays, points: &mut Points) -> Vector {
        let along_middle = dot(self.normal, rays.middle);
        let rest = (self.offset - t * along_middle) as f32;
        let [nx, ny, _] = to_f32(self.normal);
        let reference = scale(rays.middle, t);
        let (middle, t) = (along_middle as f32, t as f32);
        for lane in 0..points.padded() {
            let (dx, dy) = (rays.dx[lane], rays.dy[lane]);
            let across = nx * dx + ny * dy;
            let tau = (rest - t * across) / (middle + across);
            points.offset[0][lane] = t * dx + tau * rays.x[lane];
            points.offset[1][lane] = t * dy + tau * rays.y[lane];
            points.offset[2][lane] = tau;
        }
        reference
    }

    /// Darken the points that have the plane between them and the light.
    #[inline(always)]
    pub(crate) fn occlude(&self, contact: Option<&Contact>, shadow: &mut Shadow<'_>) {
        let light = contact.map_or_else(|| self.height(shadow.light.position), |contact| contact.local[0]);
        // A light on the plane, such as one on the ceiling, shines to both sides.
        if light == 0.0 {
            return;
        }
        let toward = scale(self.normal, light.signum());
        let ball = light.signum() * self.height(shadow.ball.center);
        if ball > shadow.ball.radius {
            return;
        }
        let height = light.signum() * self.height(shadow.points.reference);
        let limit = (-height - shadow.rounding_at_points(self.offset.abs())) as f32;
        let n = to_f32(toward);
        let points = shadow.points;
        for lane in 0..points.padded() {
            let [x, y, z] = &points.offset;
            let rise = n[0] * x[lane] + n[1] * y[lane] + n[2] * z[lane];
            shadow.darken(lane, rise + points.slack(lane) < limit);
        }
    }
}

#[cfg(test)]
mod tests;
