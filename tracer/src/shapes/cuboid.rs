//! A box turned about three axes (document, section 2.2.3); `Box` is taken in Rust.

use crate::apex::Apex;
use crate::bounds::BoundingSphere;
use crate::camera::Projection;
use crate::camera_space::{CameraSpace, FAR_FROM_ROUNDING};
use crate::shapes::contact::{Contact, Side, rounding_across};
use crate::shapes::outline::{Outline, corners, outline_planes};
use crate::shapes::points::{PlaneEquation, Points, ShadowRays};
use crate::shapes::primitive::{Description, FaceAxes, Primitive};
use crate::tile::LANES;
use crate::tile::hits::{FACE_BITS, HitBuffer, INSIDE, from_inside, offer, offer_parallel};
use crate::tile::rays::{Ray, Rays, at_a_slant};
use crate::vector::{Vector, add, cross, l1_norm, largest, length, rotate, scale, sub, to_f32};
use std::f64::consts::PI;

/// Axes, and a sign and a limit along each: a point p is before the faces where sign p < limit.
type Before = ([[f32; 3]; 3], [f32; 3], [f32; 3]);

/// Points and lights are within this distance of each other, 2^64: longer sides would overflow float32.
const LONGEST: f64 = (1_u128 << 64) as f64;

/// Beyond this, 2^120, lengths and moments may overflow float32.
const OVERFLOWING: f64 = (1_u128 << 120) as f64;

#[derive(Clone, Debug)]
pub(crate) struct Cuboid {
    pub(crate) center: Vector,
    /// Its axes, unit vectors.
    pub(crate) axes: [Vector; 3],
    /// Half its size along them.
    pub(crate) half: Vector,
    /// The eye relative to the centre, along the axes; exactly on a face if it is on one.
    pub(crate) eye: Vector,
}

/// A box around its position, turned in any way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CuboidDesc {
    /// Width (x), height (y), depth (z).
    pub size: Vector,
    /// Degrees about the axes of the world: it is turned about x, then y, then z.
    pub rotation: Vector,
}

impl CuboidDesc {
    /// Half the size, scaled.
    fn half(&self, space: &CameraSpace) -> Vector {
        space.scaled(self.size).map(|side| side / 2.0)
    }
}

impl Description for CuboidDesc {
    const PARAMETERS: usize = 6;

    type Shape = Cuboid;

    fn new(parameters: &[f64]) -> CuboidDesc {
        let p = parameters;
        CuboidDesc { size: [p[0], p[1], p[2]], rotation: [p[4], p[3], p[5]] }
    }

    fn size(&self) -> f64 {
        largest(self.size)
    }

    fn contact(&self, space: &CameraSpace, position: Vector, point: Vector) -> Contact {
        Cuboid::contact(point, position, &box_axes(self.rotation), self.half(space))
    }

    fn face_axes(&self, space: &CameraSpace) -> Option<FaceAxes> {
        Some(FaceAxes(box_axes(self.rotation).map(|axis| space.direction(axis))))
    }

    fn transform(&self, space: &CameraSpace, position: Vector, range_scale: f64) -> Cuboid {
        let axes = box_axes(self.rotation).map(|axis| space.direction(axis));
        let center = scale(space.point(position), range_scale);
        let half = scale(self.half(space), range_scale);
        let eye = self.contact(space, position, space.eye);
        let close = eye.is_within(FAR_FROM_ROUNDING * (l1_norm(center) + length(half)));
        let eye = if close { eye.local } else { rotate(&axes, scale(center, -1.0)) };
        Cuboid { center, axes, half, eye }
    }
}

impl Cuboid {
    /// Return where a point is relative to a box.
    pub(crate) fn contact(point: Vector, center: Vector, axes: &[Vector; 3], half: Vector) -> Contact {
        let size = half[0] + half[1] + half[2];
        let local = rotate(axes, sub(point, center));
        let local: Vector = std::array::from_fn(|i| {
            let rounding = rounding_across(axes[i], point, center, (half[i], size));
            let on = (local[i].abs() - half[i]).abs() <= rounding;
            if on { half[i].copysign(local[i]) } else { local[i] }
        });
        let beyond = (0..3).fold(f64::NEG_INFINITY, |most: f64, i| most.max(local[i].abs() - half[i]));
        Contact::new(beyond, local)
    }

