//! Checkers: squares in two colors on flat faces.

use crate::camera_space::CameraSpace;
use crate::shapes::points::Points;
use crate::shapes::primitive::FaceAxes;
use crate::tile::LANES;
use crate::tile::hits::FACE_BITS;
use crate::vector::{Vector, dot, scale, sub, to_f32};
use crate::world::CheckerDesc;

/// A checker in camera space.
#[derive(Clone, Debug)]
pub(crate) struct Checker {
    /// The number of its object in the kernel.
    pub(crate) object: u32,
    /// The albedo of every other square, linear RGB.
    pub(crate) albedo: Vector,
    /// The corner of four squares on each face, but for the distance from the face.
    origin: Vector,
    axes: FaceAxes,
    /// Squares per unit of camera space.
    per_unit: f64,
}

impl Checker {
    /// Transform the checker of an object, moved toward the eye by a factor, at a position as `CameraSpace::scaled`
    /// gives it.
    pub(crate) fn new(
        space: &CameraSpace,
        description: &CheckerDesc,
        (object, axes): (u32, FaceAxes),
        (position, range_scale): (Vector, f64),
    ) -> Checker {
        Checker {
            object,
            albedo: description.color,
            origin: scale(space.point(position), range_scale),
            axes,
            per_unit: 1.0 / (space.length(description.size) * range_scale),
        }
    }

    /// Mark the points on the squares of the checker's color.
    ///
    /// floor(a / size) + floor(b / size) is odd, with a and b from the origin along the axes of the face. Of the
    /// reference, float64 keeps whole squares and the rest; float32 adds the offset.
    #[inline(always)]
    pub(crate) fn mark(&self, face: u32, points: &mut Points) {
        let from_origin = sub(points.reference, self.origin);
        points.odd = [0; LANES];
        for axis in self.axes.along(face % (1 << FACE_BITS)) {
            let squares = dot(from_origin, axis) * self.per_unit;
            let whole = squares.floor();
            let (rest, parity) = ((squares - whole) as f32, (whole - 2.0 * (whole / 2.0).floor()) as u32);
            let [x, y, z] = to_f32(scale(axis, self.per_unit));
            for lane in 0..points.padded() {
                let [px, py, pz] = std::array::from_fn(|i| points.offset[i][lane]);
                let along = rest + (x * px + y * py + z * pz);
                points.odd[lane] ^= parity ^ (along.floor() as i32 as u32 & 1);
            }
        }
        points.checkered = true;
    }
}
