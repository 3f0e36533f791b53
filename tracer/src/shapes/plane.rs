//! An infinite plane (document, section 2.2.2).

use crate::apex::Apex;
use crate::bounds::BoundingSphere;
use crate::camera::Projection;
use crate::camera_space::{CameraSpace, range_scale_at};
use crate::shapes::contact::{Contact, rounding_across, spread};
use crate::shapes::outline::Outline;
use crate::shapes::points::{PlaneEquation, Points, ROUNDING, ShadowRays};
use crate::shapes::primitive::{Description, FaceAxes, Primitive};
use crate::tile::LANES;
use crate::tile::hits::{HitBuffer, INSIDE, from_inside, offer, offer_parallel};
use crate::tile::rays::{Ray, Rays, at_a_slant};
use crate::vector::{Vector, cross, dot, l1_norm, normalized, scale, sub, to_f32};

/// Document, section 2.2.2: a ray with |d . n| below this, for unit d, is parallel to the plane.
const PARALLEL: f32 = 1e-6;

/// A unit normal this close to the x axis has its checker along the z axis.
const NEAR_X: f64 = 1e-3;

#[derive(Clone, Debug)]
pub(crate) struct Plane {
    equation: PlaneEquation,
    /// The sum of |n_i p_i|, p the point that defines the plane, relative to the eye: rounding of the offset grows
    /// with it.
    magnitude: f64,
}

/// An infinite plane through its position, two-sided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneDesc {
    /// Any length but 0.
    pub normal: Vector,
}

impl Description for PlaneDesc {
    const PARAMETERS: usize = 3;

    type Shape = Plane;

    fn new(parameters: &[f64]) -> PlaneDesc {
        PlaneDesc { normal: [parameters[0], parameters[1], parameters[2]] }
    }

    fn size(&self) -> f64 {
        0.0
    }

    fn contact(&self, _space: &CameraSpace, position: Vector, point: Vector) -> Contact {
        Plane::contact(point, position, normalized(self.normal))
    }

    fn range_scale(&self, space: &CameraSpace, position: Vector) -> f64 {
        range_scale_at(self.contact(space, position, space.eye).height.abs())
    }

    /// The normal n, then u, the part of the x axis perpendicular to n, and v = n x u; of the z axis if n is within
    /// 1e-3 of the x axis.
    fn face_axes(&self, space: &CameraSpace) -> Option<FaceAxes> {
        let n = normalized(self.normal);
        let is_near_x = n[1] * n[1] + n[2] * n[2] < NEAR_X * NEAR_X;
        let start = if is_near_x { [0.0, 0.0, 1.0] } else { [1.0, 0.0, 0.0] };
        let u = normalized(sub(start, scale(n, dot(start, n))));
        Some(FaceAxes([n, u, cross(n, u)].map(|axis| space.direction(axis))))
    }

    fn transform(&self, space: &CameraSpace, position: Vector, range_scale: f64) -> Plane {
        let normal = normalized(self.normal);
        // The height of the eye, found in the world's axes, is exactly 0 if the eye is on the plane.
        let offset = -Plane::contact(space.eye, position, normal).height * range_scale;
        let magnitude = spread(normal, sub(position, space.eye));
        Plane::new(space.direction(normal), offset, magnitude)
    }
}

impl Plane {
    /// Return where a point is relative to a plane through another point.
    pub(crate) fn contact(point: Vector, through: Vector, normal: Vector) -> Contact {
        let height = dot(normal, sub(point, through));
        let on = height.abs() <= rounding_across(normal, point, through, (0.0, 0.0));
        let height = if on { 0.0 } else { height };
        Contact::new(height, [0.0; 3])
    }

    pub(crate) fn new(normal: Vector, offset: f64, magnitude: f64) -> Plane {
        Plane { equation: PlaneEquation { normal, offset }, magnitude }
    }
}

impl Plane {
    /// t = (offset - n . (o + delta)) / (n . v), and v is the same for all rays.
    #[inline(always)]
    fn intersect_parallel(&self, face: u32, rays: &Rays, hits: &mut HitBuffer) {
        let PlaneEquation { normal, offset } = self.equation;
        let along = dot(normal, rays.middle);
        if along.abs() < f64::from(PARALLEL) {
            return;
        }
        let face = face + if along > 0.0 { INSIDE } else { 0 };
        let middle = ((offset - dot(normal, rays.origin)) / along) as f32;
        let [x, y, _] = to_f32(scale(normal, -1.0 / along));
        let (start, rounding) = rays.limits();
        let limits = (start, at_a_slant(rounding, along));
        let mut close = 0;
        for lane in 0..LANES {
            let t = middle + (x * rays.dx[lane] + y * rays.dy[lane]);
            close += offer_parallel((&mut hits.t[lane], &mut hits.face[lane]), limits, t, face);
        }
        hits.close += close;
    }
}