    /// Whether a point in the axes of the box is inside or on its surface. An eye on the surface sees the inside.
    #[inline(always)]
    fn inside(&self, local: Vector) -> bool {
        (0..3).all(|i| local[i].abs() <= self.half[i])
    }

    /// The side of a light that is not close to the surface.
    fn side(&self, light: Apex) -> Side {
        let inside = !light.is_direction() && self.inside(rotate(&self.axes, light.way_from(self.center)));
        if inside { Side::Inside } else { Side::Outside }
    }

    /// The axis of a face, and its sign.
    #[inline(always)]
    fn side_of(&self, face: u32) -> (usize, f64) {
        let number = face % (1 << FACE_BITS) / 2;
        // Rays enter at the face that looks against them, and leave at the one that looks along with them.
        let along = if number % 2 == 1 { 1.0 } else { -1.0 };
        let side = if from_inside(face) { along } else { -along };
        ((number / 2) as usize % 3, side)
    }

    /// The plane of a face, as `intersect` offered it, with its normal on the eye's side.
    #[inline(always)]
    fn face(&self, face: u32) -> PlaneEquation {
        let (axis, side) = self.side_of(face);
        let outward = scale(self.axes[axis], side);
        // The eye is known more exactly than the centre if that is far away along the face.
        let offset = self.half[axis] - side * self.eye[axis];
        PlaneEquation { normal: outward, offset }.facing_the_eye(face)
    }

    fn bounding_sphere(&self) -> BoundingSphere {
        BoundingSphere { center: self.center, radius: length(self.half) }
    }

    /// Darken the points outside, for a light that is inside, or on a face and the points are before it.
    #[inline(always)]
    fn occlude_from_inside(
        &self,
        reference: Vector,
        rounding: Vector,
        before: Before,
        shadow: &mut ShadowRays<'_>,
    ) {
        let (axes, sign, limit) = before;
        let low: [f32; 3] = std::array::from_fn(|i| (-self.half[i] - reference[i] - rounding[i]) as f32);
        let high: [f32; 3] = std::array::from_fn(|i| (self.half[i] - reference[i] + rounding[i]) as f32);
        let points = shadow.points;
        for lane in 0..points.padded() {
            let p = local(&axes, &points.offset, lane);
            let slack = points.slack(lane);
            let outside = (p[0] + slack < low[0])
                | (p[0] - slack > high[0])
                | (p[1] + slack < low[1])
                | (p[1] - slack > high[1])
                | (p[2] + slack < low[2])
                | (p[2] - slack > high[2]);
            let between = (sign[0] * p[0] + slack < limit[0])
                & (sign[1] * p[1] + slack < limit[1])
                & (sign[2] * p[2] + slack < limit[2]);
            shadow.darken(lane, outside & between);
        }
    }

