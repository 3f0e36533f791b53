//! A sphere (document, section 2.2.1).
//!
//! In units of its radius, with the centre c and a ray v from the eye, m = c x v is the ray's moment about the
//! eye's side of the centre, and
//!
//! D = v.v - m.m,  s = sqrt(D),  b = c.v,  k = c.c - 1
//!
//! give the roots (b -+ s) / v.v, of which k / (b + s) is the near one without cancellation. Close to the sphere
//! m is about 1 whatever its distance, so nothing cancels in D: the moment of the tile's middle ray comes from
//! float64 and float32 only adds differences within the tile (after E. Haines et al., "Precision Improvements
//! for Ray/Sphere Intersection", Ray Tracing Gems, 2019).

use crate::apex::Apex;
use crate::bounds::BoundingSphere;
use crate::camera::Projection;
use crate::camera_space::CameraSpace;
use crate::shapes::contact::{Contact, Side, rounding};
use crate::shapes::outline::{CircularCone, Outline};
use crate::shapes::points::{Points, ShadowRays};
use crate::shapes::primitive::{Description, Primitive};
use crate::tile::hits::{HitBuffer, INSIDE, from_inside, offer, offer_parallel};
use crate::tile::rays::{Ray, Rays};
use crate::tile::{LANES, SIDE};
use crate::vector::{Vector, add, cross, dot, l1_norm, length, scale, sub, to_f32};

/// Rays of whole rows, tested together for whether any of them hits a curved surface.
pub(crate) const RAYS_PER_TEST: usize = 64;

/// A patch smaller than this share of the radius is almost flat.
const FLAT: f64 = 1.0 / 256.0;

/// The rounding of the depth of points that `points_nearby` computes, as a share of it.
const NEAR_ROUNDING: f64 = 1e-6;

/// The height above a curved surface loses less to rounding in camera space than to float32 if it is more than this share
/// of distances from the eye and sizes.
pub(crate) const FAR_ABOVE_ROUNDING: f64 = 1e-8;

/// The eye is close to a sphere if k is below this: closer than a radius.
const NEAR: f64 = 3.0;

#[derive(Clone, Debug)]
pub(crate) struct Sphere {
    pub(crate) center: Vector,
    pub(crate) radius: f64,
    /// The eye's power with respect to the sphere: positive outside, 0 on it.
    power_of_eye: f64,
}

/// The constants of a sphere for the rays of a tile, in units of its radius.
struct RaySetup {
    center: [f32; 3],
    /// The middle ray's moment m, and its b.
    moment: [f32; 3],
    along: f32,
    /// k, in units of the scene over units of the radius.
    power_of_eye: f32,
    radius: f32,
    /// Whether the eye is inside, or close.
    near: bool,
}

/// The constants of a sphere for parallel rays of a tile, in units of its radius.
///
/// A ray from o + delta along z has the moment m = (c_y - o_y, o_x - c_x) about the centre, plus (-delta_y, delta_x),
/// and
///
/// D = 1 - m.m,  b = c_z,  k = m.m + c_z^2 - 1
///
/// give the roots b -+ sqrt(D), whose product is k.
pub(crate) struct ParallelSetup {
    per_radius: f32,
    /// The middle ray's m, D and k.
    moment: [f32; 2],
    discriminant: f32,
    power: f32,
    along: f32,
    /// Whether the middle ray passes the centre at two radii or less.
    near: bool,
}

/// A sphere around its position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereDesc {
    /// Greater than 0.
    pub radius: f64,
}

impl Description for SphereDesc {
    const PARAMETERS: usize = 1;

    type Shape = Sphere;

    fn new(parameters: &[f64]) -> SphereDesc {
        SphereDesc { radius: parameters[0] }
    }

    fn size(&self) -> f64 {
        self.radius
    }

    fn contact(&self, space: &CameraSpace, position: Vector, point: Vector) -> Contact {
        Sphere::contact(point, position, space.length(self.radius))
    }

