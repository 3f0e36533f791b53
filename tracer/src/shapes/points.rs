//! The points of a tile that lie on one face, the plane of a flat face, and the shadow rays from the points.

use crate::apex::Apex;
use crate::bounds::BoundingSphere;
use crate::tile::hits::from_inside;
use crate::tile::rays::Rays;
use crate::tile::{LANES, Lanes, STEP};
use crate::vector::{Vector, add, dot, l1_norm, length, scale, to_f32};

/// Rounding in float64 is less than this share of the distances from the eye.
pub(crate) const ROUNDING: f64 = 1e-13;

/// Rounding in float32 is less than this share of the distances from the reference.
const TOUCHING: f32 = 4e-6;

/// Where rays of a tile meet one flat face, or one sphere.
#[derive(Clone, Debug)]
pub(crate) struct Points {
    /// The number of points.
    pub(crate) count: usize,
    /// The point that the offsets are relative to.
    pub(crate) reference: Vector,
    /// The points minus the reference.
    pub(crate) offset: [Lanes; 3],
    /// The plane of a flat face, with its normal on the eye's side; None on a sphere.
    pub(crate) plane: Option<PlaneEquation>,
    /// Unit normals that face the eye; of spheres only.
    pub(crate) normal: [Lanes; 3],
    /// 1 for the points on the squares of a checker's color, if the face has one.
    pub(crate) odd: [u32; LANES],
    /// Whether the face has a checker.
    pub(crate) checkered: bool,
    /// The position error that does not depend on the offset.
    pub(crate) error: f32,
}

impl Points {
    pub(crate) fn new() -> Points {
        Points {
            count: 0,
            reference: [0.0; 3],
            offset: [[0.0; LANES]; 3],
            plane: None,
            normal: [[0.0; LANES]; 3],
            odd: [0; LANES],
            checkered: false,
            error: 0.0,
        }
    }

    /// Begin points on a shape of a magnitude.
    #[inline(always)]
    pub(crate) fn start(&mut self, count: usize, magnitude: f64) {
        (self.count, self.plane, self.checkered) = (count, None, false);
        self.error = (ROUNDING * magnitude) as f32;
    }

    /// The count rounded up to a multiple of `STEP`.
    #[inline(always)]
    pub(crate) fn padded(&self) -> usize {
        self.count.next_multiple_of(STEP).min(LANES)
    }

    /// Return the vector from a point to an apex, given by the vector from the reference: the same one if the apex is
    /// infinitely far away. That is a constant, since a weight would take a tenth of the loops' time.
    #[inline(always)]
    pub(crate) fn toward<const PARALLEL: bool>(&self, apex: [f32; 3], i: usize) -> [f32; 3] {
        std::array::from_fn(|axis| if PARALLEL { apex[axis] } else { apex[axis] - self.offset[axis][i] })
    }

    /// A point, relative to the reference.
    #[inline(always)]
    pub(crate) fn offset_of(&self, i: usize) -> [f32; 3] {
        let [x, y, z] = &self.offset;
        [x[i], y[i], z[i]]
    }

    /// Bound on the rounding error of a point's position: anything closer touches it.
    ///
    /// It depends only on the point, like everything that determines a pixel.
    #[inline(always)]
    pub(crate) fn slack(&self, i: usize) -> f32 {
        let [x, y, z] = &self.offset;
        TOUCHING * (x[i].abs() + y[i].abs() + z[i].abs()) + self.error
    }

    /// The smallest and the largest offset along a direction.
    #[inline(always)]
    pub(crate) fn extent(&self, [x, y, z]: [f32; 3]) -> [f32; 2] {
        let mut along = [0.0; LANES];
        for lane in 0..self.padded() {
            along[lane] = x * self.offset[0][lane] + y * self.offset[1][lane] + z * self.offset[2][lane];
        }
        extremes(&along[..self.padded()])
    }

    /// A sphere that holds all points.
    #[inline(always)]
    pub(crate) fn bounds(&self) -> BoundingSphere {
        let mut middle = [0.0; 3];
        let mut half = [0.0; 3];
        for axis in 0..3 {
            let [low, high] = extremes(&self.offset[axis][..self.padded()]);
            middle[axis] = (f64::from(low) + f64::from(high)) / 2.0;
            half[axis] = (f64::from(high) - f64::from(low)) / 2.0;
        }
        BoundingSphere { center: add(self.reference, middle), radius: length(half) }
    }
}

