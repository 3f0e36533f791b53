//! The world as the eye has it: every place relative to the eye, in the camera's axes, in a unit that suits the scene.
//!
//! With x to the right, y up and z along the view, the ray through a place of the image plane is
//! v = (x, y, 1), not normalised: its parameter t is the depth z. Subtracting the eye in float64 keeps a scene far
//! from the origin as accurate as one around it; the unit, a power of two, keeps its lengths within float32.

use crate::bvh::Bvh;
use crate::cuboid::Cuboid;
use crate::grid::{Nearest, Rays};
use crate::memory::{OutOfMemory, collect};
use crate::plane::Plane;
use crate::shadow::Shadow;
use crate::sphere::Sphere;
use crate::vector::{dot, length, scale, sub, turned};
use crate::world::{Camera, Form, Light, Object, Vector, World};
use std::f64::consts::PI;

/// Beyond this many units a place is as good as at infinity; its square still fits into float64.
const FARTHEST: f64 = 1e120;

/// What there may be not enough memory for.
const OBJECTS: &str = "the objects";

/// An object in the camera's space.
#[derive(Clone, Debug)]
pub(crate) enum Shape {
    Sphere(Sphere),
    Plane(Plane),
    Cuboid(Cuboid),
}

impl Shape {
    /// Offer where rays meet the shape, which has the face numbers from `face` on.
    #[inline(always)]
    pub(crate) fn meet(&self, face: u32, rays: &Rays, nearest: &mut Nearest) {
        match self {
            Shape::Sphere(sphere) => sphere.meet(face, rays, nearest),
            Shape::Plane(plane) => plane.meet(face, rays, nearest),
            Shape::Cuboid(cuboid) => cuboid.meet(face, rays, nearest),
        }
    }

    /// Darken the points from which the shape hides the lamp.
    #[inline(always)]
    pub(crate) fn hide(&self, shadow: &mut Shadow<'_>) {
        match self {
            Shape::Sphere(sphere) => sphere.hide(shadow),
            Shape::Plane(plane) => plane.hide(shadow),
            Shape::Cuboid(cuboid) => cuboid.hide(shadow),
        }
    }

    /// Whether a lamp is where it can light what the eye sees: both inside or both outside. Of a plane, the height
    /// above it tells.
    #[inline(always)]
    pub(crate) fn sees(&self, lamp: Vector) -> bool {
        match self {
            Shape::Sphere(sphere) => sphere.same_side_as_the_eye(lamp),
            Shape::Cuboid(cuboid) => cuboid.same_side_as_the_eye(lamp),
            Shape::Plane(_) => true,
        }
    }
}

/// A point light in the camera's space.
#[derive(Clone, Debug)]
pub(crate) struct Lamp {
    /// Where it stands.
    pub(crate) position: Vector,
    /// intensity * color / (4 pi), in units of this space: over r^2 it is the light L_i that arrives.
    pub(crate) power: Vector,
    /// The object that carries it and casts no shadow in it, or `NOBODY`.
    pub(crate) body: u32,
}

/// No object's number.
pub(crate) const NOBODY: u32 = u32::MAX;

/// What an object looks like, beside its shape.
#[derive(Clone, Debug)]
pub(crate) struct Look {
    /// Albedo, linear RGB.
    pub(crate) albedo: Vector,
    /// The radiance of an object that carries a light, the same from all its surface.
    pub(crate) shining: Option<[f32; 3]>,
}

/// A scene made ready for tracing.
#[derive(Debug)]
pub(crate) struct Scene {
    /// How many of this space's units make one of the world's: a power of two.
    pub(crate) unit: f64,
    pub(crate) shapes: Vec<Shape>,
    pub(crate) looks: Vec<Look>,
    pub(crate) lamps: Vec<Lamp>,
    /// The numbers of the planes: infinite, so that no tree can hold them.
    pub(crate) planes: Vec<u32>,
    /// All other objects.
    pub(crate) bvh: Bvh,
}

impl Scene {
    /// Move a world to its eye.
    ///
    /// # Errors
    ///
    /// If there is not enough memory for it.
    pub(crate) fn new(world: &World) -> Result<Scene, OutOfMemory> {
        let unit = suitable_unit(world)?;
        let space = Space {
            camera: &world.camera,
            unit,
        };
        let shapes = collect(world.objects.iter().map(|object| space.shape(object)), OBJECTS)?;
        let planes = collect(
            (0..shapes.len() as u32).filter(|&i| matches!(shapes[i as usize], Shape::Plane(_))),
            OBJECTS,
        )?;
        Ok(Scene {
            unit,
            looks: looks(world)?,
            lamps: collect(world.lights.iter().map(|light| space.lamp(light)), "the lights")?,
            planes,
            bvh: Bvh::new(&shapes)?,
            shapes,
        })
    }
}