    fn transform(&self, space: &CameraSpace, position: Vector, range_scale: f64) -> Sphere {
        let center = scale(space.point(position), range_scale);
        let radius = space.length(self.radius) * range_scale;
        let eye = self.contact(space, position, space.eye);
        let close = eye.is_within(FAR_ABOVE_ROUNDING * (l1_norm(center) + radius));
        Sphere::new(center, radius, close.then_some(&eye))
    }
}

impl Sphere {
    /// Return where a point is relative to a sphere.
    pub(crate) fn contact(point: Vector, center: Vector, radius: f64) -> Contact {
        let height = length(sub(center, point)) - radius;
        let on = height.abs() <= rounding(point, center, radius);
        Contact::new(if on { 0.0 } else { height }, [0.0; 3])
    }

    /// Make a sphere; `eye` is given if it is close to the surface.
    pub(crate) fn new(center: Vector, radius: f64, eye: Option<&Contact>) -> Sphere {
        let power_of_eye = match eye {
            Some(eye) => eye.height * (eye.height + 2.0 * radius),
            None => power_of_point(center, radius),
        };
        Sphere { center, radius, power_of_eye }
    }

    /// The side of a light that is not close to the surface.
    #[inline(always)]
    fn side(&self, light: Apex) -> Side {
        let c = sub(self.center, light.at);
        let outside = light.is_direction() || dot(c, c) > self.radius * self.radius;
        if outside { Side::Outside } else { Side::Inside }
    }

    /// Whether the eye sees the outside; an eye on the surface sees the inside.
    #[inline(always)]
    fn eye_is_outside(&self) -> bool {
        self.power_of_eye > 0.0
    }

    #[inline(always)]
    fn ray_setup(&self, middle: Vector) -> RaySetup {
        let center = scale(self.center, 1.0 / self.radius);
        let power_of_eye = self.power_of_eye / self.radius;
        RaySetup {
            center: to_f32(center),
            moment: to_f32(cross(center, middle)),
            along: dot(center, middle) as f32,
            power_of_eye: power_of_eye as f32,
            radius: self.radius as f32,
            near: power_of_eye < NEAR * self.radius,
        }
    }

    #[inline(always)]
    pub(crate) fn parallel_setup(&self, rays: &Rays) -> ParallelSetup {
        let c = scale(sub(self.center, rays.origin), 1.0 / self.radius);
        let beside = length([c[0], c[1], 0.0]);
        let discriminant = (1.0 - beside) * (1.0 + beside);
        ParallelSetup {
            per_radius: (1.0 / self.radius) as f32,
            moment: [c[1] as f32, -c[0] as f32],
            discriminant: discriminant as f32,
            power: (c[2] * c[2] - discriminant) as f32,
            along: c[2] as f32,
            near: beside < 2.0,
        }
    }

    /// Offer the nearest root ahead of the plane on which the rays start.
    #[inline(always)]
    fn intersect_parallel(&self, face: u32, rays: &Rays, hits: &mut HitBuffer) {
        let setup = self.parallel_setup(rays);
        let (limits, radius) = (rays.limits(), self.radius as f32);
        let mut close = 0;
        for test in 0..LANES / RAYS_PER_TEST {
            if !setup.crosses_rows(rays, test * RAYS_PER_TEST) {
                continue;
            }
            for i in 0..RAYS_PER_TEST {
                let lane = test * RAYS_PER_TEST + i;
                let (near, far) = setup.roots(rays.dx[lane], rays.dy[lane]);
                let inside = near * radius <= limits.0;
                let t = radius * if inside { far } else { near };
                let face = face + if inside { INSIDE } else { 0 };
                close += offer_parallel((&mut hits.t[lane], &mut hits.face[lane]), limits, t, face);
            }
        }
        hits.close += close;
    }

    /// Compute points where parallel rays hit the sphere, relative to its centre.
    ///
    /// n = (m_1, -m_0, -s) at the near root, and -(m_1, -m_0, s) at the far one, seen from inside
    #[inline(always)]
    fn points_in_parallel(&self, turn: f32, rays: &Rays, points: &mut Points) {
        let setup = self.parallel_setup(rays);
        let out = turn * self.radius as f32;
        for lane in 0..points.padded() {
            let (dx, dy) = (rays.dx[lane], rays.dy[lane]);
            let m = setup.moment(dx, dy);
            let (d, _) = setup.ray(dx, dy);
            let s = if d > 0.0 { d.sqrt() } else { 0.0 };
            let normal = [turn * m[1], -turn * m[0], -s];
            for i in 0..3 {
                points.normal[i][lane] = normal[i];
                points.offset[i][lane] = out * normal[i];
            }
        }
    }

