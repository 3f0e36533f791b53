//! The operations that the tracer needs of every shape.

use crate::bounds::BoundingSphere;
use crate::shapes::contact::Contact;
use crate::shapes::outline::Outline;
use crate::shapes::plane_equation::PlaneEquation;
use crate::shapes::points::Points;
use crate::shapes::shadow::Shadow;
use crate::tile::hits::HitBuffer;
use crate::tile::rays::Rays;
use crate::vector::Vector;

/// A convex shape in camera space.
///
/// Mark what works on lanes `#[inline(always)]`: it is compiled for each SIMD level.
pub(crate) trait Primitive {
    /// Offer the hits of rays, with the face numbers from `face` on.
    fn intersect(&self, face: u32, rays: &Rays, hits: &mut HitBuffer);

    /// Return the depth at which the ray v = (x, y, 1) first hits the shape, in float64, infinite if it misses;
    /// and |n.v| there.
    fn depth(&self, v: Vector) -> (f64, f64);

    /// Place points where rays hit a face, and return its plane if it is flat. `depth` is the smallest depth, and
    /// a function that returns its ray.
    fn place(
        &self,
        face: u32,
        rays: &Rays,
        depth: (f64, impl Fn() -> Vector),
        points: &mut Points,
    ) -> Option<PlaneEquation>;

    /// Darken the points from which the shape hides the light. `contact` is given if the light is close to the
    /// surface.
    fn occlude(&self, contact: Option<&Contact>, shadow: &mut Shadow<'_>);

    /// Return whether a light is on the side of the surface that the eye sees.
    fn is_lit_from(&self, contact: Option<&Contact>, light: Vector) -> bool;

    /// Return the height above a flat face of a light close to the shape, on the eye's side.
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

    /// Return the cone of directions in which the eye sees the shape.
    fn outline(&self) -> Outline;
}
