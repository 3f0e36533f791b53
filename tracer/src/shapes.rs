//! The shapes of a scene. To add one, implement `Description` and `Primitive` in a file of its own, and add a line
//! to `define_shapes!` below.

use crate::bounds::BoundingSphere;
use crate::camera_space::CameraSpace;
use crate::shapes::contact::Contact;
use crate::shapes::outline::Outline;
use crate::shapes::points::{Points, ShadowRays};
use crate::shapes::primitive::{Description, Primitive};
use crate::tile::hits::HitBuffer;
use crate::tile::rays::Rays;
use crate::vector::Vector;

pub(crate) mod contact;
pub(crate) mod cuboid;
pub(crate) mod outline;
pub(crate) mod plane;
pub(crate) mod points;
pub(crate) mod primitive;
pub(crate) mod sphere;

/// A kind of shape or light, which `T` describes.
pub struct Kind<T> {
    /// Its name in a scene file.
    pub name: &'static str,
    /// The number of its parameters.
    pub parameters: usize,
    /// Return the description with these parameters; panics if there are fewer.
    pub describe: fn(&[f64]) -> T,
}

/// Define everything that lists the kinds of shapes. A line gives a kind's name, its module, its type in camera
/// space and its description. The first argument is the token `$`, which the inner macro needs.
macro_rules! define_shapes {
    ($d:tt $($name:literal: $module:ident, $shape:ident, $desc:ident;)*) => {
        /// The parameters of an object's shape.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum ShapeDesc {
            $(#[doc = concat!("A ", $name, ".")] $shape($module::$desc),)*
        }

        impl ShapeDesc {
            /// The kinds, in the order of their tags.
            pub const KINDS: &[Kind<ShapeDesc>] = &[$(Kind {
                name: $name,
                parameters: <$module::$desc as Description>::PARAMETERS,
                describe: |parameters| ShapeDesc::$shape(Description::new(parameters)),
            },)*];
        }

        /// The descriptions of all kinds.
        pub mod descriptions {
            $(pub use crate::shapes::$module::$desc;)*
        }

        /// An object in camera space.
        #[derive(Clone, Debug)]
        pub(crate) enum Shape {
            $($shape($module::$shape),)*
        }

        $(impl From<$module::$shape> for Shape {
            fn from(shape: $module::$shape) -> Shape {
                Shape::$shape(shape)
            }
        })*

        /// Evaluate an expression for the value in a `Shape` or a `ShapeDesc`, whatever its kind.
        macro_rules! dispatch {
            ($d kinds:ident, $d value:expr, $d inner:ident => $d result:expr) => {
                match $d value {
                    $($d kinds::$shape($d inner) => $d result,)*
                }
            };
        }
    };
}

define_shapes! { $
    "sphere": sphere, Sphere, SphereDesc;
    "plane": plane, Plane, PlaneDesc;
    "box": cuboid, Cuboid, CuboidDesc;
}

impl ShapeDesc {
    pub(crate) fn size(&self) -> f64 {
        dispatch!(ShapeDesc, self, shape => shape.size())
    }

    pub(crate) fn contact(&self, space: &CameraSpace, position: Vector, point: Vector) -> Contact {
        dispatch!(ShapeDesc, self, shape => shape.contact(space, position, point))
    }

    pub(crate) fn range_scale(&self, space: &CameraSpace, position: Vector) -> f64 {
        dispatch!(ShapeDesc, self, shape => shape.range_scale(space, position))
    }

    pub(crate) fn transform(&self, space: &CameraSpace, position: Vector, range_scale: f64) -> Shape {
        dispatch!(ShapeDesc, self, shape => shape.transform(space, position, range_scale).into())
    }
}

/// Forward methods of `Primitive` to the shape in a `Shape`.
macro_rules! forward {
    ($(fn $method:ident(&$self:ident $(, $name:ident: $type:ty)*) $(-> $result:ty)?;)*) => {
        $(#[inline(always)]
        fn $method(&$self $(, $name: $type)*) $(-> $result)? {
            dispatch!(Shape, $self, shape => shape.$method($($name),*))
        })*
    };
}

impl Primitive for Shape {
    forward! {
        fn intersect(&self, face: u32, rays: &Rays, hits: &mut HitBuffer);
        fn depth(&self, v: Vector) -> (f64, f64);
        fn occlude(&self, contact: Option<&Contact>, shadow: &mut ShadowRays<'_>);
        fn is_lit_from(&self, contact: Option<&Contact>, light: Vector) -> bool;
        fn height(&self, face: u32, light: &Contact) -> f64;
        fn magnitude(&self) -> f64;
        fn magnitude_across(&self, face: u32) -> f64;
        fn bounds(&self) -> Option<BoundingSphere>;
        fn outline(&self) -> Outline;
    }

    #[inline(always)]
    fn compute_points(&self, face: u32, rays: &Rays, depth: (f64, impl Fn() -> Vector), points: &mut Points) {
        points.start(rays.count, self.magnitude_across(face));
        dispatch!(Shape, self, shape => shape.compute_points(face, rays, depth, points));
    }
}
