//! The shapes of a scene. To add one, implement `Description` and `Primitive` in a file of its own, and add a line
//! to `define_shapes!` below.

use crate::apex::Apex;
use crate::bounds::BoundingSphere;
use crate::camera::Projection;
use crate::camera_space::CameraSpace;
use crate::memory::{OutOfMemory, par_collect, reserve};
use crate::shapes::contact::Contact;
use crate::shapes::outline::Outline;
use crate::shapes::points::{Points, ShadowRays};
use crate::shapes::primitive::{Description, FaceAxes, Primitive};
use crate::tile::hits::HitBuffer;
use crate::tile::rays::{Ray, Rays};
use crate::vector::Vector;
use rayon::prelude::*;

pub(crate) mod capsule;
pub(crate) mod cone;
pub(crate) mod contact;
pub(crate) mod cuboid;
pub(crate) mod cylinder;
pub(crate) mod frustum;
pub(crate) mod outline;
pub(crate) mod plane;
pub(crate) mod points;
pub(crate) mod primitive;
pub(crate) mod sphere;

/// Objects that are read ahead, so that the cache misses overlap: in the order of the tree they are anywhere in memory.
const AHEAD: usize = 32;

/// Named in the error if memory runs out.
pub(crate) const OBJECTS: &str = "the objects";

/// A kind of shape or light.
pub struct Kind {
    /// Its name in a scene file.
    pub name: &'static str,
    /// The number of its parameters.
    pub parameters: usize,
}

/// An object of the world, on its way to camera space.
pub(crate) struct Placed {
    pub(crate) shape: ShapeDesc,
    /// As `CameraSpace::scaled` gives it.
    pub(crate) position: Vector,
    /// See `CameraSpace::range_scale`.
    pub(crate) range_scale: f64,
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
            pub const KINDS: &[Kind] =
                &[$(Kind { name: $name, parameters: <$module::$desc as Description>::PARAMETERS },)*];

            /// Make the description of a kind, by its index in `KINDS`, from its parameters, which others may follow.
            ///
            /// # Panics
            ///
            /// If there is no such kind, or there are fewer parameters.
            #[inline(always)]
            pub fn new(kind: usize, parameters: &[f64]) -> ShapeDesc {
                let mut count = 0;
                $(
                    if kind == count {
                        return ShapeDesc::$shape(Description::new(parameters));
                    }
                    count += 1;
                )*
                unreachable!("there is no kind {kind} among {count}")
            }

