//! The frustum of a cone, closed by two discs: a cone, or a cylinder if both have the same radius.
//!
//! With the angle alpha between axis and side, a point at the height z above the middle and at the distance d from the
//! axis is d cos(alpha) - m above the side, where m = m_0 + z sin(alpha) (`docs/tracer.md`, section 2.2.4). The axis a,
//! and two unit vectors e and f at right angles to it, give a ray v and a point o the components
//!
//! W = (cos(alpha) v_e, cos(alpha) v_f, sin(alpha) v_a),  O = (cos(alpha) o_e, cos(alpha) o_f, m)
//!
//! so that with <X, Y> = X_1 Y_1 + X_2 Y_2 - X_3 Y_3 the ray o + t v meets the side where <O + t W, O + t W> = 0:
//!
//! A = <W, W>,  B = -<O, W>,  C = <O, O>,  D = B^2 - A C,  t = C / q or q / A,  q = B + sign(B) sqrt(D)
//!
//! D depends on the line alone. Of all lines through one apex, with e from the axis to the apex and so O_2 = 0,
//!
//! D = E^2 - F^2,  E = O_3 W_1 - O_1 W_3,  F = sqrt(C) W_2
//!
//! whose factors E - F and E + F are the heights of v above the two planes through the apex that touch the side:
//! nothing cancels at the outline. If C < 0, for an apex inside, D is a sum of squares. E and F do not change if W is
//! replaced by a point of the line over its parameter: the O of an apex at infinity is the direction's W, and C is A.

use crate::apex::Apex;
use crate::bounds::BoundingSphere;
use crate::camera::Projection;
use crate::camera_space::CameraSpace;
use crate::shapes::contact::{Contact, Side, rounding, rounding_across};
use crate::shapes::outline::Outline;
use crate::shapes::points::{PlaneEquation, Points, ROUNDING, ShadowRays};
use crate::shapes::primitive::Primitive;
use crate::shapes::sphere::{FAR_ABOVE_ROUNDING, RAYS_PER_TEST};
use crate::tile::LANES;
use crate::tile::hits::{FACE_BITS, HitBuffer, INSIDE, from_inside, offer, offer_parallel};
use crate::tile::rays::{Ray, Rays, at_a_slant};
use crate::vector::{Vector, add, cross, dot, l1_norm, length, perpendicular, rotate, scale, sub, to_f32};
use std::ops::{Add, Div, Sub};

/// The faces; the bit `INSIDE` is below.
pub(crate) const SIDE: u32 = 0;
const BASE: u32 = 2;
const TOP: u32 = 4;

/// An eye farther from a frustum than this multiple of its size is distant.
const DISTANT: f64 = 64.0;

/// A light is distant if it is farther from points close to a frustum than this multiple of its size plus theirs.
const DISTANT_LIGHT: f64 = (1_u64 << 28) as f64;

/// An origin closer to the apex than this share of the radius is placed relative to the apex.
const NEAR: f64 = 1.0 / 16.0;

/// An origin farther from the middle than this multiple of the radius is far away.
const FAR: f64 = 4.0;

/// A line begins close to the tip, or to the side of a flat cone, if the square of its O is less than this share of that
/// of the origin o.
const SHORT: f64 = 1.0 / 16.0;

/// The section of a frustum along its axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Profile {
    /// Half the height.
    pub(crate) half: f64,
    /// Of base and top.
    radii: [f64; 2],
    /// The larger one.
    pub(crate) radius: f64,
    /// Of alpha.
    sine: f64,
    cosine: f64,
    /// m in the middle.
    middle: f64,
}

/// A point relative to a frustum, or a direction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    /// 1 for a point, 0 for a direction.
    weight: f64,
    /// The unit vector to it from the axis.
    radial: Vector,
    /// Its distance from the axis, and its height above the middle; of a direction, its parts across the axis and
    /// along it.
    pub(crate) away: f64,
    pub(crate) z: f64,
    /// Its height above the side; 0 if it is on it.
    pub(crate) height: f64,
    /// (O_1, O_2, O_3), and C.
    origin: Vector,
    power: f64,
}

#[derive(Clone, Debug)]
pub(crate) struct Frustum {
    /// The middle of the axis.
    pub(crate) center: Vector,
    /// Unit vector, from the base to the top.
    pub(crate) axis: Vector,
    pub(crate) profile: Profile,
    pub(crate) eye: Place,
}

/// Lines through one apex, each given by the difference delta from one of them, in units of the radius: the
/// origin o + shift delta, and the direction v + turn delta.
pub(crate) struct Lines {
    /// cos(alpha) e, cos(alpha) f, a
    frame: [[f32; 3]; 3],
    sine: f32,
    shift: f32,
    turn: f32,
    /// O, z and C of the origin o.
    origin: [f32; 3],
    z: f32,
    power: f32,
    /// Whether o is far away: then C is a small difference of its large one, and O of a line tells it more exactly.
    origin_is_far: bool,
    /// The square of a line's O below which that is so, wherever o is.
    short: f32,
    /// W, and v_a.
    direction: [f32; 3],
    along: f32,
    /// E - F and E + F of the direction, or E and F if the apex is inside.
    factors: [f32; 2],
    /// The changes of E with delta . e and delta . a, and of F with delta . f.
    per_delta: [f32; 3],
    apex_is_outside: bool,
    pub(crate) half: f32,
    /// The heights of the discs above the origin o.
    discs: [f32; 2],
}