/// The smallest and the largest of values, NaN aside.
///
/// As integers in the order of floats, which the compiler reduces in vectors wherever it inlines this. Of floats,
/// or of arrays of integers, it makes shuffles, gathers or nothing, depending on the context: a quarter of a
/// picture's time.
#[inline(always)]
pub(crate) fn extremes(values: &[f32]) -> [f32; 2] {
    let (mut low, mut high) = (i32::MAX, i32::MIN);
    for value in values {
        let bits = ordered(value.to_bits() as i32);
        low = low.min(bits);
        high = high.max(bits);
    }
    let found = [low, high].map(|bits| f32::from_bits(ordered(bits) as u32));
    if found[0].is_nan() || found[1].is_nan() {
        return known_extremes(values);
    }
    found
}

#[cold]
#[inline(never)]
fn known_extremes(values: &[f32]) -> [f32; 2] {
    values.iter().fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], &x| [low.min(x), high.max(x)])
}

/// The bits of a float as an integer in the order of floats, NaN below or above all others, and back.
#[inline(always)]
fn ordered(bits: i32) -> i32 {
    bits ^ ((bits >> 31) as u32 >> 1) as i32
}

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

    /// The signed distance of an apex, or the cosine of the angle between the normal and its direction.
    #[inline(always)]
    pub(crate) fn height_of_apex(&self, apex: Apex) -> f64 {
        dot(self.normal, apex.at) - apex.weight * self.offset
    }

    /// The same plane, with its normal on the side from which a face is seen.
    #[inline(always)]
    pub(crate) fn facing_the_eye(&self, face: u32) -> PlaneEquation {
        let sign = if from_inside(face) { -1.0 } else { 1.0 };
        PlaneEquation { normal: self.normal.map(|component| sign * component), offset: sign * self.offset }
    }

    /// Compute the points of rays on the plane, relative to the point at depth `t` of the middle ray.
    ///
    /// With v = middle + delta and the parameter t + tau:
    ///
    /// tau = (offset - t (n . v)) / (n . v),  P - reference = t delta + tau v
    ///
    /// Parallel rays start at o + delta instead, o the origin of the middle one, and v is the same for all:
    ///
    /// tau = (offset - n . (o + t v) - n . delta) / (n . v),  P - reference = delta + tau v
    #[inline(always)]
    pub(crate) fn compute_points(self, t: f64, rays: &Rays, points: &mut Points) {
        let along_middle = dot(self.normal, rays.middle);
        let rest = (self.offset - dot(self.normal, rays.origin) - t * along_middle) as f32;
        let [nx, ny, _] = to_f32(self.normal);
        let reference = add(rays.origin, scale(rays.middle, t));
        let (middle, divergence) = (along_middle as f32, rays.divergence(t) as f32);
        let turn = if rays.are_parallel() { 0.0 } else { 1.0 };
        for lane in 0..points.padded() {
            let (dx, dy) = (rays.dx[lane], rays.dy[lane]);
            let across = nx * dx + ny * dy;
            let tau = (rest - divergence * across) / (middle + turn * across);
            points.offset[0][lane] = divergence * dx + tau * rays.x[lane];
            points.offset[1][lane] = divergence * dy + tau * rays.y[lane];
            points.offset[2][lane] = tau;
        }
        (points.reference, points.plane) = (reference, Some(self));
    }
}

/// Points, and the irradiance from one light at each.
pub(crate) struct ShadowRays<'a> {
    pub(crate) points: &'a Points,
    /// The light.
    pub(crate) light: Apex,
    /// The squared length of the vector from each to the light.
    pub(crate) squared: &'a Lanes,
    /// cos(theta) / r^2, or cos(theta) of a light infinitely far away, and 0 where the light is hidden.
    pub(crate) irradiance: &'a mut Lanes,
    /// A bounding sphere of the points.
    pub(crate) bounds: BoundingSphere,
}

impl ShadowRays<'_> {
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
        ROUNDING * (l1_norm(self.light.at) + size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extremes_are_those_of_the_values_that_are_numbers() {
        assert_eq!(extremes(&[1.5, -2.0, 0.0, -0.5, 1e-40]), [-2.0, 1.5]);
        assert_eq!(extremes(&[-3.0, -1e-40, f32::NEG_INFINITY]), [f32::NEG_INFINITY, -1e-40]);
        assert_eq!(extremes(&[3.0, f32::NAN, 2.0, -f32::NAN]), [2.0, 3.0]);
    }
}
