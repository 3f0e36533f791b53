//! The world as the eye has it: every place relative to the eye, in the camera's axes, in a unit that suits the scene.
//!
//! With x to the right, y up and z along the view, the ray through a place of the image plane is
//! v = (x, y, 1), not normalised: its parameter t is the depth z. Subtracting the eye in float64 keeps a scene far
//! from the origin as accurate as one around it; the unit, a power of two, keeps its lengths within float32.

use crate::bvh::{Bvh, Cone, Stack};
use crate::contact::{COORDINATE, Contact, Side, spread};
use crate::cuboid::Cuboid;
use crate::grid::{Nearest, Rays};
use crate::memory::{OutOfMemory, collect, reserve};
use crate::plane::Plane;
use crate::shadow::Shadow;
use crate::sphere::Sphere;
use crate::vector::{dot, largest, length, scale, sub, taxi, turned};
use crate::world::{Camera, Form, Light, Object, Vector, World};
use std::f64::consts::PI;
use std::iter;

/// Rounding in the camera's space is less than this share of distances from the eye and sizes.
const FAR_FROM_ROUNDING: f64 = 1e-12;

/// The height above a sphere loses less than float32 does to rounding in the camera's space if it is more than this share
/// of distances from the eye and sizes.
const FAR_ABOVE_ROUNDING: f64 = 1e-8;

/// Beyond this many units a length is as good as infinite; its square still fits into float64.
const FARTHEST: f64 = 1e120;

/// Beyond this many units, 2^60, places are moved nearer.
const REACH: f64 = (1_u64 << 60) as f64;

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

    /// The depth at which the ray v = (x, y, 1) first meets the shape, in float64, infinite where it does not; and |n.v|.
    #[inline(always)]
    pub(crate) fn depth(&self, v: Vector) -> (f64, f64) {
        match self {
            Shape::Sphere(sphere) => sphere.depth(v),
            Shape::Plane(plane) => plane.depth(v),
            Shape::Cuboid(cuboid) => cuboid.depth(v),
        }
    }

    /// Darken the points from which the shape hides the lamp; `contact` if that is close to its surface.
    #[inline(always)]
    pub(crate) fn hide(&self, contact: Option<&Contact>, shadow: &mut Shadow<'_>) {
        match self {
            Shape::Sphere(sphere) => sphere.hide(contact, shadow),
            Shape::Plane(plane) => plane.hide(contact, shadow),
            Shape::Cuboid(cuboid) => cuboid.hide(contact, shadow),
        }
    }

    /// Whether a lamp is where it can light what the eye sees: both inside or both outside, or the lamp on the surface.
    /// Of a plane, the height above it tells.
    #[inline(always)]
    pub(crate) fn sees(&self, contact: Option<&Contact>, lamp: Vector) -> bool {
        let (side, eye_is_outside) = match self {
            Shape::Sphere(sphere) => (
                contact.map_or_else(|| sphere.side(lamp), |contact| contact.side),
                sphere.eye_is_outside(),
            ),
            Shape::Cuboid(cuboid) => (
                contact.map_or_else(|| cuboid.side(lamp), |contact| contact.side),
                cuboid.eye_is_outside(),
            ),
            Shape::Plane(_) => return true,
        };
        side == Side::On || (side == Side::Outside) == eye_is_outside
    }

    /// How high a lamp close to the shape is above a flat face, on the eye's side.
    #[inline(always)]
    pub(crate) fn height(&self, face: u32, lamp: &Contact) -> f64 {
        match self {
            Shape::Sphere(_) => 0.0,
            Shape::Plane(plane) => plane.height_of(lamp),
            Shape::Cuboid(cuboid) => cuboid.height(face, lamp),
        }
    }

    /// Twice how far from the eye or how large the shape is, at most: what rounding depends on.
    pub(crate) fn reach(&self) -> f64 {
        match self {
            Shape::Cuboid(cuboid) => taxi(cuboid.center) + 2.0 * cuboid.bounding_radius(),
            Shape::Sphere(_) | Shape::Plane(_) => self.reach_of(0),
        }
    }

    /// The same of a face: of a box its size across the face counts.
    #[inline(always)]
    pub(crate) fn reach_of(&self, face: u32) -> f64 {
        match self {
            Shape::Sphere(sphere) => taxi(sphere.center) + sphere.radius,
            Shape::Cuboid(cuboid) => taxi(cuboid.center) + 2.0 * cuboid.across(face),
            Shape::Plane(plane) => plane.reach,
        }
    }
}