/// The camera's space.
struct Space<'a> {
    camera: &'a Camera,
    unit: f64,
}

impl Space<'_> {
    fn length(&self, length: f64) -> f64 {
        (length * self.unit).clamp(-FARTHEST, FARTHEST)
    }

    /// A place relative to the eye, still in the world's axes.
    fn relative(&self, place: Vector) -> Vector {
        let eye = self.camera.position;
        // Scaled first: the difference of huge places might overflow.
        std::array::from_fn(|i| self.length(place[i]) - self.length(eye[i]))
    }

    fn place(&self, place: Vector) -> Vector {
        self.direction(self.relative(place))
    }

    fn direction(&self, direction: Vector) -> Vector {
        turned(&[self.camera.right, self.camera.up, self.camera.forward], direction)
    }

    fn shape(&self, object: &Object) -> Shape {
        let place = self.place(object.position);
        match object.form {
            Form::Sphere { radius } => Shape::Sphere(Sphere::new(place, self.length(radius))),
            Form::Plane { normal } => {
                let normal = unit_vector(normal);
                // In the world's axes a plane through the eye is at distance 0 exactly, and not seen.
                let offset = dot(normal, self.relative(object.position));
                Shape::Plane(Plane::new(self.direction(normal), offset))
            }
            Form::Box { size, rotation } => {
                let axes = turned_axes(rotation).map(|axis| self.direction(axis));
                let half = size.map(|side| self.length(side) / 2.0);
                Shape::Cuboid(Cuboid::new(place, axes, half))
            }
        }
    }

    fn lamp(&self, light: &Light) -> Lamp {
        let intensity = light.intensity * self.unit * self.unit / (4.0 * PI);
        Lamp {
            position: self.place(light.position),
            power: scale(light.color, intensity.min(f64::MAX)),
            body: light.body.map_or(NOBODY, |body| body as u32),
        }
    }
}

fn looks(world: &World) -> Result<Vec<Look>, OutOfMemory> {
    let look = |object: &Object| Look {
        albedo: object.color,
        shining: None,
    };
    let mut looks = collect(world.objects.iter().map(look), OBJECTS)?;
    for light in &world.lights {
        if let Some(body) = light.body {
            looks[body].shining = Some(seen_directly(light, world.camera.position));
        }
    }
    Ok(looks)
}

/// L = intensity color / (4 pi r^2), r from the light to the eye (document, section 3.4).
fn seen_directly(light: &Light, eye: Vector) -> [f32; 3] {
    let largest = f64::from(f32::MAX);
    let r = length(sub(light.position, eye));
    let arriving = light.intensity / (4.0 * PI * r * r);
    // 0 / 0: a light without power at the eye.
    let arriving = if arriving.is_nan() { 0.0 } else { arriving.min(largest) };
    light.color.map(|channel| (channel * arriving).min(largest) as f32)
}

/// A power of two that brings the typical distance from the eye, or the size of what is larger, to about 1.
fn suitable_unit(world: &World) -> Result<f64, OutOfMemory> {
    let eye = world.camera.position;
    let exponents = world
        .objects
        .iter()
        .map(|object| {
            let extent = match object.form {
                Form::Sphere { radius } => radius,
                Form::Plane { .. } => 0.0,
                Form::Box { size, .. } => size[0].max(size[1]).max(size[2]),
            };
            (0..3).fold(extent / 2.0, |largest, i| {
                largest.max((object.position[i] / 2.0 - eye[i] / 2.0).abs())
            })
        })
        .filter(|&distance| distance > 0.0)
        .map(libm::ilogb);
    let mut exponents = collect(exponents, OBJECTS)?;
    if exponents.is_empty() {
        return Ok(1.0);
    }
    let middle = exponents.len() / 2;
    let (_, &mut exponent, _) = exponents.select_nth_unstable(middle);
    Ok(libm::scalbn(1.0, -exponent.clamp(-1000, 1000)))
}

fn unit_vector(direction: Vector) -> Vector {
    let largest = direction.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    let scaled = direction.map(|component| component / largest); // so that no square overflows or vanishes
    let size = dot(scaled, scaled).sqrt();
    scaled.map(|component| component / size)
}

/// The axes of a box turned about +y, counter-clockwise seen from above: the rows of R_y (document, section 2.2.3).
fn turned_axes(degrees: f64) -> [Vector; 3] {
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
mod tests;
