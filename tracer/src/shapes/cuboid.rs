//! A box turned about three axes (document, section 2.2.3); `Box` is taken in Rust.

use crate::bounds::BoundingSphere;
use crate::camera_space::{CameraSpace, FAR_FROM_ROUNDING};
use crate::shapes::contact::{Contact, Side, rounding_across};
use crate::shapes::outline::{Outline, corners, outline_planes};
use crate::shapes::points::{PlaneEquation, Points, ShadowRays};
use crate::shapes::primitive::{Description, FaceAxes, Primitive};
use crate::tile::LANES;
use crate::tile::hits::{FACE_BITS, HitBuffer, offer};
use crate::tile::rays::Rays;
use crate::vector::{Vector, add, cross, l1_norm, largest, length, rotate, scale, sub, to_f32};
use std::f64::consts::PI;

/// Axes, and a sign and a limit along each: a point p is before the faces where sign p < limit.
type Before = ([[f32; 3]; 3], [f32; 3], [f32; 3]);

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

    /// The side of a point that is not close to the surface.
    fn side(&self, point: Vector) -> Side {
        if self.inside(rotate(&self.axes, sub(point, self.center))) { Side::Inside } else { Side::Outside }
    }

    /// The axis of a face, and its sign.
    #[inline(always)]
    fn side_of(&self, face: u32) -> (usize, f64) {
        let number = face % (1 << FACE_BITS);
        // Rays enter at the face that looks against them, and leave at the one that looks along with them.
        let along = if number % 2 == 1 { 1.0 } else { -1.0 };
        let side = if self.inside(self.eye) { along } else { -along };
        ((number / 2) as usize % 3, side)
    }

    /// The plane of a face, as `intersect` offered it, with its normal on the eye's side.
    #[inline(always)]
    fn face(&self, face: u32) -> PlaneEquation {
        let (axis, side) = self.side_of(face);
        let outward = scale(self.axes[axis], side);
        // The eye is known more exactly than the centre if that is far away along the face.
        let offset = self.half[axis] - side * self.eye[axis];
        PlaneEquation { normal: outward, offset }.facing_the_eye()
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
}

impl Primitive for Cuboid {
    /// Intersect the three slabs: a ray is in the box where it is in all of them.
    ///
    /// With v = middle + delta, o the middle ray's point at depth `start` relative to the box, and the parameter
    /// start + tau, a slab of half width h along the axis a is entered and left at
    ///
    /// tau = (-+h - o - start (a . delta)) / (a . v)
    ///
    /// A face is numbered `face`, plus twice its axis, plus 1 if the ray runs along the axis.
    #[inline(always)]
    fn intersect(&self, face: u32, rays: &Rays, hits: &mut HitBuffer) {
        let inside = self.inside(self.eye);
        let start = self.bounding_sphere().begin(rays.middle);
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
                let number = 2 * i as u32 + u32::from(forward);
                entered = if near > enter { number } else { entered };
                enter = if near > enter { near } else { enter };
                left = if far < leave { number } else { left };
                leave = if far < leave { far } else { leave };
            }
            let tau = if inside { leave } else { enter };
            let number = if inside { left } else { entered };
            let t = if enter <= leave { start + tau } else { 0.0 };
            close += offer((&mut hits.t[lane], &mut hits.face[lane]), t, face + number);
        }
        hits.close += close;
    }

    fn depth(&self, v: Vector) -> (f64, f64) {
        let along = rotate(&self.axes, v);
        let (mut enter, mut leave) = ((f64::NEG_INFINITY, 0.0), (f64::INFINITY, 0.0));
        for i in 0..3 {
            if along[i] != 0.0 {
                let a = (-self.half[i] - self.eye[i]) / along[i];
                let b = (self.half[i] - self.eye[i]) / along[i];
                let (near, far) = (a.min(b), a.max(b));
                enter = if near > enter.0 { (near, along[i].abs()) } else { enter };
                leave = if far < leave.0 { (far, along[i].abs()) } else { leave };
            } else if self.eye[i].abs() > self.half[i] {
                return (f64::INFINITY, 0.0);
            }
        }
        let met = if self.inside(self.eye) { leave } else { enter };
        if enter.0 <= leave.0 && met.0 > 0.0 { met } else { (f64::INFINITY, 0.0) }
    }

    #[inline(always)]
    fn compute_points(&self, face: u32, rays: &Rays, (t, _): (f64, impl Fn() -> Vector), points: &mut Points) {
        self.face(face).compute_points(t, rays, points);
    }

    /// Darken the points from which the box hides the light.
    ///
    /// In the axes of the box, with the light at L and the point at P = L + e, by separating axes: the segment
    /// misses the box if both ends lie beyond one face, or if for some axis i, with j and k the others,
    ///
    /// |(L x P)_i| > h_j |e_k| + h_k |e_j|
    #[inline(always)]
    fn occlude(&self, contact: Option<&Contact>, shadow: &mut ShadowRays<'_>) {
        let light =
            contact.map_or_else(|| rotate(&self.axes, sub(shadow.light, self.center)), |contact| contact.local);
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
            if light[i].abs() >= self.half[i] - at_light[i] {
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
        let half = to_f32(self.half);
        let moment = to_f32(cross(light, reference));
        let e = to_f32(sub(reference, light));
        let l = to_f32(light);
        let points = shadow.points;
        for lane in 0..points.padded() {
            let p = local(&axes, &points.offset, lane);
            let e = [(e[0] + p[0]).abs(), (e[1] + p[1]).abs(), (e[2] + p[2]).abs()];
            let m = [
                (moment[0] + (l[1] * p[2] - l[2] * p[1])).abs(),
                (moment[1] + (l[2] * p[0] - l[0] * p[2])).abs(),
                (moment[2] + (l[0] * p[1] - l[1] * p[0])).abs(),
            ];
            let slack = points.slack(lane);
            let between = (sign[0] * p[0] + slack < limit[0])
                & (sign[1] * p[1] + slack < limit[1])
                & (sign[2] * p[2] + slack < limit[2]);
            let crosses = (m[0] <= half[1] * e[2] + half[2] * e[1])
                & (m[1] <= half[2] * e[0] + half[0] * e[2])
                & (m[2] <= half[0] * e[1] + half[1] * e[0]);
            shadow.darken(lane, between & crosses);
        }
    }

    #[inline(always)]
    fn is_lit_from(&self, contact: Option<&Contact>, light: Vector) -> bool {
        let side = contact.map_or_else(|| self.side(light), |contact| contact.side);
        side.sees_from(!self.inside(self.eye))
    }

    #[inline(always)]
    fn height(&self, face: u32, light: &Contact) -> f64 {
        let (axis, side) = self.side_of(face);
        let outward = side * light.local[axis] - self.half[axis];
        if self.inside(self.eye) { -outward } else { outward }
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

    fn outline(&self) -> Outline {
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
