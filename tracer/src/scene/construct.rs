//! From the world's shapes to those of the camera's space: the one place that knows how each kind is described.

use crate::memory::{OutOfMemory, collect, reserve};
use crate::shapes::Shape;
use crate::shapes::contact::{Contact, spread};
use crate::shapes::cuboid::Cuboid;
use crate::shapes::plane::Plane;
use crate::shapes::sphere::Sphere;
use crate::vector::{Vector, dot, l1_norm, largest, length, rotate, scale, sub};
use crate::world::{Camera, Object, ShapeDesc, World};
use std::f64::consts::PI;

/// Rounding in the camera's space is less than this share of distances from the eye and sizes.
pub(crate) const FAR_FROM_ROUNDING: f64 = 1e-12;

/// The height above a sphere loses less than float32 does to rounding in the camera's space if it is more than this share
/// of distances from the eye and sizes.
const FAR_ABOVE_ROUNDING: f64 = 1e-8;

/// Beyond this many units a length is as good as infinite; its square still fits into float64.
const FARTHEST: f64 = 1e120;

/// Beyond this many units, 2^60, places are moved nearer.
const REACH: f64 = (1_u64 << 60) as f64;

/// What there may be not enough memory for.
pub(crate) const OBJECTS: &str = "the objects";

/// The camera's space.
pub(crate) struct CameraSpace<'a> {
    pub(crate) camera: &'a Camera,
    pub(crate) unit: f64,
}

impl CameraSpace<'_> {
    fn length(&self, length: f64) -> f64 {
        (length * self.unit).clamp(-FARTHEST, FARTHEST)
    }

    /// A place in the world's axes.
    pub(crate) fn world(&self, place: Vector) -> Vector {
        // Scaled first: the difference of huge places might overflow.
        place.map(|component| self.length(component))
    }

    /// A place relative to the eye, still in the world's axes.
    fn relative(&self, place: Vector) -> Vector {
        sub(self.world(place), self.world(self.camera.position))
    }

    /// How a place lies to an object.
    pub(crate) fn contact(&self, object: &Object, place: Vector) -> Contact {
        let (place, center) = (self.world(place), self.world(object.position));
        match object.shape {
            ShapeDesc::Sphere { radius } => Contact::with_sphere(place, center, self.length(radius)),
            ShapeDesc::Plane { normal } => Contact::with_plane(place, center, unit_vector(normal)),
            ShapeDesc::Box { size, rotation } => {
                Contact::with_box(place, center, &box_axes(rotation), self.half(size))
            }
        }
    }

    fn half(&self, size: Vector) -> Vector {
        size.map(|side| self.length(side) / 2.0)
    }

    pub(crate) fn place(&self, place: Vector) -> Vector {
        self.direction(self.relative(place))
    }

    /// The factor that moves a place within reach of float32, in its direction from the eye; 1 for all but what is
    /// beyond everything that matters. An object made as much smaller looks the same from near the eye.
    pub(crate) fn nearer(&self, place: Vector, extent: f64) -> f64 {
        let away = largest(self.relative(place));
        if away > REACH && self.length(extent) < away / 2.0 {
            REACH / away
        } else {
            1.0
        }
    }

    /// The same for an object.
    pub(crate) fn nearer_of(&self, object: &Object) -> f64 {
        match object.shape {
            ShapeDesc::Plane { .. } => {
                let height = self.contact(object, self.camera.position).local[0];
                (REACH / height.abs()).min(1.0)
            }
            _ => self.nearer(object.position, extent(object)),
        }
    }

    fn direction(&self, direction: Vector) -> Vector {
        rotate(&[self.camera.right, self.camera.up, self.camera.forward], direction)
    }

    pub(crate) fn shape(&self, object: &Object) -> Shape {
        let place = self.place(object.position);
        let nearer = self.nearer_of(object);
        let eye = self.contact(object, self.camera.position);
        match object.shape {
            ShapeDesc::Sphere { radius } => {
                let (place, radius) = (scale(place, nearer), self.length(radius) * nearer);
                let close = eye.is_within(FAR_ABOVE_ROUNDING * (l1_norm(place) + radius));
                Shape::Sphere(Sphere::new(place, radius, close.then_some(&eye)))
            }
            ShapeDesc::Plane { normal } => {
                // In the world's axes it is 0 exactly if the eye is on the plane.
                let offset = -eye.local[0] * nearer;
                let normal = unit_vector(normal);
                let magnitude = spread(normal, self.relative(object.position));
                Shape::Plane(Plane::new(self.direction(normal), offset, magnitude))
            }
            ShapeDesc::Box { size, rotation } => {
                let axes = box_axes(rotation).map(|axis| self.direction(axis));
                let (place, half) = (scale(place, nearer), scale(self.half(size), nearer));
                let close = eye.is_within(FAR_FROM_ROUNDING * (l1_norm(place) + length(half)));
                let eye = if close {
                    eye.local
                } else {
                    rotate(&axes, scale(place, -1.0))
                };
                Shape::Cuboid(Cuboid::new(place, axes, half, eye))
            }
        }
    }
}

