//! A capsule: a cylinder with half spheres for ends.

use crate::apex::Apex;
use crate::bounds::BoundingSphere;
use crate::camera::Projection;
use crate::camera_space::CameraSpace;
use crate::shapes::contact::{Contact, Side};
use crate::shapes::frustum::{Frustum, Lines, Profile, SideOfRay, span};
use crate::shapes::outline::Outline;
use crate::shapes::points::{Points, ROUNDING, ShadowRays};
use crate::shapes::primitive::{Description, Primitive};
use crate::shapes::sphere::{FAR_ABOVE_ROUNDING, RAYS_PER_TEST, Sphere};
use crate::tile::hits::{FACE_BITS, HitBuffer, INSIDE, from_inside, offer, offer_parallel};
use crate::tile::rays::{Ray, Rays};
use crate::tile::{LANES, Lanes};
use crate::vector::{Vector, add, l1_norm, normalized, scale};

/// The faces: the side of the cylinder, then the ends; the bit `INSIDE` is below.
const SIDE: u32 = 0;
const BASE: u32 = 2;
const TOP: u32 = 4;
const NONE: u32 = 6;

#[derive(Clone, Debug)]
pub(crate) struct Capsule {
    tube: Frustum,
    /// Around the ends of the axis: base and top.
    ends: [Sphere; 2],
    eye_is_outside: bool,
}

/// A capsule around its position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CapsuleDesc {
    /// Greater than 0.
    pub radius: f64,
    /// Between the centers of the half spheres, 0 or more.
    pub height: f64,
    /// Any length but 0.
    pub axis: Vector,
}

impl CapsuleDesc {
    fn profile(&self, space: &CameraSpace) -> Profile {
        let radius = space.length(self.radius);
        Profile::new(radius, radius, space.length(self.height))
    }
}

impl Description for CapsuleDesc {
    const PARAMETERS: usize = 5;

    type Shape = Capsule;

    fn new(parameters: &[f64]) -> CapsuleDesc {
        let p = parameters;
        CapsuleDesc { radius: p[0], height: p[1], axis: [p[2], p[3], p[4]] }
    }

    fn size(&self) -> f64 {
        self.height.max(self.radius)
    }

    fn contact(&self, space: &CameraSpace, position: Vector, point: Vector) -> Contact {
        Capsule::contact(point, position, normalized(self.axis), &self.profile(space))
    }

    fn transform(&self, space: &CameraSpace, position: Vector, range_scale: f64) -> Capsule {
        let place = (position, normalized(self.axis));
        let tube = Frustum::transform(space, place, &self.profile(space), range_scale);
        let eye = self.contact(space, position, space.eye);
        let close = eye.is_within(FAR_ABOVE_ROUNDING * (l1_norm(tube.center) + tube.profile.size()));
        Capsule::new(tube, &eye, close)
    }
}

impl Capsule {
    /// Return where a point is relative to a capsule, with the `local` of its cylinder.
    pub(crate) fn contact(point: Vector, center: Vector, axis: Vector, profile: &Profile) -> Contact {
        let contact = Frustum::contact(point, center, axis, profile);
        let [_, z, height] = contact.local;
        let height = if z.abs() <= profile.half {
            height
        } else {
            let end = add(center, scale(axis, z.signum() * profile.half));
            Sphere::contact(point, end, profile.radius).height
        };
        Contact::new(height, contact.local)
    }

    /// Make a capsule from its cylinder, and where the eye is relative to the capsule; perhaps it is `close`.
    pub(crate) fn new(tube: Frustum, eye: &Contact, close: bool) -> Capsule {
        let Profile { half, radius, .. } = tube.profile;
        let end = |sign: f64| {
            let contact = contact_of_end(&tube.profile, eye, sign);
            Sphere::new(add(tube.center, scale(tube.axis, sign * half)), radius, close.then_some(&contact))
        };
        Capsule { ends: [-1.0, 1.0].map(end), eye_is_outside: eye.side == Side::Outside, tube }
    }