/// A point light in the camera's space.
#[derive(Clone, Debug)]
pub(crate) struct Lamp {
    /// Where it stands.
    pub(crate) position: Vector,
    /// By what factor it was moved nearer to the eye.
    pub(crate) nearer: f64,
    /// intensity * color / (4 pi), in units of this space: over r^2 it is the light L_i that arrives.
    pub(crate) power: Vector,
    /// The object that carries it and casts no shadow in it, or `NOBODY`.
    pub(crate) body: u32,
    /// The objects that it is on, or so close to that rounding, in the camera's space, might take it to the other side.
    pub(crate) contacts: Vec<(u32, Contact)>,
}

impl Lamp {
    /// How it lies to an object that it is close to.
    #[inline(always)]
    pub(crate) fn contact(&self, object: u32) -> Option<&Contact> {
        let close = self.contacts.iter().find(|(number, _)| *number == object);
        close.map(|(_, contact)| contact)
    }
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
    /// By what factor it was moved nearer to the eye.
    pub(crate) nearer: f64,
}

/// A scene made ready for tracing.
#[derive(Debug)]
pub(crate) struct Scene {
    /// How many of this space's units make one of the world's: a power of two.
    pub(crate) unit: f64,
    /// How much of the world's coordinates rounding takes, in this space's units.
    pub(crate) grain: f64,
    pub(crate) shapes: Vec<Shape>,
    pub(crate) looks: Vec<Look>,
    /// Whether any object was moved nearer to the eye.
    pub(crate) has_moved_bodies: bool,
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
        let looks = looks(world, &space)?;
        let mut scene = Scene {
            unit,
            grain: 2.0 * COORDINATE * largest(space.world(world.camera.position)),
            has_moved_bodies: looks.iter().any(|look| look.nearer < 1.0),
            looks,
            lamps: Vec::new(),
            planes,
            bvh: Bvh::new(&shapes)?,
            shapes,
        };
        scene.lamps = collect(
            world.lights.iter().map(|light| scene.lamp(&space, world, light)),
            "the lights",
        )?;
        Ok(scene)
    }

    fn lamp(&self, space: &Space<'_>, world: &World, light: &Light) -> Lamp {
        // The light of a lamp that is moved nearer is as much weaker as its square says.
        let nearer = space.nearer(light.position, 0.0);
        let unit = space.unit * nearer;
        let intensity = light.intensity * unit * unit / (4.0 * PI);
        let position = scale(space.place(light.position), nearer);
        let close = |i: u32| {
            let contact = space.contact(&world.objects[i as usize], light.position);
            let rounding = FAR_FROM_ROUNDING * (taxi(position) + self.shapes[i as usize].reach());
            contact.is_within(rounding).then_some((i, contact))
        };
        let mut stack = Stack::default();
        let around = Cone::around(position, self.grain + 2.0 * COORDINATE * taxi(position));
        let mut walk = self.bvh.walk(&around, &mut stack);
        let candidates = iter::from_fn(|| walk.next(0.0)).chain(self.planes.iter().copied());
        Lamp {
            position,
            nearer,
            power: scale(light.color, intensity.min(f64::MAX)),
            body: light.body.map_or(NOBODY, |body| body as u32),
            contacts: candidates.filter_map(close).collect(),
        }
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

    /// A place in the world's axes.
    fn world(&self, place: Vector) -> Vector {
        // Scaled first: the difference of huge places might overflow.
        place.map(|component| self.length(component))
    }

    /// A place relative to the eye, still in the world's axes.
    fn relative(&self, place: Vector) -> Vector {
        sub(self.world(place), self.world(self.camera.position))
    }

    /// How a place lies to an object.
    fn contact(&self, object: &Object, place: Vector) -> Contact {
        let (place, center) = (self.world(place), self.world(object.position));
        match object.form {
            Form::Sphere { radius } => Contact::with_sphere(place, center, self.length(radius)),
            Form::Plane { normal } => Contact::with_plane(place, center, unit_vector(normal)),
            Form::Box { size, rotation } => {
                Contact::with_box(place, center, &turned_axes(rotation), self.half(size))
            }
        }
    }

    fn half(&self, size: Vector) -> Vector {
        size.map(|side| self.length(side) / 2.0)
    }

    fn place(&self, place: Vector) -> Vector {
        self.direction(self.relative(place))
    }

    /// The factor that moves a place within reach of float32, in its direction from the eye; 1 for all but what is
    /// beyond everything that matters. What is made as much smaller looks the same from near the eye.
    fn nearer(&self, place: Vector, extent: f64) -> f64 {
        let away = largest(self.relative(place));
        if away > REACH && self.length(extent) < away / 2.0 {
            REACH / away
        } else {
            1.0
        }
    }

    /// The same for an object.
    fn nearer_of(&self, object: &Object) -> f64 {
        match object.form {
            Form::Plane { .. } => (REACH / self.offset(object).abs()).min(1.0),
            _ => self.nearer(object.position, extent(object)),
        }
    }

    /// How far a plane is from the eye, along its normal. In the world's axes it is 0 exactly if the eye is on it.
    fn offset(&self, plane: &Object) -> f64 {
        -self.contact(plane, self.camera.position).local[0]
    }

    fn direction(&self, direction: Vector) -> Vector {
        turned(&[self.camera.right, self.camera.up, self.camera.forward], direction)
    }

    fn shape(&self, object: &Object) -> Shape {
        let place = self.place(object.position);
        let nearer = self.nearer_of(object);
        let eye = self.contact(object, self.camera.position);
        match object.form {
            Form::Sphere { radius } => {
                let (place, radius) = (scale(place, nearer), self.length(radius) * nearer);
                let close = eye.is_within(FAR_ABOVE_ROUNDING * (taxi(place) + radius));
                Shape::Sphere(Sphere::new(place, radius, close.then_some(&eye)))
            }
            Form::Plane { normal } => {
                let offset = self.offset(object) * nearer;
                let normal = unit_vector(normal);
                let reach = spread(normal, self.relative(object.position));
                Shape::Plane(Plane::new(self.direction(normal), offset, reach))
            }
            Form::Box { size, rotation } => {
                let axes = turned_axes(rotation).map(|axis| self.direction(axis));
                let (place, half) = (scale(place, nearer), scale(self.half(size), nearer));
                let close = eye.is_within(FAR_FROM_ROUNDING * (taxi(place) + length(half)));
                let eye = if close {
                    eye.local
                } else {
                    turned(&axes, scale(place, -1.0))
                };
                Shape::Cuboid(Cuboid::new(place, axes, half, eye))
            }
        }
    }
}