/// The coefficients of one line.
pub(crate) struct Coefficients {
    /// A, B, C
    pub(crate) abc: [f32; 3],
    /// W
    pub(crate) w: [f32; 3],
    /// O
    pub(crate) o: [f32; 3],
}

impl Profile {
    pub(crate) fn new(base: f64, top: f64, height: f64) -> Profile {
        let slant = libm::hypot(height, top - base);
        let (sine, cosine) = if slant > 0.0 { ((top - base) / slant, height / slant) } else { (0.0, 1.0) };
        let middle = (base / 2.0 + top / 2.0) * cosine;
        Profile { half: height / 2.0, radii: [base, top], radius: base.max(top), sine, cosine, middle }
    }

    /// The same in another unit.
    pub(crate) fn scaled(&self, by: f64) -> Profile {
        let radii = self.radii.map(|radius| radius * by);
        Profile { half: self.half * by, radii, radius: self.radius * by, middle: self.middle * by, ..*self }
    }

    fn m(&self, z: f64) -> f64 {
        // Exactly 0 at the tip of a cone.
        let [base, top] = self.radii.map(|radius| radius * self.cosine);
        if z == self.half {
            top
        } else if z == -self.half {
            base
        } else {
            self.middle + self.sine * z
        }
    }

    /// Half the height, and a radius for each of the other axes.
    pub(crate) fn size(&self) -> f64 {
        self.half + 2.0 * self.radius
    }
}

impl Frustum {
    /// Return where a point is relative to a frustum; `local` is its distance from the axis, its height above the
    /// middle and its height above the side.
    pub(crate) fn contact(point: Vector, center: Vector, axis: Vector, profile: &Profile) -> Contact {
        let relative = sub(point, center);
        let z = dot(relative, axis);
        let away = length(sub(relative, scale(axis, z)));
        let on_disc = rounding_across(axis, point, center, (profile.half, profile.size()));
        let z = if (z.abs() - profile.half).abs() <= on_disc { profile.half.copysign(z) } else { z };
        let height = profile.cosine * away - profile.m(z);
        let height = if height.abs() <= rounding(point, center, profile.size()) { 0.0 } else { height };
        Contact::new(height.max(z.abs() - profile.half), [away, z, height])
    }

    /// Make a frustum; `eye` is given if it is close to the surface.
    pub(crate) fn new(center: Vector, axis: Vector, profile: Profile, eye: Option<&Contact>) -> Frustum {
        let origin = [0.0; 3];
        let nowhere = Place { weight: 1.0, radial: origin, away: 0.0, z: 0.0, height: 0.0, origin, power: 0.0 };
        let mut frustum = Frustum { center, axis, profile, eye: nowhere };
        frustum.eye = frustum.place(Apex::point(origin), eye);
        frustum
    }

    /// Transform a frustum at a scaled position to camera space; its profile is scaled too.
    pub(crate) fn transform(
        space: &CameraSpace,
        (position, axis): (Vector, Vector),
        profile: &Profile,
        range_scale: f64,
    ) -> Frustum {
        let center = scale(space.point(position), range_scale);
        let eye = Frustum::contact(space.eye, position, axis, profile);
        let profile = profile.scaled(range_scale);
        let close = eye.is_within(FAR_ABOVE_ROUNDING * (l1_norm(center) + profile.size()));
        Frustum::new(center, space.direction(axis), profile, close.then_some(&eye))
    }

    /// Return where an apex is; `contact` is given if it is close to the surface.
    #[inline(always)]
    pub(crate) fn place(&self, apex: Apex, contact: Option<&Contact>) -> Place {
        let profile = &self.profile;
        let relative = apex.way_from(self.center);
        let z = dot(relative, self.axis);
        let radial = sub(relative, scale(self.axis, z));
        let away = length(radial);
        // E multiplies what rounding leaves along the axis by the distance: that is removed again. Of a point on the
        // axis it may be all.
        let across = scale(radial, 1.0 / away);
        let across = sub(across, scale(self.axis, dot(across, self.axis)));
        let size = length(across);
        let radial = if size > 0.5 { scale(across, 1.0 / size) } else { perpendicular(self.axis) };
        if apex.is_direction() {
            // A direction along the axis, within rounding, has no part across it.
            let away = if away < ROUNDING { 0.0 } else { away };
            let (across, along) = (profile.cosine * away, profile.sine * z);
            let power = (across - along) * (across + along);
            return Place { weight: 0.0, radial, away, z, height: 1.0, origin: [across, 0.0, along], power };
        }
        let [away, z, height] =
            contact.map_or_else(|| [away, z, profile.cosine * away - profile.m(z)], |contact| contact.local);
        let m = profile.m(z);
        let origin = [if height == 0.0 { m } else { profile.cosine * away }, 0.0, m];
        Place { weight: 1.0, radial, away, z, height, origin, power: height * (origin[0] + origin[2]) }
    }