    /// Compute points on the sphere, with normals on the side from which the face is seen, and return their reference
    /// point.
    ///
    /// n = -(v x m + s v) / v.v at the near root, (v x m - s v) / v.v at the far one, seen from inside
    ///
    /// The points are relative to the centre, P - C = R n or -R n; but on a large sphere close to the eye, where
    /// float32 cannot resolve them from the centre, they are relative to the point at depth `t` of the middle ray:
    /// with v = middle + delta and the parameter t + tau, P - reference = t delta + tau v. `nearest` returns the
    /// ray of the nearest point.
    ///
    /// Returning the reference, rather than writing it to `points`, makes tracing 4 % faster.
    #[inline(always)]
    pub(crate) fn points_on(
        &self,
        face: u32,
        (t, nearest): (f64, impl Fn() -> Ray),
        rays: &Rays,
        points: &mut Points,
    ) -> Vector {
        if self.is_flat_within(face, t, rays) {
            return self.points_on_patch(face, nearest(), rays, points);
        }
        let turn = if from_inside(face) { -1.0 } else { 1.0 };
        if rays.are_parallel() {
            self.points_in_parallel(turn, rays, points);
            return self.center;
        }
        let setup = self.ray_setup(rays.middle);
        let out = turn * setup.radius;
        for lane in 0..points.padded() {
            let m = setup.moment(rays.dx[lane], rays.dy[lane]);
            let (x, y, vv) = (rays.x[lane], rays.y[lane], rays.vv[lane]);
            let d = setup.discriminant(rays.dx[lane], rays.dy[lane], vv);
            let s = turn * if d > 0.0 { d.sqrt() } else { 0.0 };
            let normal = [
                turn * (m[1] - y * m[2] - s * x) / vv,
                turn * (x * m[2] - m[0] - s * y) / vv,
                turn * (y * m[0] - x * m[1] - s) / vv,
            ];
            for i in 0..3 {
                points.normal[i][lane] = normal[i];
                points.offset[i][lane] = out * normal[i];
            }
        }
        if setup.near && !from_inside(face) {
            self.points_nearby(&setup, t, rays, points);
            points.error += (t * NEAR_ROUNDING) as f32;
            return scale(rays.middle, t);
        }
        self.center
    }

    /// Whether float32 cannot resolve the points from the centre: the tile sees an almost flat patch, or the eye
    /// is just below the surface.
    #[inline(always)]
    fn is_flat_within(&self, face: u32, t: f64, rays: &Rays) -> bool {
        let patch = rays.divergence(t) * (rays.half_size.0 + rays.half_size.1);
        let below =
            !rays.are_parallel() && from_inside(face) && -self.power_of_eye < FLAT * self.radius * self.radius;
        patch < FLAT * self.radius || below
    }

