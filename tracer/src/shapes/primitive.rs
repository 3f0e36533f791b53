//! The traits of every shape: its description in a scene, and its operations in camera space.

use crate::apex::Apex;
use crate::bounds::BoundingSphere;
use crate::camera::Projection;
use crate::camera_space::CameraSpace;
use crate::shapes::contact::Contact;
use crate::shapes::outline::Outline;
use crate::shapes::points::{Points, ShadowRays};
use crate::tile::hits::HitBuffer;
use crate::tile::rays::{Ray, Rays};
use crate::vector::Vector;

/// The axes of a shape in camera space, to which its faces are parallel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FaceAxes(pub(crate) [Vector; 3]);

impl FaceAxes {
    /// The axes along a face, given by its number: `intersect` numbers the faces across the first axis 0 to 3, then
    /// those across the second.
    pub(crate) fn along(&self, number: u32) -> [Vector; 2] {
        let [x, y, z] = self.0;
        match number / 4 {
            0 => [y, z],
            1 => [x, z],
            _ => [x, y],
        }
    }
}

/// The parameters of a shape.
///
/// Its position is the centre, or a point of a plane, as `CameraSpace::scaled` gives it; so are other points.
pub(crate) trait Description {
    /// The number of parameters.
    const PARAMETERS: usize;

    /// The shape in camera space.
    type Shape: Primitive;

    /// Make a description from the first `PARAMETERS` parameters.
    fn new(parameters: &[f64]) -> Self;

    /// Return the radius or the longest side in world space, 0 for a plane.
    fn size(&self) -> f64;

    /// Return where a point is relative to the surface.
    fn contact(&self, space: &CameraSpace, position: Vector, point: Vector) -> Contact;

    /// Return the factor by which the shape is moved toward the eye and shrunk; see `CameraSpace::range_scale`.
    fn range_scale(&self, space: &CameraSpace, position: Vector) -> f64 {
        space.range_scale(position, space.length(self.size()))
    }

    /// Return the axes of its faces if they are flat and may have a checker.
    fn face_axes(&self, _space: &CameraSpace) -> Option<FaceAxes> {
        None
    }

    /// Transform the shape to camera space.
    fn transform(&self, space: &CameraSpace, position: Vector, range_scale: f64) -> Self::Shape;
}

/// A convex shape in camera space.
///
/// Mark methods that work on lanes `#[inline(always)]`: they are compiled for each SIMD level.
pub(crate) trait Primitive {
    /// Whether it has bounds.
    const IS_BOUNDED: bool = true;

    /// Offer the hits of rays, with the face numbers from `face` on, and `INSIDE` in those that are seen from inside.
    fn intersect(&self, face: u32, rays: &Rays, hits: &mut HitBuffer);

    /// Return the depth at which a ray first hits the shape, in float64, infinite if it misses; and |n.v| there. Rays to
    /// a light, which begin anywhere, ask only shapes that are far away.
    fn depth(&self, ray: Ray) -> (f64, f64);

    /// Compute the points where rays hit a face. `depth` is the smallest depth, and a function that returns its
    /// ray.
    fn compute_points(&self, face: u32, rays: &Rays, depth: (f64, impl Fn() -> Ray), points: &mut Points);

    /// Darken the points from which the shape hides the light. `contact` is given if the light is close to the
    /// surface.
    fn occlude(&self, contact: Option<&Contact>, shadow: &mut ShadowRays<'_>);

    /// Return whether the shape may hide a part of an emitter from points within a bounding sphere: a ball of radius
    /// `size` around an apex, or directions up to an angle of that sine. Only infinite shapes are asked.
    fn may_hide(&self, _emitter: (Apex, f64), _bounds: BoundingSphere) -> bool {
        true
    }

    /// Return whether a light is on the side of the surface from which a face is seen.
    fn is_lit_from(&self, face: u32, contact: Option<&Contact>, light: Apex) -> bool;

    /// Return the height above a flat face of a light close to the shape, on the side from which it is seen.
    fn height(&self, face: u32, light: &Contact) -> f64;

    /// Return a bound on half the distance from the eye plus the size: rounding grows with it.
    fn magnitude(&self) -> f64;

    /// Return the same for a face, counting only the size across the face.
    #[inline(always)]
    fn magnitude_across(&self, _face: u32) -> f64 {
        self.magnitude()
    }

    /// Return a bounding sphere, None if the shape is infinite.
    fn bounds(&self) -> Option<BoundingSphere>;

    /// Return where in the picture the shape appears.
    fn outline(&self, projection: Projection) -> Outline;
}