impl Primitive for Plane {
    const IS_BOUNDED: bool = false;

    /// t = offset / (n . v)
    #[inline(always)]
    fn intersect(&self, face: u32, rays: &Rays, hits: &mut HitBuffer) {
        if rays.are_parallel() {
            self.intersect_parallel(face, rays, hits);
            return;
        }
        let face = face + if self.equation.offset > 0.0 { INSIDE } else { 0 };
        let middle = dot(self.equation.normal, rays.middle) as f32;
        let [nx, ny, _] = to_f32(self.equation.normal);
        let offset = self.equation.offset as f32;
        let mut close = 0;
        for lane in 0..LANES {
            let along = middle + (nx * rays.dx[lane] + ny * rays.dy[lane]);
            let t = offset / along;
            let parallel = along * along < (PARALLEL * PARALLEL) * rays.vv[lane];
            close += offer((&mut hits.t[lane], &mut hits.face[lane]), if parallel { 0.0 } else { t }, face);
        }
        hits.close += close;
    }

    /// t = (offset - n . o) / (n . v), in float64, infinite where it is not ahead; and |n.v|.
    fn depth(&self, ray: Ray) -> (f64, f64) {
        let along = dot(self.equation.normal, ray.direction);
        let t = (self.equation.offset - dot(self.equation.normal, ray.origin)) / along;
        (if t > ray.start { t } else { f64::INFINITY }, along.abs())
    }

    #[inline(always)]
    fn compute_points(&self, face: u32, rays: &Rays, (t, _): (f64, impl Fn() -> Ray), points: &mut Points) {
        self.equation.facing_the_eye(face).compute_points(t, rays, points);
    }

    /// Darken the points on the other side of the plane.
    #[inline(always)]
    fn occlude(&self, contact: Option<&Contact>, shadow: &mut ShadowRays<'_>) {
        let height_of_light = || self.equation.height_of_apex(shadow.light);
        let light = contact.map_or_else(height_of_light, |contact| contact.height);
        // A light on the plane, such as one on the ceiling, shines to both sides; so does one whose rays are parallel
        // to it.
        if light == 0.0 || (shadow.light.is_direction() && light.abs() < f64::from(PARALLEL)) {
            return;
        }
        let toward = scale(self.equation.normal, light.signum());
        let bounds = light.signum() * self.equation.height(shadow.bounds.center);
        if bounds > shadow.bounds.radius {
            return;
        }
        let height = light.signum() * self.equation.height(shadow.points.reference);
        let limit = (-height - shadow.rounding_at_points(self.equation.offset.abs())) as f32;
        let n = to_f32(toward);
        let points = shadow.points;
        for lane in 0..points.padded() {
            let [x, y, z] = &points.offset;
            let rise = n[0] * x[lane] + n[1] * y[lane] + n[2] * z[lane];
            shadow.darken(lane, rise + points.slack(lane) < limit);
        }
    }

    /// Not if all points and the emitter are on one side.
    fn may_hide(&self, (apex, size): (Apex, f64), bounds: BoundingSphere) -> bool {
        let (points, light) = (self.equation.height(bounds.center), self.equation.height_of_apex(apex));
        let clear = ROUNDING * (l1_norm(bounds.center) + l1_norm(apex.at) + self.equation.offset.abs());
        !(points.abs() > bounds.radius + clear && points.signum() * light > size + clear)
    }

    /// The height above the plane decides.
    #[inline(always)]
    fn is_lit_from(&self, _face: u32, _contact: Option<&Contact>, _light: Apex) -> bool {
        true
    }

    #[inline(always)]
    fn height(&self, face: u32, light: &Contact) -> f64 {
        if from_inside(face) { -light.height } else { light.height }
    }

    fn magnitude(&self) -> f64 {
        self.magnitude
    }

    fn bounds(&self) -> Option<BoundingSphere> {
        None
    }

    fn outline(&self, projection: Projection) -> Outline {
        let PlaneEquation { normal, offset } = self.equation;
        match projection {
            Projection::Perspective => Outline::of_plane(normal, offset),
            Projection::Orthographic => Outline::of_plane_in_parallel(normal, offset),
        }
    }
}

#[cfg(test)]
mod tests;
