//! The plane that a flat face lies in.

use crate::shapes::points::Points;
use crate::tile::rays::Rays;
use crate::vector::{Vector, dot, scale, to_f32};

/// The points P with n . P = offset.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlaneEquation {
    /// Unit normal.
    pub(crate) normal: Vector,
    /// The distance from the eye: positive where the normal points away from the eye.
    pub(crate) offset: f64,
}

impl PlaneEquation {
    /// The signed distance of a point: positive where the normal points.
    #[inline(always)]
    pub(crate) fn height(&self, point: Vector) -> f64 {
        dot(self.normal, point) - self.offset
    }

    /// The same plane, with its normal on the eye's side.
    #[inline(always)]
    pub(crate) fn facing_the_eye(&self) -> PlaneEquation {
        let sign = if self.offset > 0.0 { -1.0 } else { 1.0 };
        PlaneEquation { normal: self.normal.map(|component| sign * component), offset: sign * self.offset }
    }

    /// Place points on the plane, and return their reference: the point at depth `t` of the middle ray.
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
}