    /// The side of an apex that is not close to the surface.
    #[inline(always)]
    fn side_of(&self, place: &Place) -> Side {
        if place.weight == 0.0 || place.height.max(place.z.abs() - self.profile.half) > 0.0 {
            Side::Outside
        } else {
            Side::Inside
        }
    }

    /// Whether the eye sees the outside; an eye on the surface sees the inside.
    #[inline(always)]
    fn eye_is_outside(&self) -> bool {
        self.side_of(&self.eye) == Side::Outside
    }

    /// The frame e, f, a of a place.
    #[inline(always)]
    fn frame(&self, place: &Place) -> [Vector; 3] {
        [place.radial, cross(place.radial, self.axis), self.axis]
    }

    /// W, and v_a.
    #[inline(always)]
    fn components(&self, frame: &[Vector; 3], v: Vector) -> (Vector, f64) {
        let [e, f, along] = rotate(frame, v);
        let Profile { sine, cosine, .. } = self.profile;
        ([cosine * e, cosine * f, sine * along], along)
    }

    /// The lines through an apex with the directions v + turn delta, v = `middle`, from where the parameter of the
    /// line in the middle is `start`: at `from`. Of an apex at infinity, both `start` and `turn` are negative and have
    /// the product 1, and all directions are v.
    #[inline(always)]
    pub(crate) fn lines(
        &self,
        apex: &Place,
        (start, from): (f64, Vector),
        (middle, turn): (Vector, f64),
    ) -> Lines {
        let profile = &self.profile;
        let frame = self.frame(apex);
        let (mut w, along) = self.components(&frame, middle);
        if apex.weight == 0.0 && apex.away == 0.0 {
            // Along the axis exactly, as D has it: else the roots of A, B and C do not belong to it.
            (w[0], w[1]) = (0.0, 0.0);
        }
        let per = 1.0 / profile.radius;
        let [o_1, _, o_3] = scale(apex.origin, per);
        let root = apex.power.abs().sqrt() * per;
        let (o, z, power, (e, f)) = if start * length(middle) < NEAR * profile.radius && start >= 0.0 {
            let o = add(apex.origin, scale(w, start));
            let change = start * (2.0 * minkowski(apex.origin, w) + start * minkowski(w, w));
            let factors = (o_3 * w[0] - o_1 * w[2], root * w[1]);
            (o, apex.z + start * along, apex.power + change, factors)
        } else {
            let (o, z) = self.components(&frame, sub(from, self.center));
            let o = [o[0], o[1], profile.middle + o[2]];
            // W is (o - O) / start, and an apex may be so far away that only this does not cancel.
            let factors = ((o_3 * o[0] - o_1 * o[2]) / start, root * o[1] / start);
            (o, z, minkowski(o, o), factors)
        };
        let apex_is_outside = apex.power > 0.0;
        let cosine = profile.cosine;
        Lines {
            frame: [scale(frame[0], cosine), scale(frame[1], cosine), frame[2]].map(to_f32),
            sine: profile.sine as f32,
            shift: (start * turn * per) as f32,
            turn: (turn * apex.weight) as f32,
            origin: to_f32(scale(o, per)),
            z: (z * per) as f32,
            power: (power * per * per) as f32,
            origin_is_far: dot(o, o) > FAR * FAR * profile.radius * profile.radius,
            short: (SHORT * dot(o, o) * per * per) as f32,
            direction: to_f32(w),
            along: along as f32,
            factors: if apex_is_outside { [e - f, e + f] } else { [e, f] }.map(|factor| factor as f32),
            per_delta: to_f32(scale([o_3, -o_1 * profile.sine, root], turn)),
            apex_is_outside,
            half: (profile.half * per) as f32,
            // In float64: the eye may be close to a disc.
            discs: [-profile.half - z, profile.half - z].map(|height| (height * per) as f32),
        }
    }

    /// The apex of a pencil of rays that a ray belongs to.
    #[inline(always)]
    fn apex_of(&self, parallel: bool, direction: Vector) -> Place {
        if parallel { self.place(Apex::direction(direction), None) } else { self.eye }
    }

    /// The lines of a tile's rays, relative to one of them, from a depth of it on.
    #[inline(always)]
    pub(crate) fn lines_of_rays(&self, rays: &Rays, (origin, direction): (Vector, Vector), start: f64) -> Lines {
        let from = add(origin, scale(direction, start));
        let (start, turn) = if rays.are_parallel() { (-1.0, -1.0) } else { (start, 1.0) };
        self.lines(&self.apex_of(rays.are_parallel(), direction), (start, from), (direction, turn))
    }