    /// For each axis i the moment of the reference and h_j |e_k| + h_k |e_j|, for parallel lines in a direction, shrunk
    /// so that both fit float32. Beside moments that need it, the extent of the points is nothing.
    #[cold]
    #[inline(never)]
    fn long_moments(&self, direction: Vector, moment: Vector) -> [(f32, f32); 3] {
        std::array::from_fn(|i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let reach = self.half[j] * direction[k].abs() + self.half[k] * direction[j].abs();
            let shrink = (OVERFLOWING / moment[i].abs().max(reach)).min(1.0);
            ((shrink * moment[i]) as f32, (shrink * reach) as f32)
        })
    }

    /// Darken the points from which the box hides the light.
    ///
    /// In the axes of the box, with the light at L and the point at P = L + e, by separating axes: the segment
    /// misses the box if both ends lie beyond one face, or if for some axis i, with j and k the others,
    ///
    /// |(L x P)_i| > h_j |e_k| + h_k |e_j|
    ///
    /// Of a light infinitely far away, L is its direction and e is -L.
    #[inline(always)]
    fn occlude_light<const PARALLEL: bool>(&self, contact: Option<&Contact>, shadow: &mut ShadowRays<'_>) {
        let light = contact
            .map_or_else(|| rotate(&self.axes, shadow.light.way_from(self.center)), |contact| contact.local);
        let reference = rotate(&self.axes, sub(shadow.points.reference, self.center));
        // The size of the box along a face adds no rounding across it.
        let away = l1_norm(self.center);
        let rounding = self.half.map(|half| shadow.rounding_at_points(away + half));
        let at_light =
            self.half.map(|half| if contact.is_some() { 0.0 } else { shadow.rounding_at_light(away + half) });
        // The light is beyond, or on, at most one of each pair of faces: a hidden point is before it.
        let (mut sign, mut limit) = ([0.0_f32; 3], [f32::INFINITY; 3]);
        let mut inside = true;
        for i in 0..3 {
            // A light infinitely far away is beyond a face unless its rays are parallel to it.
            let least = if PARALLEL { f64::MIN_POSITIVE } else { self.half[i] - at_light[i] };
            if light[i].abs() >= least {
                let side = light[i].signum();
                sign[i] = side as f32;
                limit[i] = (self.half[i] - side * reference[i] - rounding[i]) as f32;
                inside = false;
            }
        }
        // A light on a face is hidden from points outside that are before the face.
        if inside || contact.is_some_and(|contact| contact.side == Side::On) {
            let before = (self.axes.map(to_f32), sign, limit);
            self.occlude_from_inside(reference, rounding, before, shadow);
            return;
        }
        let axes = self.axes.map(to_f32);
        // From points and lights within range, longer sides look the same.
        let longest = if PARALLEL { f64::INFINITY } else { LONGEST };
        let half = to_f32([self.half[0].min(longest), self.half[1].min(longest), self.half[2].min(longest)]);
        let exact = cross(light, reference);
        let e = to_f32(sub(scale(reference, shadow.light.weight), light));
        let l = to_f32(light);
        // Of parallel lines, the right-hand side is the same for all.
        let (mut moment, mut reach) = (to_f32(exact), reaches(half, e));
        if PARALLEL && l1_norm(self.half) + l1_norm(exact) > OVERFLOWING {
            let [x, y, z] = self.long_moments(light, exact);
            (moment, reach) = ([x.0, y.0, z.0], [x.1, y.1, z.1]);
        }
        let points = shadow.points;
        for lane in 0..points.padded() {
            let p = local(&axes, &points.offset, lane);
            let reach = if PARALLEL { reach } else { reaches(half, [e[0] + p[0], e[1] + p[1], e[2] + p[2]]) };
            let m = [
                (moment[0] + (l[1] * p[2] - l[2] * p[1])).abs(),
                (moment[1] + (l[2] * p[0] - l[0] * p[2])).abs(),
                (moment[2] + (l[0] * p[1] - l[1] * p[0])).abs(),
            ];
            let slack = points.slack(lane);
            let between = (sign[0] * p[0] + slack < limit[0])
                & (sign[1] * p[1] + slack < limit[1])
                & (sign[2] * p[2] + slack < limit[2]);
            let crosses = (m[0] <= reach[0]) & (m[1] <= reach[1]) & (m[2] <= reach[2]);
            shadow.darken(lane, between & crosses);
        }
    }
}

impl Cuboid {
    /// Intersect the three slabs with parallel rays.
    ///
    /// Their direction v is the same for all, and they start at o + delta, so that with o's point at depth `start`
    /// a slab is entered and left at
    ///
    /// tau = (-+h - o) / (a . v) - (a . delta) / (a . v)
    #[inline(always)]
    fn intersect_parallel(&self, face: u32, rays: &Rays, hits: &mut HitBuffer) {
        let start = self.bounding_sphere().begin(rays);
        let along = rotate(&self.axes, rays.middle);
        let origin = add(rays.origin, scale(rays.middle, f64::from(start)));
        let from = add(self.eye, rotate(&self.axes, origin));
        // For each axis the number of its face, and near, far, and their change with x and y.
        let mut slabs = [(0, [0.0_f32; 4]); 3];
        // A slab that is parallel to the rays: each is between its faces for its whole length or not at all.
        let mut between = [[0.0, 0.0, f32::NEG_INFINITY, f32::INFINITY]; 3];
        for i in 0..3 {
            let (low, high) = (-self.half[i] - from[i], self.half[i] - from[i]);
            let [x, y, _] = self.axes[i];
            if along[i] == 0.0 {
                slabs[i].1 = [f32::NEG_INFINITY, f32::INFINITY, 0.0, 0.0];
                between[i] = [x, y, low, high].map(|number| number as f32);
                continue;
            }
            let (a, b) = (low / along[i], high / along[i]);
            let number = 4 * i as u32 + if along[i] > 0.0 { 2 } else { 0 };
            slabs[i] = (number, [a.min(b), a.max(b), -x / along[i], -y / along[i]].map(|number| number as f32));
        }
        let (limit, rounding) = rays.limits();
        let rounding = along.into_iter().fold(rounding, |most, along| match along {
            0.0 => most,
            _ => most.max(at_a_slant(rounding, along)),
        });
        let mut close = 0;
        for lane in 0..LANES {
            let (dx, dy) = (rays.dx[lane], rays.dy[lane]);
            let (mut enter, mut leave) = (f32::NEG_INFINITY, f32::INFINITY);
            let (mut entered, mut left) = (0, 0);
            let mut beside = false;
            for i in 0..3 {
                let (number, [near, far, x, y]) = slabs[i];
                let shift = x * dx + y * dy;
                let (near, far) = (near + shift, far + shift);
                entered = if near > enter { number } else { entered };
                enter = if near > enter { near } else { enter };
                left = if far < leave { number } else { left };
                leave = if far < leave { far } else { leave };
                let [x, y, low, high] = between[i];
                let across = x * dx + y * dy;
                beside |= (across < low) | (across > high);
            }
            let inside = start + enter <= limit;
            let tau = if inside { leave } else { enter };
            let number = if inside { left + INSIDE } else { entered };
            let t = if (enter <= leave) & !beside { start + tau } else { 0.0 };
            let hit = (&mut hits.t[lane], &mut hits.face[lane]);
            close += offer_parallel(hit, (limit, rounding), t, face + number);
        }
        hits.close += close;
    }
}