fn looks(world: &World, space: &Space<'_>) -> Result<Vec<Look>, OutOfMemory> {
    let look = |object: &Object| Look {
        albedo: object.color,
        shining: None,
        nearer: space.nearer_of(object),
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

/// The farthest thing is kept within this power of two: its square stays within float32.
const LARGEST_EXPONENT: i32 = 58;

/// What is farther than this power of two times the typical distance does not count for the unit; see `Space::nearer`.
const FARTHEST_EXPONENT: i32 = 80;

/// Nor what of a lamp's distance is more than this power of two times that of all objects: its light is parallel.
const AS_GOOD_AS_PARALLEL: i32 = 30;

/// A power of two that brings the typical distance from the eye, or the size of what is larger, to about 1, or below if
/// something is very far away.
fn suitable_unit(world: &World) -> Result<f64, OutOfMemory> {
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
    // Of two the lower one: what is near matters more.
    let middle = (exponents.len() - 1) / 2;
    let (_, &mut typical, _) = exponents.select_nth_unstable(middle);
    let exponent = typical.max(farthest.min(typical + FARTHEST_EXPONENT) - LARGEST_EXPONENT);
    Ok(libm::scalbn(1.0, -exponent.clamp(-1000, 1000)))
}

/// The radius or the longest side of an object; 0 of a plane.
fn extent(object: &Object) -> f64 {
    match object.form {
        Form::Sphere { radius } => radius,
        Form::Plane { .. } => 0.0,
        Form::Box { size, .. } => size[0].max(size[1]).max(size[2]),
    }
}

fn unit_vector(direction: Vector) -> Vector {
    let largest = largest(direction);
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