            /// The index of its kind in `KINDS`.
            pub fn kind(&self) -> usize {
                let mut kind = 0;
                $(
                    if let ShapeDesc::$shape(_) = self {
                        return kind;
                    }
                    kind += 1;
                )*
                kind
            }
        }

        /// The descriptions of all kinds.
        pub mod descriptions {
            $(pub use crate::shapes::$module::$desc;)*
        }

        /// An object in camera space.
        #[derive(Clone, Copy, Debug)]
        pub(crate) enum Shape<'a> {
            $($shape(&'a $module::$shape),)*
        }

        /// Objects in camera space, numbered through: first all of the first kind, and so on. Each kind has an array
        /// of its own, so that neighbours in it are neighbours in memory.
        #[derive(Debug, Default)]
        pub(crate) struct Shapes {
            $(pub(crate) $module: Vec<$module::$shape>,)*
        }

        impl Shapes {
            /// Transform objects to camera space, given by their numbers in the order of their kinds, and the count
            /// of each kind.
            ///
            /// # Errors
            ///
            /// If memory runs out.
            pub(crate) fn new(
                space: &CameraSpace,
                (mut numbers, counts): (&[u32], &[usize]),
                (place, read): (impl Fn(u32) -> Placed + Sync, impl Fn(u32) + Sync),
            ) -> Result<Shapes, OutOfMemory> {
                let mut counts = counts.iter();
                $(
                    let count = counts.next().copied().unwrap_or(0);
                    let own = numbers.split_off(..count).expect("the objects of a kind");
                    let transformed = own.par_iter().enumerate().map(|(i, &number)| {
                        if i % AHEAD == 0 {
                            own[i..].iter().take(AHEAD).for_each(|&number| read(number));
                        }
                        let Placed { shape: ShapeDesc::$shape(shape), position, range_scale } = place(number) else {
                            unreachable!("the objects are in the order of their kinds")
                        };
                        shape.transform(space, position, range_scale)
                    });
                    let $module = par_collect(transformed, OBJECTS)?;
                )*
                Ok(Shapes { $($module,)* })
            }

            /// Return the numbers of the shapes that have no bounds.
            ///
            /// # Errors
            ///
            /// If memory runs out.
            pub(crate) fn unbounded(&self) -> Result<Vec<u32>, OutOfMemory> {
                let (mut unbounded, mut first) = (Vec::new(), 0);
                $(
                    let count = self.$module.len();
                    if !$module::$shape::IS_BOUNDED {
                        reserve(&mut unbounded, count, OBJECTS)?;
                        unbounded.extend(first..first + count as u32);
                    }
                    first += count as u32;
                )*
                debug_assert_eq!(first as usize, self.len());
                Ok(unbounded)
            }

            pub(crate) fn len(&self) -> usize {
                0 $(+ self.$module.len())*
            }

            #[inline(always)]
            pub(crate) fn get(&self, index: u32) -> Shape<'_> {
                self.get_if::<true, true>(index)
            }

            /// Return a shape that has bounds. What is done with it is not compiled for the kinds that have none.
            #[inline(always)]
            pub(crate) fn get_bounded(&self, index: u32) -> Shape<'_> {
                self.get_if::<true, false>(index)
            }

            /// Return a shape that has no bounds. What is done with it is not compiled for the kinds that have some.
            #[inline(always)]
            pub(crate) fn get_unbounded(&self, index: u32) -> Shape<'_> {
                self.get_if::<false, true>(index)
            }

            #[inline(always)]
            fn get_if<const BOUNDED: bool, const UNBOUNDED: bool>(&self, index: u32) -> Shape<'_> {
                let mut index = index as usize;
                $(
                    if (BOUNDED && $module::$shape::IS_BOUNDED) || (UNBOUNDED && !$module::$shape::IS_BOUNDED) {
                        if let Some(shape) = self.$module.get(index) {
                            return Shape::$shape(shape);
                        }
                    }
                    index = index.wrapping_sub(self.$module.len());
                )*
                unreachable!("there is no such shape {index}")
            }
        }

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
    "cylinder": cylinder, Cylinder, CylinderDesc;
    "capsule": capsule, Capsule, CapsuleDesc;
    "cone": cone, Cone, ConeDesc;
}

impl ShapeDesc {
    pub(crate) fn size(&self) -> f64 {
        dispatch!(ShapeDesc, self, shape => shape.size())
    }

    pub(crate) fn contact(&self, space: &CameraSpace, position: Vector, point: Vector) -> Contact {
        dispatch!(ShapeDesc, self, shape => shape.contact(space, position, point))
    }

    pub(crate) fn face_axes(&self, space: &CameraSpace) -> Option<FaceAxes> {
        dispatch!(ShapeDesc, self, shape => shape.face_axes(space))
    }

    pub(crate) fn range_scale(&self, space: &CameraSpace, position: Vector) -> f64 {
        dispatch!(ShapeDesc, self, shape => shape.range_scale(space, position))
    }
}

impl Placed {
    /// The bounding sphere of the shape in camera space.
    pub(crate) fn bounds(&self, space: &CameraSpace) -> Option<BoundingSphere> {
        let Placed { shape, position, range_scale } = self;
        dispatch!(ShapeDesc, shape, shape => shape.transform(space, *position, *range_scale).bounds())
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

impl Primitive for Shape<'_> {
    forward! {
        fn intersect(&self, face: u32, rays: &Rays, hits: &mut HitBuffer);
        fn depth(&self, ray: Ray) -> (f64, f64);
        fn occlude(&self, contact: Option<&Contact>, shadow: &mut ShadowRays<'_>);
        fn may_hide(&self, emitter: (Apex, f64), bounds: BoundingSphere) -> bool;
        fn is_lit_from(&self, face: u32, contact: Option<&Contact>, light: Apex) -> bool;
        fn height(&self, face: u32, light: &Contact) -> f64;
        fn magnitude(&self) -> f64;
        fn magnitude_across(&self, face: u32) -> f64;
        fn bounds(&self) -> Option<BoundingSphere>;
        fn outline(&self, projection: Projection) -> Outline;
    }

    #[inline(always)]
    fn compute_points(&self, face: u32, rays: &Rays, depth: (f64, impl Fn() -> Ray), points: &mut Points) {
        points.start(rays.count, self.magnitude_across(face));
        dispatch!(Shape, self, shape => shape.compute_points(face, rays, depth, points));
    }
}
