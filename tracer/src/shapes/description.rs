//! A shape as a scene describes it, and its transformation to camera space.

use crate::camera_space::CameraSpace;
use crate::shapes::contact::Contact;
use crate::shapes::primitive::Primitive;
use crate::vector::Vector;

/// The parameters of a shape.
///
/// Its position is the centre, or a point of a plane, as `CameraSpace::scaled` gives it; so are other points.
pub(crate) trait Description {
    /// The number of parameters.
    const PARAMETERS: usize;

    /// The shape in camera space.
    type Shape: Primitive;

    /// Describe a shape by as many parameters.
    fn new(parameters: &[f64]) -> Self;

    /// Return the radius or the longest side in world space, 0 for a plane.
    fn size(&self) -> f64;

    /// Return where a point is relative to the surface.
    fn contact(&self, space: &CameraSpace, position: Vector, point: Vector) -> Contact;

    /// Return the factor by which the shape is moved toward the eye and shrunk; see `CameraSpace::range_scale`.
    fn range_scale(&self, space: &CameraSpace, position: Vector) -> f64 {
        space.range_scale(position, space.length(self.size()))
    }

    /// Transform the shape to camera space.
    fn transform(&self, space: &CameraSpace, position: Vector, range_scale: f64) -> Self::Shape;
}