    /// Compute points relative to the hit of a ray v_0, at depth t_0 with the outward normal n_0.
    ///
    /// With e = t_0 (v - v_0) / R, or (o - o_0) / R of parallel rays, and the depth t_0 + R tau, |n_0 + e + tau v| = 1
    /// gives
    ///
    /// tau = -k / (h -+ sqrt(h^2 - k v.v)),  h = (n_0 + e).v,  k = (2 n_0 + e).e
    #[inline(always)]
    fn points_on_patch(&self, face: u32, ray: Ray, rays: &Rays, points: &mut Points) -> Vector {
        // Where parallel rays start was looked at when the face was hit: rounding must not tell otherwise now.
        let (depth, _) = self.depth_seen(from_inside(face), Ray { start: f64::NEG_INFINITY, ..ray });
        let v_0 = ray.direction;
        let t_0 = if depth.is_finite() {
            depth
        } else {
            // The ray grazes the sphere, and float64 just misses it.
            dot(sub(self.center, ray.origin), v_0) / dot(v_0, v_0)
        };
        let reference = add(ray.origin, scale(v_0, t_0));
        let outward = sub(reference, self.center);
        let n_0 = to_f32(scale(outward, 1.0 / length(outward)));
        let beside = add(sub(v_0, rays.middle), sub(ray.origin, rays.origin));
        let (x_0, y_0) = (beside[0] as f32, beside[1] as f32);
        let (per_radius, radius) = ((rays.divergence(t_0) / self.radius) as f32, self.radius as f32);
        let outside = !from_inside(face);
        let turn = if outside { 1.0 } else { -1.0 };
        for lane in 0..points.padded() {
            let v = [rays.x[lane], rays.y[lane], 1.0];
            let e = [per_radius * (rays.dx[lane] - x_0), per_radius * (rays.dy[lane] - y_0)];
            let h = n_0[0] * v[0] + n_0[1] * v[1] + n_0[2] + (e[0] * v[0] + e[1] * v[1]);
            let k = (2.0 * n_0[0] + e[0]) * e[0] + (2.0 * n_0[1] + e[1]) * e[1];
            let d = h * h - k * rays.vv[lane];
            let s = if d > 0.0 { d.sqrt() } else { 0.0 };
            // From inside, the root that does not cancel; 0 where the ray only touches the sphere.
            let bottom = h - turn * s;
            let tau = if !outside && h < 0.0 {
                (s - h) / rays.vv[lane]
            } else if bottom != 0.0 {
                -k / bottom
            } else {
                0.0
            };
            let offset = [e[0] + tau * v[0], e[1] + tau * v[1], tau];
            for i in 0..3 {
                points.normal[i][lane] = turn * (n_0[i] + offset[i]);
                points.offset[i][lane] = radius * offset[i];
            }
        }
        reference
    }

    #[inline(always)]
    fn points_nearby(&self, setup: &RaySetup, t: f64, rays: &Rays, points: &mut Points) {
        let t = t as f32;
        for lane in 0..points.padded() {
            let (dx, dy) = (rays.dx[lane], rays.dy[lane]);
            let d = setup.discriminant(dx, dy, rays.vv[lane]);
            let s = if d > 0.0 { d.sqrt() } else { 0.0 };
            let tau = setup.power_of_eye / (setup.along(dx, dy) + s) - t;
            points.offset[0][lane] = t * dx + tau * rays.x[lane];
            points.offset[1][lane] = t * dy + tau * rays.y[lane];
            points.offset[2][lane] = tau;
        }
    }