impl Primitive for Cuboid {
    /// Intersect the three slabs: a ray is in the box where it is in all of them.
    ///
    /// With v = middle + delta, o the middle ray's point at depth `start` relative to the box, and the parameter
    /// start + tau, a slab of half width h along the axis a is entered and left at
    ///
    /// tau = (-+h - o - start (a . delta)) / (a . v)
    ///
    /// A face is numbered `face`, plus four times its axis, plus 2 if the ray runs along the axis, plus `INSIDE`.
    #[inline(always)]
    fn intersect(&self, face: u32, rays: &Rays, hits: &mut HitBuffer) {
        let inside = self.inside(self.eye);
        if rays.are_parallel() {
            self.intersect_parallel(face, rays, hits);
            return;
        }
        let start = self.bounding_sphere().begin(rays);
        let middle = rotate(&self.axes, rays.middle);
        let from: Vector = add(self.eye, scale(middle, f64::from(start)));
        let middle = to_f32(middle);
        let axes = self.axes.map(to_f32);
        let low: [f32; 3] = std::array::from_fn(|i| (-self.half[i] - from[i]) as f32);
        let high: [f32; 3] = std::array::from_fn(|i| (self.half[i] - from[i]) as f32);
        let mut close = 0;
        for lane in 0..LANES {
            let (dx, dy) = (rays.dx[lane], rays.dy[lane]);
            let mut enter = f32::NEG_INFINITY;
            let mut leave = f32::INFINITY;
            let (mut entered, mut left) = (0, 0);
            for i in 0..3 {
                let across = axes[i][0] * dx + axes[i][1] * dy;
                let along = middle[i] + across;
                let inverse = 1.0 / along;
                let shift = start * across;
                let (a, b) = (low[i] - shift, high[i] - shift);
                // A ray parallel to two faces is between them for its whole length or not at all.
                let parallel = along == 0.0;
                let a = if parallel { beyond(a > 0.0) } else { a * inverse };
                let b = if parallel { -beyond(b < 0.0) } else { b * inverse };
                let forward = along >= 0.0;
                let (near, far) = if forward { (a, b) } else { (b, a) };
                let number = 4 * i as u32 + 2 * u32::from(forward);
                entered = if near > enter { number } else { entered };
                enter = if near > enter { near } else { enter };
                left = if far < leave { number } else { left };
                leave = if far < leave { far } else { leave };
            }
            let tau = if inside { leave } else { enter };
            let number = if inside { left + INSIDE } else { entered };
            let t = if enter <= leave { start + tau } else { 0.0 };
            close += offer((&mut hits.t[lane], &mut hits.face[lane]), t, face + number);
        }
        hits.close += close;
    }