/// The farthest thing is kept within this power of two: its square stays within float32.
const LARGEST_EXPONENT: i32 = 58;

/// What is farther than this power of two times the typical distance does not count for the unit; see
/// `CameraSpace::nearer`.
const FARTHEST_EXPONENT: i32 = 80;

/// Nor what of a light's distance is more than this power of two times that of all objects: its light is parallel.
const AS_GOOD_AS_PARALLEL: i32 = 30;

/// A power of two that brings the typical distance from the eye, or the size of what is larger, to about 1, or
/// below if something is very far away.
pub(crate) fn suitable_unit(world: &World) -> Result<f64, OutOfMemory> {
    let eye = world.camera.position;
    let exponent = |place: Vector, extent: f64| {
        let away = |largest: f64, i: usize| largest.max((place[i] / 2.0 - eye[i] / 2.0).abs());
        let distance = (0..3).fold(extent / 2.0, away);
        (distance > 0.0).then(|| libm::ilogb(distance))
    };
    let of_object = |object: &Object| exponent(object.position, extent(object));
    let mut exponents = collect(world.objects.iter().filter_map(of_object), OBJECTS)?;
    let Some(&farthest_object) = exponents.iter().max() else {
        return Ok(1.0);
    };
    let lights = world.lights.iter().filter_map(|light| exponent(light.position, 0.0));
    reserve(&mut exponents, world.lights.len(), "the lights")?;
    exponents.extend(lights.map(|light| light.min(farthest_object + AS_GOOD_AS_PARALLEL)));
    let farthest = exponents.iter().copied().fold(farthest_object, i32::max);
    // The lower of two: near objects matter more.
    let middle = (exponents.len() - 1) / 2;
    let (_, &mut typical, _) = exponents.select_nth_unstable(middle);
    let exponent = typical.max(farthest.min(typical + FARTHEST_EXPONENT) - LARGEST_EXPONENT);
    Ok(libm::scalbn(1.0, -exponent.clamp(-1000, 1000)))
}

/// The radius or the longest side of an object; 0 of a plane.
fn extent(object: &Object) -> f64 {
    match object.shape {
        ShapeDesc::Sphere { radius } => radius,
        ShapeDesc::Plane { .. } => 0.0,
        ShapeDesc::Box { size, .. } => size[0].max(size[1]).max(size[2]),
    }
}

fn unit_vector(direction: Vector) -> Vector {
    let largest = largest(direction);
    let scaled = direction.map(|component| component / largest); // so that no square overflows or vanishes
    let size = dot(scaled, scaled).sqrt();
    scaled.map(|component| component / size)
}

/// The axes of a box turned about +y, counter-clockwise seen from above: the rows of R_y (document, section
/// 2.2.3).
fn box_axes(degrees: f64) -> [Vector; 3] {
    let (sine, cosine) = sine_and_cosine(degrees);
    [[cosine, 0.0, -sine], [0.0, 1.0, 0.0], [sine, 0.0, cosine]]
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn right_angles_are_exact() {
        for (degrees, expected) in [
            (0.0, (0.0, 1.0)),
            (90.0, (1.0, 0.0)),
            (180.0, (0.0, -1.0)),
            (270.0, (-1.0, 0.0)),
            (-90.0, (-1.0, 0.0)),
            (360.0, (0.0, 1.0)),
            (-180.0, (0.0, -1.0)),
            (360e6 + 90.0, (1.0, 0.0)),
        ] {
            assert_eq!(sine_and_cosine(degrees), expected, "of {degrees} degrees");
        }
    }

    #[test]
    fn other_angles_are_those_of_the_mathematics_library() {
        for tenth in -7200..7200 {
            let degrees = f64::from(tenth) / 10.0;
            let (sine, cosine) = sine_and_cosine(degrees);
            assert!(
                (sine - degrees.to_radians().sin()).abs() < 1e-14,
                "sin of {degrees} degrees"
            );
            assert!(
                (cosine - degrees.to_radians().cos()).abs() < 1e-14,
                "cos of {degrees} degrees"
            );
        }
    }

    #[test]
    fn the_axes_of_a_box_turn_counter_clockwise_seen_from_above() {
        // From above, x points right and -z up: a quarter turn takes x to -z.
        assert_eq!(box_axes(90.0), [[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]);
    }

    #[test]
    fn a_normal_may_have_any_length() {
        for length in [1e-300, 1e-160, 1.0, 1e160, 1e300] {
            assert_eq!(unit_vector([0.0, -length, 0.0]), [0.0, -1.0, 0.0]);
        }
    }
}