    fn bounding_sphere(&self) -> BoundingSphere {
        let Profile { half, radius, .. } = self.tube.profile;
        BoundingSphere { center: self.tube.center, radius: half + radius }
    }

    /// Return which part ends at a height above the middle.
    #[inline(always)]
    fn part_at(&self, z: f64) -> u32 {
        let half = self.tube.profile.half;
        if z > half {
            TOP
        } else if z < -half {
            BASE
        } else {
            SIDE
        }
    }

    /// The number of a face in this shape.
    fn part(face: u32) -> u32 {
        (face % (1 << FACE_BITS)) & !INSIDE
    }

    fn end(&self, part: u32) -> &Sphere {
        &self.ends[((part - BASE) / 2) as usize]
    }

    /// The side of an apex that is not close to the surface.
    fn side(&self, apex: Apex) -> Side {
        if apex.is_direction() {
            return Side::Outside;
        }
        let place = self.tube.place(apex, None);
        let height = match self.part_at(place.z) {
            SIDE => place.height,
            part => Sphere::contact(apex.at, self.end(part).center, self.end(part).radius).height,
        };
        if height > 0.0 { Side::Outside } else { Side::Inside }
    }

    /// Return where a point is relative to the cylinder and the spheres, given where it is relative to the capsule.
    fn contacts(&self, contact: &Contact) -> [Contact; 3] {
        let profile = &self.tube.profile;
        let [_, z, height] = contact.local;
        let of_tube = Contact::new(height.max(z.abs() - profile.half), contact.local);
        [of_tube, contact_of_end(profile, contact, -1.0), contact_of_end(profile, contact, 1.0)]
    }

    /// Darken the points from which a part hides the light.
    #[inline(always)]
    fn occlude_by_parts(&self, contacts: Option<&[Contact; 3]>, shadow: &mut ShadowRays<'_>) {
        self.tube.occlude(contacts.map(|contacts| &contacts[0]), shadow);
        for (number, end) in (1..).zip(&self.ends) {
            end.occlude(contacts.map(|contacts| &contacts[number]), shadow);
        }
    }

    /// Return 0 for the points outside, 1 for the others.
    #[inline(always)]
    fn inside(&self, shadow: &ShadowRays<'_>) -> Lanes {
        let mut inside = [0.0; LANES];
        // A part hides a light in it from all points outside it.
        let within = Contact { side: Side::Inside, height: 0.0, local: [0.0; 3] };
        let mut mark = |hide: &dyn Fn(&mut ShadowRays<'_>)| {
            let mut left = [1.0; LANES];
            hide(&mut ShadowRays { irradiance: &mut left, ..*shadow });
            inside.iter_mut().zip(left).for_each(|(inside, left)| *inside = left.max(*inside));
        };
        mark(&|shadow| self.tube.occlude_nearby(&self.tube.place(shadow.light, None), Some(&within), shadow));
        for end in &self.ends {
            mark(&|shadow| end.occlude(Some(&within), shadow));
        }
        inside
    }