    /// Compute the points where rays hit the side, with normals that face the eye, relative to the nearest: at depth
    /// `t` of the ray `nearest`.
    ///
    /// n = cos(alpha) (P - foot) / |P - foot| - sin(alpha) a
    #[inline(always)]
    pub(crate) fn points_on_side(
        &self,
        face: u32,
        (t, nearest): (f64, impl Fn() -> Ray),
        rays: &Rays,
        points: &mut Points,
    ) {
        let Ray { origin, direction, .. } = nearest();
        let reference = add(origin, scale(direction, t));
        let lines = self.lines_of_rays(rays, (origin, direction), t);
        let [x_0, y_0, _] = to_f32(add(sub(direction, rays.middle), sub(origin, rays.origin)));
        let Profile { cosine, sine, radius, .. } = self.profile;
        let frame = self.frame(&self.apex_of(rays.are_parallel(), direction));
        let outside = !from_inside(face);
        let turn = if outside { 1.0 } else { -1.0 };
        let [e, f] = [scale(frame[0], turn * cosine), scale(frame[1], turn * cosine)].map(to_f32);
        let a = to_f32(scale(frame[2], -turn * sine));
        let (divergence, radius) = (rays.divergence(t) as f32, radius as f32);
        for lane in 0..points.padded() {
            let (dx, dy) = (rays.dx[lane] - x_0, rays.dy[lane] - y_0);
            let x = lines.across(dx, dy);
            let d = lines.discriminant(x);
            let s = if d > 0.0 { d.sqrt() } else { 0.0 };
            let Coefficients { abc, w, o } = lines.coefficients::<false, false>(x);
            let (enter, leave) = span(abc, w[2], s);
            let tau = if outside { enter } else { leave };
            let (r_e, r_f) = (o[0] + tau * w[0], o[1] + tau * w[1]);
            let away = (r_e * r_e + r_f * r_f).sqrt();
            let (r_e, r_f) = (r_e / away, r_f / away);
            let v = [rays.x[lane], rays.y[lane], 1.0];
            // The normal at the tip of a cone faces the eye.
            let to_eye = -1.0 / rays.vv[lane].sqrt();
            let tau = tau * radius;
            let across = [divergence * dx, divergence * dy, 0.0];
            for i in 0..3 {
                let normal = r_e * e[i] + r_f * f[i] + a[i];
                points.normal[i][lane] = if away > 0.0 { normal } else { to_eye * v[i] };
                points.offset[i][lane] = across[i] + tau * v[i];
            }
        }
        points.reference = reference;
    }

    /// The planes through the eye that touch the side, and those at right angles to its section through the axis and
    /// the eye that are `tangents` to it; by their normals toward the frustum.
    pub(crate) fn planes_around(&self, tangents: impl Iterator<Item = [f64; 2]>) -> Vec<Vector> {
        let Place { origin: [o_1, _, o_3], power, .. } = self.eye;
        let Profile { sine, cosine, .. } = self.profile;
        let [e, f, a] = self.frame(&self.eye);
        let mut planes: Vec<Vector> = tangents.map(|[x, z]| add(scale(e, x), scale(a, z))).collect();
        if power > 0.0 {
            let middle = add(scale(e, -o_3 * cosine), scale(a, o_1 * sine));
            planes.extend([power.sqrt(), -power.sqrt()].map(|root| add(middle, scale(f, root * cosine))));
        }
        planes
    }

    /// The sign of a disc's outward normal along the axis.
    fn disc(face: u32) -> f64 {
        if Frustum::part(face) == TOP { 1.0 } else { -1.0 }
    }

    /// The number of a face in this shape.
    fn part(face: u32) -> u32 {
        (face % (1 << FACE_BITS)) & !INSIDE
    }

    /// The smallest bounding sphere: around the middle of the largest distances, or around the larger disc.
    fn bounding_sphere(&self) -> BoundingSphere {
        let Profile { half, radius, radii: [base, top], .. } = self.profile;
        // 0 for a cylinder, however flat.
        let z = if half > 0.0 && top != base { (top - base) * ((top + base) / (4.0 * half)) } else { 0.0 };
        if z.abs() >= half {
            let end = if top > base { half } else { -half };
            return BoundingSphere { center: add(self.center, scale(self.axis, end)), radius };
        }
        let radius = libm::hypot(half + z, base).max(libm::hypot(half - z, top));
        BoundingSphere { center: add(self.center, scale(self.axis, z)), radius }
    }

    /// Return the way to the light from the points' reference, and a length to measure all ways by. The reference
    /// may be at the light. Infinitely far away, the way is a unit vector.
    #[inline(always)]
    fn way_to_light(shadow: &ShadowRays<'_>) -> (Vector, f64) {
        let reference = shadow.points.reference;
        let way = shadow.light.way_from(reference);
        if shadow.light.is_direction() {
            return (way, 1.0);
        }
        (way, length(way) + length(sub(shadow.bounds.center, reference)) + shadow.bounds.radius)
    }

    /// Whether a light `away` is so distant from points within a radius that the frustum among them is surely before it.
    /// Rounding may move such a light by more than the size of the frustum; and a direction along the side has no part
    /// across it to decide by.
    #[inline(never)] // once for each light and part of a picture, beside loops that it made slower
    fn is_surely_before(&self, light: &Place, away: f64, radius: f64) -> bool {
        light.weight == 0.0 || away > DISTANT_LIGHT * (radius + self.profile.size())
    }