    /// Darken the points from which the sphere hides the light.
    ///
    /// With w from the point to the light, q and c from the point and the light to the centre, and M = c x -w: the
    /// line hits the sphere where M.M <= R^2 w.w, and does so between the two if q.w > 0 and c.w < 0; or if one
    /// of them is inside. Of a light in the direction d, infinitely far away, w is d and c is -d, so that c.w < 0. A point is outside if its power q.q - R^2 is above 0. With the offset p from the
    /// reference, q = q_r - p; where the reference is close to the sphere nothing cancels in
    ///
    /// q.q - R^2 = (q_r.q_r - R^2) - p.(q_r + q)
    ///
    /// and where the sphere is almost flat, (q.w)^2 >= (q.q - R^2) w.w excludes lines that pass above its horizon.
    /// The far side hides a light on the sphere from points outside.
    #[inline(always)]
    fn occlude_light<const PARALLEL: bool>(&self, contact: Option<&Contact>, shadow: &mut ShadowRays<'_>) {
        let light = shadow.light;
        let from_light = scale(light.way_from(self.center), -1.0);
        let side = contact.map_or_else(|| self.side(light), |contact| contact.side);
        let per_radius = 1.0 / self.radius;
        let to_reference = scale(light.way_from(shadow.points.reference), -1.0);
        let from_reference = sub(self.center, shadow.points.reference);
        // c x (P_r - L) = q_r x (P_r - L): the shorter one does not cancel.
        let light_is_closer = dot(from_light, from_light) < dot(from_reference, from_reference);
        let arm = if light_is_closer && !light.is_direction() { from_light } else { from_reference };
        let moment = to_f32(scale(cross(arm, to_reference), per_radius));
        let c = to_f32(scale(from_light, per_radius));
        let q_r = to_f32(scale(from_reference, per_radius));
        let to_light = light.way_from_f32(shadow.points.reference);
        // The power of a point at a height h is about 2 h R.
        let rounding = (2.0 * shadow.rounding_at_points(self.radius) * per_radius) as f32;
        let close = dot(from_reference, from_reference) < 2.25 * self.radius * self.radius;
        let flat = close && shadow.bounds.radius < FLAT * self.radius;
        let (inside, on) = (side == Side::Inside, side == Side::On);
        let per_radius = per_radius as f32;
        let points = shadow.points;
        let q_of = |p: [f32; 3]| -> [f32; 3] { std::array::from_fn(|i| q_r[i] - p[i] * per_radius) };
        let crosses = |lane: usize, p: [f32; 3]| {
            let m = [
                moment[0] + (c[1] * p[2] - c[2] * p[1]),
                moment[1] + (c[2] * p[0] - c[0] * p[2]),
                moment[2] + (c[0] * p[1] - c[1] * p[0]),
            ];
            product(m, m) <= shadow.squared[lane]
        };
        let is_between =
            |crosses: bool, along: f32, w: [f32; 3]| crosses & (along > 0.0) & (PARALLEL || product(c, w) < 0.0);
        let beyond = length(sub(self.center, shadow.bounds.center)) - shadow.bounds.radius;
        if side == Side::Outside && beyond > self.radius && !flat {
            // All points and the light are outside.
            for lane in 0..points.padded() {
                let p = points.offset.each_ref().map(|axis| axis[lane]);
                let w = points.toward::<PARALLEL>(to_light, lane);
                let hidden = is_between(crosses(lane, p), product(q_of(p), w), w);
                shadow.darken(lane, hidden);
            }
            return;
        }
        let power_r = (power_of_point(from_reference, self.radius) / (self.radius * self.radius)) as f32;
        // Rounding changes a q.q close to 1 by less than 1e-6.
        let rounding = if close { rounding } else { rounding + 1e-6 };
        for lane in 0..points.padded() {
            let p = points.offset.each_ref().map(|axis| axis[lane]);
            let (q, w) = (q_of(p), points.toward::<PARALLEL>(to_light, lane));
            let sum = [q_r[0] + q[0], q_r[1] + q[1], q_r[2] + q[2]];
            let power = if close { power_r - per_radius * product(p, sum) } else { product(q, q) - 1.0 };
            let slack = 2.0 * points.slack(lane) * per_radius + rounding;
            let along = product(q, w);
            let crosses = if flat { along * along >= power * shadow.squared[lane] } else { crosses(lane, p) };
            let between = is_between(crosses, along, w);
            let (above, below) = (power > slack, power < -slack);
            let hidden = (inside & above) | (on & above & between) | (!inside & !on & (below | between));
            shadow.darken(lane, hidden);
        }
    }

    /// Offer the nearest positive root of the rays that are wanted.
    #[inline(always)]
    pub(crate) fn offer_hits(&self, wanted: impl Fn(usize) -> bool, face: u32, rays: &Rays, hits: &mut HitBuffer) {
        let setup = self.ray_setup(rays.middle);
        let outside = !from_inside(face);
        let mut close = 0;
        for test in 0..LANES / RAYS_PER_TEST {
            if !setup.crosses_rows(rays, test * RAYS_PER_TEST) {
                continue;
            }
            // Arrays of known length: a loop with bounds checks would not vectorize.
            let [dx, dy, vv] =
                [&rays.dx, &rays.dy, &rays.vv].map(|lanes| &lanes.as_chunks::<RAYS_PER_TEST>().0[test]);
            let mut discriminant = [0.0_f32; RAYS_PER_TEST];
            let mut met = 0_u32;
            for i in 0..RAYS_PER_TEST {
                let d = setup.discriminant(dx[i], dy[i], vv[i]);
                discriminant[i] = d;
                met |= u32::from(d >= 0.0);
            }
            if met == 0 {
                continue;
            }
            let best = &mut hits.t.as_chunks_mut::<RAYS_PER_TEST>().0[test];
            let faces = &mut hits.face.as_chunks_mut::<RAYS_PER_TEST>().0[test];
            for i in 0..RAYS_PER_TEST {
                let b = setup.along(dx[i], dy[i]);
                let s = discriminant[i].sqrt();
                // The root is NaN for a ray that misses, and negative for a sphere behind the eye.
                let t = if outside {
                    setup.power_of_eye / (b + s)
                } else if b >= 0.0 {
                    (b + s) * setup.radius / vv[i]
                } else {
                    setup.power_of_eye / (b - s)
                };
                let behind = outside & (b <= 0.0);
                let unseen = behind | !wanted(test * RAYS_PER_TEST + i);
                close += offer((&mut best[i], &mut faces[i]), if unseen { 0.0 } else { t }, face);
            }
        }
        hits.close += close;
    }