    /// Offer the hits of rays: on the side where they meet that between the ends, else on the sphere around the end
    /// beyond which they meet it.
    #[inline(always)]
    fn intersect_pencil(&self, face: u32, rays: &Rays, hits: &mut HitBuffer) {
        let outside = self.eye_is_outside;
        let face = face + if outside { 0 } else { INSIDE };
        let start = self.bounding_sphere().begin(rays);
        let lines = self.tube.lines_of_rays(rays, (rays.origin, rays.middle), f64::from(start));
        let radius = self.tube.profile.radius as f32;
        let mut parts = [NONE; LANES];
        let mut close = 0;
        for test in 0..LANES / RAYS_PER_TEST {
            let [dx, dy] = [&rays.dx, &rays.dy].map(|lanes| &lanes.as_chunks::<RAYS_PER_TEST>().0[test]);
            let Some(discriminant) = lines.discriminants(dx, dy) else { continue };
            let best = &mut hits.t.as_chunks_mut::<RAYS_PER_TEST>().0[test];
            let faces = &mut hits.face.as_chunks_mut::<RAYS_PER_TEST>().0[test];
            let parts = &mut parts.as_chunks_mut::<RAYS_PER_TEST>().0[test];
            for i in 0..RAYS_PER_TEST {
                let x = lines.across(dx[i], dy[i]);
                let coefficients = lines.coefficients::<false, false>(x);
                let (enter, leave) = span(coefficients.abc, coefficients.w[2], discriminant[i].sqrt());
                let tau = if outside { enter } else { leave };
                let part = lines.part_at(x, tau);
                let part = if discriminant[i] >= 0.0 { part } else { NONE };
                parts[i] = part;
                let t = if part == SIDE { start + tau * radius } else { 0.0 };
                close += offer((&mut best[i], &mut faces[i]), t, face + SIDE);
            }
        }
        hits.close += close;
        for part in [BASE, TOP] {
            self.end(part).offer_hits(|lane| parts[lane] == part, face + part, rays, hits);
        }
    }

    /// The same of parallel rays. Each is inside from the part where it enters the side to that where it leaves it.
    #[inline(always)]
    fn intersect_parallel(&self, face: u32, rays: &Rays, hits: &mut HitBuffer) {
        let start = self.bounding_sphere().begin(rays);
        let lines = self.tube.lines_of_rays(rays, (rays.origin, rays.middle), f64::from(start));
        let (limits, radius) = (rays.limits(), self.tube.profile.radius as f32);
        let [base, top] = self.ends.each_ref().map(|end| end.parallel_setup(rays));
        let mut close = 0;
        for test in 0..LANES / RAYS_PER_TEST {
            let [dx, dy] = [&rays.dx, &rays.dy].map(|lanes| &lanes.as_chunks::<RAYS_PER_TEST>().0[test]);
            let Some(discriminant) = lines.discriminants(dx, dy) else { continue };
            let best = &mut hits.t.as_chunks_mut::<RAYS_PER_TEST>().0[test];
            let faces = &mut hits.face.as_chunks_mut::<RAYS_PER_TEST>().0[test];
            for i in 0..RAYS_PER_TEST {
                let x = lines.across(dx[i], dy[i]);
                let coefficients = lines.coefficients::<true, false>(x);
                let (enter, leave) = span(coefficients.abc, coefficients.w[2], discriminant[i].sqrt());
                let (of_base, of_top) = (base.roots(dx[i], dy[i]), top.roots(dx[i], dy[i]));
                let (first, last) = (lines.part_at(x, enter), lines.part_at(x, leave));
                let near = if first == TOP { of_top.0 } else { of_base.0 };
                let near = if first == SIDE { start + enter * radius } else { near * radius };
                let far = if last == TOP { of_top.1 } else { of_base.1 };
                let far = if last == SIDE { start + leave * radius } else { far * radius };
                let outside = near > limits.0;
                let (t, part) = if outside { (near, first) } else { (far, last + INSIDE) };
                let t = if discriminant[i] >= 0.0 { t } else { 0.0 };
                close += offer_parallel((&mut best[i], &mut faces[i]), limits, t, face + part);
            }
        }
        hits.close += close;
    }
}

impl Lines {
    /// The part at the height where the line's parameter is tau.
    #[inline(always)]
    fn part_at(&self, x: [f32; 3], tau: f32) -> u32 {
        let z = self.height(x, tau);
        let part = if z > self.half { TOP } else { SIDE };
        if z < -self.half { BASE } else { part }
    }
}

/// Return where a point is relative to the sphere around an end, given where it is relative to the capsule: not inside
/// the sphere if it is not inside the capsule.
fn contact_of_end(profile: &Profile, contact: &Contact, sign: f64) -> Contact {
    let Profile { half, radius, .. } = *profile;
    let [away, z, _] = contact.local;
    let height = libm::hypot(away, z - sign * half) - radius;
    let height = match contact.side {
        Side::On if sign * z > half => 0.0,
        Side::Inside => height,
        Side::On | Side::Outside => height.max(0.0),
    };
    Contact::new(height, contact.local)
}