    /// Darken the points from which the frustum hides the light, all of them outside its bounding sphere: it does
    /// where the line is inside between the two. Lines begin at the nearer end.
    #[inline(always)]
    fn occlude_from_afar(&self, light: &Place, begin_at_light: bool, shadow: &mut ShadowRays<'_>) {
        let (way, end) = Frustum::way_to_light(shadow);
        let per = 1.0 / end;
        let lines = if begin_at_light {
            self.lines(light, (0.0, shadow.light.at), (scale(way, -per), per))
        } else {
            self.lines(light, (-end, shadow.points.reference), (scale(way, per), -per))
        };
        let end = if light.weight == 0.0 { f32::INFINITY } else { (end / self.profile.radius) as f32 };
        let points = shadow.points;
        for lane in 0..points.padded() {
            let x = lines.across_point(points.offset_of(lane));
            let d = lines.discriminant(x);
            let Coefficients { abc, w, .. } = lines.coefficients::<false, false>(x);
            let (enter, leave) = span(abc, w[2], d.sqrt());
            let (near, far) = lines.slab(x);
            let enter = larger(larger(near, 0.0), enter);
            let leave = smaller(smaller(far, end), leave);
            shadow.darken(lane, (d >= 0.0) & (enter < leave));
        }
    }

    /// Darken the points from which the frustum hides the light; some may be inside, or on the surface.
    ///
    /// A point on the side, within rounding, has C = 0; one on a disc that the light is beyond is not before it.
    #[inline(always)]
    pub(crate) fn occlude_nearby(&self, light: &Place, contact: Option<&Contact>, shadow: &mut ShadowRays<'_>) {
        let Profile { half, radius, .. } = self.profile;
        let side = contact.map_or_else(|| self.side_of(light), |contact| contact.side);
        let (inside, on) = (side == Side::Inside, side == Side::On);
        let (way, end) = Frustum::way_to_light(shadow);
        let lines = self.lines(light, (-end, shadow.points.reference), (scale(way, 1.0 / end), -1.0 / end));
        let per = 1.0 / radius;
        let rounding = shadow.rounding_at_points(l1_norm(self.center) + self.profile.size());
        let at_light = if contact.is_some() { 0.0 } else { shadow.rounding_at_light(l1_norm(self.center) + half) };
        // How far a hidden point may be along the axis, and against it.
        let limit = [1.0, -1.0].map(|sign| {
            let beyond =
                if light.weight == 0.0 { sign * light.z > 0.0 } else { sign * light.z >= half - at_light };
            (if beyond { (half - rounding) * per } else { f64::INFINITY }) as f32
        });
        let is_within_or_far = light.power < 0.0 || self.is_surely_before(light, end, shadow.bounds.radius);
        let [o_1, _, o_3] = to_f32(scale(light.origin, per));
        let (per, rounding) = (per as f32, (rounding * per) as f32);
        let points = shadow.points;
        for lane in 0..points.padded() {
            let x = lines.across_point(points.offset_of(lane));
            let d = lines.discriminant(x);
            let Coefficients { abc: [a, b, c], w, o } = lines.coefficients::<false, true>(x);
            let slack = points.slack(lane) * per + rounding;
            // C at a height h is h (h + 2 m).
            let touching = 2.0 * slack * (o[2].abs() + slack);
            let z = lines.z + lines.shift * x[2];
            let above = (c > touching) | (z.abs() > lines.half + slack);
            let before = (z + slack < limit[0]) & (slack - z < limit[1]);
            // From the light, the line goes into the side: toward the wider end, if A < 0.
            let toward = if a < 0.0 { w[2] < 0.0 } else { o_1 * w[0] - o_3 * w[2] > 0.0 };
            let toward = is_within_or_far | toward;
            let c = if c.abs() <= touching { 0.0 } else { c };
            let (enter, leave) = span([a, b, c], w[2], d.sqrt());
            let (near, far) = lines.slab(x);
            let crosses = (d >= 0.0) & (larger(larger(near, 0.0), enter) < smaller(far, leave));
            let hidden = (inside & above) | (!inside & crosses & before & toward & (above | !on));
            shadow.darken(lane, hidden);
        }
    }