    fn depth(&self, ray: Ray) -> (f64, f64) {
        let along = rotate(&self.axes, ray.direction);
        let from = add(self.eye, rotate(&self.axes, ray.origin));
        let (mut enter, mut leave) = ((f64::NEG_INFINITY, 0.0), (f64::INFINITY, 0.0));
        for i in 0..3 {
            if along[i] != 0.0 {
                let a = (-self.half[i] - from[i]) / along[i];
                let b = (self.half[i] - from[i]) / along[i];
                let (near, far) = (a.min(b), a.max(b));
                enter = if near > enter.0 { (near, along[i].abs()) } else { enter };
                leave = if far < leave.0 { (far, along[i].abs()) } else { leave };
            } else if from[i].abs() > self.half[i] {
                return (f64::INFINITY, 0.0);
            }
        }
        let met = if enter.0 > ray.start { enter } else { leave };
        if enter.0 <= leave.0 && met.0 > ray.start { met } else { (f64::INFINITY, 0.0) }
    }

    #[inline(always)]
    fn compute_points(&self, face: u32, rays: &Rays, (t, _): (f64, impl Fn() -> Ray), points: &mut Points) {
        self.face(face).compute_points(t, rays, points);
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
    fn height(&self, face: u32, light: &Contact) -> f64 {
        let (axis, side) = self.side_of(face);
        let outward = side * light.local[axis] - self.half[axis];
        if from_inside(face) { -outward } else { outward }
    }

    fn magnitude(&self) -> f64 {
        l1_norm(self.center) + 2.0 * length(self.half)
    }

    #[inline(always)]
    fn magnitude_across(&self, face: u32) -> f64 {
        l1_norm(self.center) + 2.0 * self.half[self.side_of(face).0]
    }

    fn bounds(&self) -> Option<BoundingSphere> {
        Some(self.bounding_sphere())
    }

    fn outline(&self, projection: Projection) -> Outline {
        if projection == Projection::Orthographic {
            return Outline::of_box_in_parallel(self.center, self.axes, self.half);
        }
        let [x, y, z] = self.half;
        // The largest coordinate of the eye, in half sizes.
        let beyond = (0..3).fold(0.0, |most: f64, i| most.max(self.eye[i].abs() / self.half[i]));
        Outline::between(beyond, &[x, y, z], || outline_planes(&corners(self.center, self.axes, self.half)))
    }
}

/// The axes of a box turned about x, then y, then z: the columns of R_z R_y R_x (document, section 2.2.3).
fn box_axes(degrees: Vector) -> [Vector; 3] {
    if let [0.0, about_y, 0.0] = degrees {
        // As most boxes are, so that many are ready sooner.
        let (sine, cosine) = sine_and_cosine(about_y);
        return [[cosine, 0.0, -sine], [0.0, 1.0, 0.0], [sine, 0.0, cosine]];
    }
    let mut axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for (about, degrees) in degrees.into_iter().enumerate() {
        let (sine, cosine) = sine_and_cosine(degrees);
        // Right-handed: x turns toward y about z, y toward z about x, z toward x about y.
        let (i, j) = ((about + 1) % 3, (about + 2) % 3);
        for axis in &mut axes {
            (axis[i], axis[j]) = (cosine * axis[i] - sine * axis[j], sine * axis[i] + cosine * axis[j]);
        }
    }
    axes
}

/// sin and cos of an angle, exact at multiples of 90 degrees, where a box is axis-aligned.
fn sine_and_cosine(degrees: f64) -> (f64, f64) {
    let within = libm::remainder(degrees, 360.0);
    let quarters = libm::rint(within / 90.0);
    let rest = (within - 90.0 * quarters) * (PI / 180.0);
    let (sine, cosine) = (libm::sin(rest), libm::cos(rest));
    match (quarters as i64).rem_euclid(4) {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}

/// h_j |e_k| + h_k |e_j| for each axis i, from half the size h.
#[inline(always)]
fn reaches(half: [f32; 3], e: [f32; 3]) -> [f32; 3] {
    let e = [e[0].abs(), e[1].abs(), e[2].abs()];
    [half[1] * e[2] + half[2] * e[1], half[2] * e[0] + half[0] * e[2], half[0] * e[1] + half[1] * e[0]]
}

/// Where a ray parallel to a slab enters it.
#[inline(always)]
fn beyond(outside: bool) -> f32 {
    if outside { f32::INFINITY } else { f32::NEG_INFINITY }
}

/// A point's offset along the axes of a box.
#[inline(always)]
fn local(axes: &[[f32; 3]; 3], offset: &[[f32; LANES]; 3], lane: usize) -> [f32; 3] {
    let p = [offset[0][lane], offset[1][lane], offset[2][lane]];
    std::array::from_fn(|i| axes[i][0] * p[0] + axes[i][1] * p[1] + axes[i][2] * p[2])
}

#[cfg(test)]
mod tests;