impl Primitive for Capsule {
    #[inline(always)]
    fn intersect(&self, face: u32, rays: &Rays, hits: &mut HitBuffer) {
        if rays.are_parallel() {
            self.intersect_parallel(face, rays, hits);
        } else {
            self.intersect_pencil(face, rays, hits);
        }
    }

    fn depth(&self, ray: Ray) -> (f64, f64) {
        let side = SideOfRay::new(&self.tube, ray);
        let seen = |inside: bool| {
            let t = if inside { side.leave } else { side.enter };
            match self.part_at(side.z + t * side.along) {
                SIDE if t > ray.start => (t, side.steepness(t)),
                SIDE => (f64::INFINITY, 0.0),
                part => self.end(part).depth_seen(inside, ray),
            }
        };
        if !side.parallel {
            return seen(!self.eye_is_outside);
        }
        let (t, steepness) = seen(false);
        if t.is_finite() { (t, steepness) } else { seen(true) }
    }

    #[inline(always)]
    fn compute_points(&self, face: u32, rays: &Rays, depth: (f64, impl Fn() -> Ray), points: &mut Points) {
        match Capsule::part(face) {
            SIDE => self.tube.points_on_side(face, depth, rays, points),
            part => points.reference = self.end(part).points_on(face, depth, rays, points),
        }
    }

    /// Darken the points from which a part of the capsule hides the light; those inside it with the light are lit.
    #[inline(always)]
    fn occlude(&self, contact: Option<&Contact>, shadow: &mut ShadowRays<'_>) {
        let side = contact.map_or_else(|| self.side(shadow.light), |contact| contact.side);
        if side == Side::Outside {
            let contacts = contact.map(|contact| self.contacts(contact));
            self.occlude_by_parts(contacts.as_ref(), shadow);
            return;
        }
        let inside = self.inside(shadow);
        let mut left = [0.0; LANES];
        if let Some(contact) = contact.filter(|_| side == Side::On) {
            left = *shadow.irradiance;
            let behind = &mut ShadowRays { irradiance: &mut left, ..*shadow };
            self.occlude_by_parts(Some(&self.contacts(contact)), behind);
        }
        for lane in 0..shadow.points.padded() {
            shadow.darken(lane, (inside[lane] == 0.0) & (left[lane] == 0.0));
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
        l1_norm(self.tube.center) + self.tube.profile.half + 2.0 * self.tube.profile.radius
    }

    fn bounds(&self) -> Option<BoundingSphere> {
        Some(self.bounding_sphere())
    }

    fn outline(&self, projection: Projection) -> Outline {
        let Profile { half, radius, .. } = self.tube.profile;
        if projection == Projection::Orthographic {
            let Frustum { center, axis, .. } = self.tube;
            return Outline::of_cylinder_in_parallel(center, scale(axis, half + radius), radius);
        }
        let eye = &self.tube.eye;
        let distance = libm::hypot(eye.away, (eye.z.abs() - half).max(0.0));
        Outline::between(distance / radius, &[radius], || {
            // The tangents from the eye to the circles around the ends.
            let ends = [-half, half].map(|z| [-eye.away, z - eye.z]);
            let normals = ends.into_iter().flat_map(|[x, z]| {
                let distance = libm::hypot(x, z);
                let (sine, [x, z]) = (radius / distance, [x / distance, z / distance]);
                let cosine = (1.0 - sine * sine).max(0.0).sqrt();
                [cosine, -cosine].map(|cosine| [sine * x - cosine * z, sine * z + cosine * x])
            });
            let least = radius * (1.0 - ROUNDING) - ROUNDING * l1_norm(self.tube.center);
            self.tube
                .planes_around(normals.filter(|[x, z]| ends.iter().all(|end| x * end[0] + z * end[1] >= least)))
        })
    }
}