    #[inline(always)]
    fn intersect_pencil<const PARALLEL: bool>(&self, face: u32, rays: &Rays, hits: &mut HitBuffer) {
        let eye_is_outside = self.eye_is_outside();
        let start = self.bounding_sphere().begin(rays);
        let lines = self.lines_of_rays(rays, (rays.origin, rays.middle), f64::from(start));
        let ((limit, rounding), radius) = (rays.limits(), self.profile.radius as f32);
        let on_disc = at_a_slant(rounding, dot(self.axis, rays.middle));
        let mut close = 0;
        for test in 0..LANES / RAYS_PER_TEST {
            let [dx, dy] = [&rays.dx, &rays.dy].map(|lanes| &lanes.as_chunks::<RAYS_PER_TEST>().0[test]);
            let Some(discriminant) = lines.discriminants(dx, dy) else { continue };
            let best = &mut hits.t.as_chunks_mut::<RAYS_PER_TEST>().0[test];
            let faces = &mut hits.face.as_chunks_mut::<RAYS_PER_TEST>().0[test];
            for i in 0..RAYS_PER_TEST {
                let x = lines.across(dx[i], dy[i]);
                let Coefficients { abc, w, .. } = lines.coefficients::<PARALLEL, PARALLEL>(x);
                let (lower, upper) = span(abc, w[2], discriminant[i].sqrt());
                let (near, far) = lines.slab(x);
                let (enter, leave) = (larger(near, lower), smaller(far, upper));
                let outside = if PARALLEL { start + enter * radius > limit } else { eye_is_outside };
                let (tau, disc) = if outside { (enter, near > lower) } else { (leave, far < upper) };
                let rising = lines.along + lines.turn * x[2] > 0.0;
                let number = if rising == outside { BASE } else { TOP };
                let met = (discriminant[i] >= 0.0) & (enter <= leave);
                let t = if met { start + tau * radius } else { 0.0 };
                let face = face + if disc { number } else { SIDE } + if outside { 0 } else { INSIDE };
                let hit = (&mut best[i], &mut faces[i]);
                let limits = (limit, if disc { on_disc } else { rounding });
                close += if PARALLEL { offer_parallel(hit, limits, t, face) } else { offer(hit, t, face) };
            }
        }
        hits.close += close;
    }
}

impl Primitive for Frustum {
    /// Offer the hits of rays: a ray is in the frustum where it is inside the side and between the discs.
    #[inline(always)]
    fn intersect(&self, face: u32, rays: &Rays, hits: &mut HitBuffer) {
        if rays.are_parallel() {
            self.intersect_pencil::<true>(face, rays, hits);
        } else {
            self.intersect_pencil::<false>(face, rays, hits);
        }
    }

    fn depth(&self, ray: Ray) -> (f64, f64) {
        let Profile { half, .. } = self.profile;
        let side = SideOfRay::new(self, ray);
        let (low, high) = ((-half - side.z) / side.along, (half - side.z) / side.along);
        let (near, far) = if side.along != 0.0 {
            (low.min(high), low.max(high))
        } else if side.z.abs() > half {
            (f64::INFINITY, f64::NEG_INFINITY)
        } else {
            (f64::NEG_INFINITY, f64::INFINITY)
        };
        let (enter, leave) = (larger(near, side.enter), smaller(far, side.leave));
        let outside = if side.parallel { enter > ray.start } else { self.eye_is_outside() };
        let (t, disc) = if outside { (enter, near > side.enter) } else { (leave, far < side.leave) };
        if !(enter <= leave && t > ray.start) {
            return (f64::INFINITY, 0.0);
        }
        (t, if disc { side.along.abs() } else { side.steepness(t) })
    }

    #[inline(always)]
    fn compute_points(&self, face: u32, rays: &Rays, depth: (f64, impl Fn() -> Ray), points: &mut Points) {
        if Frustum::part(face) == SIDE {
            self.points_on_side(face, depth, rays, points);
        } else {
            let sign = Frustum::disc(face);
            let offset = self.profile.half - sign * self.eye.z;
            let plane = PlaneEquation { normal: scale(self.axis, sign), offset };
            plane.facing_the_eye(face).compute_points(depth.0, rays, points);
        }
    }

    #[inline(always)]
    fn occlude(&self, contact: Option<&Contact>, shadow: &mut ShadowRays<'_>) {
        let light = self.place(shadow.light, contact);
        let bounds = self.bounding_sphere();
        let apart = length(sub(bounds.center, shadow.bounds.center)) - shadow.bounds.radius;
        if apart > bounds.radius * CLEAR {
            let from_light = length(shadow.light.way_from(bounds.center));
            let nearer = from_light < length(sub(bounds.center, shadow.points.reference));
            let nearer = nearer && !shadow.light.is_direction();
            self.occlude_from_afar(&light, contact.is_some() || nearer, shadow);
        } else {
            self.occlude_nearby(&light, contact, shadow);
        }
    }

    #[inline(always)]
    fn is_lit_from(&self, face: u32, contact: Option<&Contact>, light: Apex) -> bool {
        let side = contact.map_or_else(|| self.side_of(&self.place(light, None)), |contact| contact.side);
        side.illuminates(from_inside(face))
    }

    #[inline(always)]
    fn height(&self, face: u32, light: &Contact) -> f64 {
        let outward = Frustum::disc(face) * light.local[1] - self.profile.half;
        if from_inside(face) { -outward } else { outward }
    }

    fn magnitude(&self) -> f64 {
        l1_norm(self.center) + self.profile.size()
    }

    #[inline(always)]
    fn magnitude_across(&self, face: u32) -> f64 {
        let flat = Frustum::part(face) != SIDE;
        if flat { l1_norm(self.center) + 2.0 * self.profile.half } else { self.magnitude() }
    }

    fn bounds(&self) -> Option<BoundingSphere> {
        Some(self.bounding_sphere())
    }