    /// The depths of the roots, and |n.v| there.
    ///
    /// D = R^2 - g.g, with g = c - (c.d) d from the centre's foot on the ray to the centre, |d| = 1; |n.d| =
    /// sqrt(D) / R
    fn roots(&self, ray: Ray) -> (f64, f64, f64) {
        let size = length(ray.direction);
        let d = scale(ray.direction, 1.0 / size);
        let center = sub(self.center, ray.origin);
        let power = if ray.origin == [0.0; 3] { self.power_of_eye } else { power_of_point(center, self.radius) };
        let b = dot(center, d);
        let g = sub(center, scale(d, b));
        let s = (self.radius * self.radius - dot(g, g)).sqrt();
        let (near, far) = if b >= 0.0 { (power / (b + s), b + s) } else { (b - s, power / (b - s)) };
        (near / size, far / size, s / self.radius * size)
    }

    /// The depth of the near root, or of the far one if it is seen from inside; and |n.v| there.
    pub(crate) fn depth_seen(&self, inside: bool, ray: Ray) -> (f64, f64) {
        let (near, far, steepness) = self.roots(ray);
        let depth = if inside { far } else { near };
        (if depth > ray.start { depth } else { f64::INFINITY }, steepness)
    }
}

impl Primitive for Sphere {
    #[inline(always)]
    fn intersect(&self, face: u32, rays: &Rays, hits: &mut HitBuffer) {
        if rays.are_parallel() {
            self.intersect_parallel(face, rays, hits);
        } else {
            let inside = if self.eye_is_outside() { 0 } else { INSIDE };
            self.offer_hits(|_| true, face + inside, rays, hits);
        }
    }

    fn depth(&self, ray: Ray) -> (f64, f64) {
        let (near, ..) = self.roots(ray);
        let outside = near > ray.start;
        self.depth_seen(!outside, ray)
    }

    #[inline(always)]
    fn compute_points(&self, face: u32, rays: &Rays, depth: (f64, impl Fn() -> Ray), points: &mut Points) {
        points.reference = self.points_on(face, depth, rays, points);
    }

    #[inline(always)]
    fn occlude(&self, contact: Option<&Contact>, shadow: &mut ShadowRays<'_>) {
        if shadow.light.is_direction() {
            self.occlude_light::<true>(contact, shadow);
        } else {
            self.occlude_light::<false>(contact, shadow);
        }
    }

    #[inline(always)]
    fn is_lit_from(&self, face: u32, contact: Option<&Contact>, light: Apex) -> bool {
        let side = contact.map_or_else(|| self.side(light), |contact| contact.side);
        side.illuminates(from_inside(face))
    }

    #[inline(always)]
    fn height(&self, _face: u32, _light: &Contact) -> f64 {
        0.0
    }

    fn magnitude(&self) -> f64 {
        l1_norm(self.center) + self.radius
    }

    fn bounds(&self) -> Option<BoundingSphere> {
        Some(BoundingSphere { center: self.center, radius: self.radius })
    }

    fn outline(&self, projection: Projection) -> Outline {
        match projection {
            Projection::Perspective => CircularCone::outline(self.center, self.radius),
            Projection::Orthographic => Outline::of_sphere_in_parallel(self.center, self.radius),
        }
    }
}

