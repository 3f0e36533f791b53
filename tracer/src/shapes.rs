//! The shapes of a scene. To add one: implement `Primitive` in a file of its own, and add it to `Shape`, to
//! `ShapeDesc`, and to `scene::construct`.

use crate::bounds::BoundingSphere;
use crate::shapes::contact::Contact;
use crate::shapes::cuboid::Cuboid;
use crate::shapes::outline::Outline;
use crate::shapes::plane::Plane;
use crate::shapes::plane_equation::PlaneEquation;
use crate::shapes::points::Points;
use crate::shapes::primitive::Primitive;
use crate::shapes::shadow::Shadow;
use crate::shapes::sphere::Sphere;
use crate::tile::hits::HitBuffer;
use crate::tile::rays::Rays;
use crate::vector::Vector;

pub(crate) mod contact;
pub(crate) mod cuboid;
pub(crate) mod outline;
pub(crate) mod plane;
pub(crate) mod plane_equation;
pub(crate) mod points;
pub(crate) mod primitive;
pub(crate) mod shadow;
pub(crate) mod sphere;

/// An object in the camera's space.
#[derive(Clone, Debug)]
pub(crate) enum Shape {
    Sphere(Sphere),
    Plane(Plane),
    Cuboid(Cuboid),
}

/// Evaluate an expression for the shape, whatever its kind.
macro_rules! dispatch {
    ($self:expr, $shape:ident => $result:expr) => {
        match $self {
            Shape::Sphere($shape) => $result,
            Shape::Plane($shape) => $result,
            Shape::Cuboid($shape) => $result,
        }
    };
}

impl Primitive for Shape {
    #[inline(always)]
    fn intersect(&self, face: u32, rays: &Rays, hits: &mut HitBuffer) {
        dispatch!(self, shape => shape.intersect(face, rays, hits));
    }

    #[inline(always)]
    fn depth(&self, v: Vector) -> (f64, f64) {
        dispatch!(self, shape => shape.depth(v))
    }

    #[inline(always)]
    fn place(
        &self,
        face: u32,
        rays: &Rays,
        depth: (f64, impl Fn() -> Vector),
        points: &mut Points,
    ) -> Option<PlaneEquation> {
        points.start(rays.count, self.magnitude_across(face));
        dispatch!(self, shape => shape.place(face, rays, depth, points))
    }

    #[inline(always)]
    fn occlude(&self, contact: Option<&Contact>, shadow: &mut Shadow<'_>) {
        dispatch!(self, shape => shape.occlude(contact, shadow));
    }

    #[inline(always)]
    fn is_lit_from(&self, contact: Option<&Contact>, light: Vector) -> bool {
        dispatch!(self, shape => shape.is_lit_from(contact, light))
    }

    #[inline(always)]
    fn height(&self, face: u32, light: &Contact) -> f64 {
        dispatch!(self, shape => shape.height(face, light))
    }

    fn magnitude(&self) -> f64 {
        dispatch!(self, shape => shape.magnitude())
    }

    #[inline(always)]
    fn magnitude_across(&self, face: u32) -> f64 {
        dispatch!(self, shape => shape.magnitude_across(face))
    }

    fn bounds(&self) -> Option<BoundingSphere> {
        dispatch!(self, shape => shape.bounds())
    }

    fn outline(&self) -> Outline {
        dispatch!(self, shape => shape.outline())
    }
}