    fn outline(&self, projection: Projection) -> Outline {
        let Profile { half, radius, .. } = self.profile;
        if projection == Projection::Orthographic {
            return Outline::of_cylinder_in_parallel(self.center, scale(self.axis, half), radius);
        }
        let beyond = (1.0 + self.eye.height / radius).max(self.eye.z.abs() / half);
        Outline::between(beyond, &[half, radius], || {
            let [base, top] = self.profile.radii;
            // The corners of the section, from the eye.
            let corners = [[base, -half], [-base, -half], [top, half], [-top, half]];
            let corners = corners.map(|[x, z]| [x - self.eye.away, z - self.eye.z]);
            let normals = corners.into_iter().flat_map(|[x, z]| [[-z, x], [z, -x]]);
            self.planes_around(normals.filter(|[x, z]| {
                let rounding = ROUNDING * (x.abs() + z.abs()) * (l1_norm(self.center) + self.profile.size());
                corners.iter().all(|corner| x * corner[0] + z * corner[1] >= -rounding)
            }))
        })
    }
}

/// Points farther from a frustum than this multiple of its bounding radius do not touch it.
const CLEAR: f64 = 1.0001;

/// The side and one ray from the eye, or one of parallel rays, in float64.
pub(crate) struct SideOfRay {
    pub(crate) parallel: bool,
    /// v_a
    pub(crate) along: f64,
    /// The height of the ray's origin above the middle.
    pub(crate) z: f64,
    /// Where the ray is inside the side; NaN if it misses it.
    pub(crate) enter: f64,
    pub(crate) leave: f64,
    /// sqrt(D)
    root: f64,
    /// O_3 and W_3
    m: f64,
    m_along: f64,
}

impl SideOfRay {
    pub(crate) fn new(frustum: &Frustum, ray: Ray) -> SideOfRay {
        let v = ray.direction;
        let relative = sub(ray.origin, frustum.center);
        // B and C of a distant origin lose digits: the roots are measured from the nearest point to the middle.
        let begin = -dot(relative, v) / dot(v, v);
        let at = |frame: &[Vector; 3], begin: f64| {
            let ([o_1, o_2, o_3], _) = frustum.components(frame, add(relative, scale(v, begin)));
            [o_1, o_2, frustum.profile.middle + o_3]
        };
        // Rays from the eye begin there.
        let parallel = ray.origin != [0.0; 3];
        let apex = frustum.apex_of(parallel, v);
        let frame = frustum.frame(&apex);
        let (w, along) = frustum.components(&frame, v);
        let (o, power) = (apex.origin, apex.power);
        if parallel {
            let p = at(&frame, begin);
            let (e, f) = (o[2] * p[0] - o[0] * p[2], power.abs().sqrt() * p[1]);
            let root = root_of(power, e, f);
            let (enter, leave) = span([power, -minkowski(p, w), minkowski(p, p)], w[2], root);
            let (z, m) = (dot(relative, frustum.axis), p[2] - begin * w[2]);
            return SideOfRay {
                parallel,
                along,
                z,
                enter: begin + enter,
                leave: begin + leave,
                root,
                m,
                m_along: w[2],
            };
        }
        let (e, f) = (o[2] * w[0] - o[0] * w[2], power.abs().sqrt() * w[1]);
        let root = root_of(power, e, f);
        let far = begin * length(v) > DISTANT * frustum.profile.size();
        let (begin, b, c) = if far {
            let o = at(&frame, begin);
            (begin, -minkowski(o, w), minkowski(o, o))
        } else {
            (0.0, -minkowski(o, w), power)
        };
        let (enter, leave) = span([minkowski(w, w), b, c], w[2], root);
        let (enter, leave) = (begin + enter, begin + leave);
        SideOfRay { parallel, along, z: frustum.eye.z, enter, leave, root, m: o[2], m_along: w[2] }
    }

    /// |n.v| where the ray meets the side.
    pub(crate) fn steepness(&self, t: f64) -> f64 {
        self.root / (self.m + t * self.m_along)
    }
}

/// sqrt(D) from the power of the apex, E and F.
fn root_of(power: f64, e: f64, f: f64) -> f64 {
    if power > 0.0 { (e - f) * (e + f) } else { e * e + f * f }.sqrt()
}

impl Lines {
    /// (cos(alpha) delta_e, cos(alpha) delta_f, delta_a) of a ray of a tile.
    #[inline(always)]
    pub(crate) fn across(&self, dx: f32, dy: f32) -> [f32; 3] {
        // Written out, here and below: a closure that is not inlined stops the loop from vectorizing.
        let [e, f, a] = &self.frame;
        [e[0] * dx + e[1] * dy, f[0] * dx + f[1] * dy, a[0] * dx + a[1] * dy]
    }

    /// The same of a point.
    #[inline(always)]
    fn across_point(&self, p: [f32; 3]) -> [f32; 3] {
        let [e, f, a] = &self.frame;
        [product(e, p), product(f, p), product(a, p)]
    }

    #[inline(always)]
    pub(crate) fn discriminant(&self, x: [f32; 3]) -> f32 {
        let e = self.per_delta[0] * x[0] + self.per_delta[1] * x[2];
        let f = self.per_delta[2] * x[1];
        let [first, second] = self.factors;
        if self.apex_is_outside {
            (first + (e - f)) * (second + (e + f))
        } else {
            (first + e) * (first + e) + (second + f) * (second + f)
        }
    }