/// Scalar product.
#[inline(always)]
fn product(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The power of a point with respect to a sphere, (|c| - R) (|c| + R), c from the point to the centre: positive
/// outside.
#[inline(always)]
fn power_of_point(c: Vector, radius: f64) -> f64 {
    let distance = length(c);
    (distance - radius) * (distance + radius)
}

impl RaySetup {
    /// D of a ray relative to the middle one. Close to a sphere k is small, and D = b^2 - k v.v does not cancel
    /// where the ray grazes it.
    #[inline(always)]
    fn discriminant(&self, dx: f32, dy: f32, vv: f32) -> f32 {
        if self.near {
            let b = self.along(dx, dy);
            b * b - self.power_of_eye / self.radius * vv
        } else {
            let m = self.moment(dx, dy);
            vv - (m[0] * m[0] + m[1] * m[1] + m[2] * m[2])
        }
    }

    /// Whether rays of whole rows may hit the sphere: m_x, constant along a row, has to be below |v|.
    #[inline(always)]
    fn crosses_rows(&self, rays: &Rays, first: usize) -> bool {
        let last = first + RAYS_PER_TEST - 1;
        let top = self.moment(0.0, rays.dy[first])[0];
        let bottom = self.moment(0.0, rays.dy[last])[0];
        let corners =
            [rays.vv[first], rays.vv[first + SIDE as usize - 1], rays.vv[last], rays.vv[last + 1 - SIDE as usize]];
        let longest = corners.into_iter().fold(0.0, f32::max) * 1.001;
        let beyond = |m: f32| m * m > longest;
        !((top > 0.0) == (bottom > 0.0) && beyond(top) && beyond(bottom))
    }

    /// m of a ray relative to the middle one.
    #[inline(always)]
    fn moment(&self, dx: f32, dy: f32) -> [f32; 3] {
        let [x, y, z] = self.center;
        [self.moment[0] - z * dy, self.moment[1] + z * dx, self.moment[2] + (x * dy - y * dx)]
    }

    /// b of a ray relative to the middle one.
    #[inline(always)]
    fn along(&self, dx: f32, dy: f32) -> f32 {
        self.along + (self.center[0] * dx + self.center[1] * dy)
    }
}

impl ParallelSetup {
    /// The near and the far root of a ray relative to the middle one, in units of the radius; NaN if it misses.
    #[inline(always)]
    pub(crate) fn roots(&self, dx: f32, dy: f32) -> (f32, f32) {
        let (discriminant, power) = self.ray(dx, dy);
        let s = discriminant.sqrt();
        let ahead = self.along >= 0.0;
        let far_from_zero = if ahead { self.along + s } else { self.along - s };
        let other = power / far_from_zero;
        if ahead { (other, far_from_zero) } else { (far_from_zero, other) }
    }

    /// m of a ray relative to the middle one.
    #[inline(always)]
    fn moment(&self, dx: f32, dy: f32) -> [f32; 2] {
        [self.moment[0] - self.per_radius * dy, self.moment[1] + self.per_radius * dx]
    }

    /// D and k of a ray relative to the middle one. Close to that, neither cancels in the difference of m.m.
    #[inline(always)]
    fn ray(&self, dx: f32, dy: f32) -> (f32, f32) {
        let m = self.moment(dx, dy);
        if self.near {
            let (dx, dy) = (self.per_radius * dx, self.per_radius * dy);
            let change = (self.moment[1] + m[1]) * dx - (self.moment[0] + m[0]) * dy;
            (self.discriminant - change, self.power + change)
        } else {
            let discriminant = 1.0 - (m[0] * m[0] + m[1] * m[1]);
            (discriminant, self.along * self.along - discriminant)
        }
    }

    /// Whether rays of whole rows may hit the sphere: m_0, constant along a row, has to be below 1.
    #[inline(always)]
    fn crosses_rows(&self, rays: &Rays, first: usize) -> bool {
        let top = self.moment(0.0, rays.dy[first])[0];
        let bottom = self.moment(0.0, rays.dy[first + RAYS_PER_TEST - 1])[0];
        let beyond = |m: f32| m.abs() > 1.001;
        !((top > 0.0) == (bottom > 0.0) && beyond(top) && beyond(bottom))
    }
}

#[cfg(test)]
mod tests;