    /// D of some rays, None if all of them miss the side.
    #[inline(always)]
    pub(crate) fn discriminants(
        &self,
        dx: &[f32; RAYS_PER_TEST],
        dy: &[f32; RAYS_PER_TEST],
    ) -> Option<[f32; RAYS_PER_TEST]> {
        let mut discriminant = [0.0; RAYS_PER_TEST];
        let mut met = 0;
        for i in 0..RAYS_PER_TEST {
            let d = self.discriminant(self.across(dx[i], dy[i]));
            discriminant[i] = d;
            met |= u32::from(d >= 0.0);
        }
        (met != 0).then_some(discriminant)
    }

    /// The coefficients of a line; those of `PARALLEL` rays share W, and lines may begin `ANYWHERE`, also on the side.
    #[inline(always)]
    pub(crate) fn coefficients<const PARALLEL: bool, const ANYWHERE: bool>(&self, x: [f32; 3]) -> Coefficients {
        let x = [x[0], x[1], self.sine * x[2]];
        let (v, p) = (&self.direction, &self.origin);
        let turned = [v[0] + self.turn * x[0], v[1] + self.turn * x[1], v[2] + self.turn * x[2]];
        let w = if PARALLEL { *v } else { turned };
        let shifted = [self.shift * x[0], self.shift * x[1], self.shift * x[2]];
        let o = [p[0] + shifted[0], p[1] + shifted[1], p[2] + shifted[2]];
        let sum = [p[0] + o[0], p[1] + o[1], p[2] + o[2]];
        let a = w[0] * w[0] + w[1] * w[1] - w[2] * w[2];
        let b = o[2] * w[2] - o[0] * w[0] - o[1] * w[1];
        let change = sum[0] * shifted[0] + sum[1] * shifted[1] - sum[2] * shifted[2];
        let from_o = o[0] * o[0] + o[1] * o[1] - o[2] * o[2];
        let c = if self.origin_is_far { from_o } else { self.power + change };
        let is_short = ANYWHERE & (o[0] * o[0] + o[1] * o[1] + o[2] * o[2] < self.short);
        let c = if is_short { from_o } else { c };
        Coefficients { abc: [a, b, c], w, o }
    }

    /// The height above the middle where the line's parameter is tau.
    #[inline(always)]
    pub(crate) fn height(&self, x: [f32; 3], tau: f32) -> f32 {
        self.z + self.shift * x[2] + tau * (self.along + self.turn * x[2])
    }

    /// Where a line is between the discs: everywhere or nowhere if it is parallel to them.
    #[inline(always)]
    fn slab(&self, x: [f32; 3]) -> (f32, f32) {
        let shift = self.shift * x[2];
        let (base, top) = (self.discs[0] - shift, self.discs[1] - shift);
        let along = self.along + self.turn * x[2];
        let inverse = 1.0 / along;
        let (low, high) = (base * inverse, top * inverse);
        let (near, far) = if along >= 0.0 { (low, high) } else { (high, low) };
        let parallel = along == 0.0;
        let outside = if (base > 0.0) | (top < 0.0) { f32::INFINITY } else { f32::NEG_INFINITY };
        (if parallel { outside } else { near }, if parallel { -outside } else { far })
    }
}

/// Scalar product.
#[inline(always)]
fn product(a: &[f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// <X, Y>
#[inline(always)]
fn minkowski(x: Vector, y: Vector) -> f64 {
    x[0] * y[0] + x[1] * y[1] - x[2] * y[2]
}

/// Where a line is inside the side, from A, B, C, W_3 and sqrt(D).
///
/// Where A < 0 the roots are on both nappes, and the line is inside from one of them on: toward the wider end.
#[inline(always)]
pub(crate) fn span<T>([a, b, c]: [T; 3], w_3: T, root: T) -> (T, T)
where
    T: Copy + PartialOrd + From<f32> + Add<Output = T> + Sub<Output = T> + Div<Output = T>,
{
    let (zero, infinity) = (T::from(0.0), T::from(f32::INFINITY));
    let ahead = b >= zero;
    let q = if ahead { b + root } else { b - root };
    let one = if c == zero { zero } else { c / q };
    let never = if ahead { infinity } else { zero - infinity };
    let other = if a == zero { never } else { q / a };
    let (lower, upper) = if ahead { (one, other) } else { (other, one) };
    let lower = if (a < zero) & (w_3 < zero) { zero - infinity } else { lower };
    let upper = if (a < zero) & (w_3 > zero) { infinity } else { upper };
    (lower, upper)
}

/// The larger of two numbers; the second if one is NaN.
#[inline(always)]
fn larger<T: PartialOrd>(a: T, b: T) -> T {
    if a > b { a } else { b }
}

/// The smaller of two numbers; the second if one is NaN.
#[inline(always)]
fn smaller<T: PartialOrd>(a: T, b: T) -> T {
    if a < b { a } else { b }
}

#[cfg(test)]
mod tests;
