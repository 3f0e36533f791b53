//! A world in camera space, ready for tracing.

use crate::accel::cone::Cone;
use crate::accel::{Bvh, Stack};
use crate::camera_space::{CameraSpace, FAR_FROM_ROUNDING};
use crate::memory::{OutOfMemory, collect};
use crate::scene::unit::{OBJECTS, suitable_unit};
use crate::shapes::Shape;
use crate::shapes::contact::{COORDINATE, Contact};
use crate::shapes::primitive::Primitive;
use crate::vector::{Vector, l1_norm, largest, length, scale, sub};
use crate::world::{LightDesc, Object, World};
use std::f64::consts::PI;
use std::iter;

mod unit;

/// A point light in the camera's space.
#[derive(Clone, Debug)]
pub(crate) struct Light {
    /// Where it stands.
    pub(crate) position: Vector,
    /// By what factor it was moved nearer to the eye.
    pub(crate) range_scale: f64,
    /// intensity * color / (4 pi), in units of this space: over r^2 it is the light L_i that arrives.
    pub(crate) power: Vector,
    /// The object that carries it and casts no shadow in it, or `NO_OBJECT`.
    pub(crate) carrier: u32,
    /// The objects that it is on, or so close to that rounding, in the camera's space, might take it to the other
    /// side.
    pub(crate) contacts: Vec<(u32, Contact)>,
}

impl Light {
    /// How it lies to an object that it is close to.
    #[inline(always)]
    pub(crate) fn contact(&self, object: u32) -> Option<&Contact> {
        let close = self.contacts.iter().find(|(number, _)| *number == object);
        close.map(|(_, contact)| contact)
    }
}

/// No object's number.
pub(crate) const NO_OBJECT: u32 = u32::MAX;

/// What an object looks like, beside its shape.
#[derive(Clone, Debug)]
pub(crate) struct Material {
    /// Albedo, linear RGB.
    pub(crate) albedo: Vector,
    /// The radiance of an object that carries a light, the same from all its surface.
    pub(crate) emitted: Option<[f32; 3]>,
    /// By what factor it was moved nearer to the eye.
    pub(crate) range_scale: f64,
}

/// A scene made ready for tracing.
#[derive(Debug)]
pub(crate) struct Scene {
    /// How many of this space's units make one of the world's: a power of two.
    pub(crate) unit: f64,
    /// The rounding of the world's coordinates, in this space's units.
    pub(crate) coordinate_rounding: f64,
    pub(crate) shapes: Vec<Shape>,
    pub(crate) materials: Vec<Material>,
    /// Whether any object was moved nearer to the eye.
    pub(crate) has_moved_bodies: bool,
    pub(crate) lights: Vec<Light>,
    /// The numbers of the infinite shapes, which no tree can hold.
    pub(crate) unbounded: Vec<u32>,
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
        let space = CameraSpace::new(&world.camera, suitable_unit(world)?);
        let materials = materials(world, &space)?;
        let shape = |(object, material): (&Object, &Material)| {
            let position = space.scaled(object.position);
            object.shape.transform(&space, position, material.range_scale)
        };
        let shapes = collect(world.objects.iter().zip(&materials).map(shape), OBJECTS)?;
        let numbered = || (0..).zip(&shapes);
        let unbounded = numbered().filter(|(_, shape)| shape.bounds().is_none());
        let unbounded = collect(unbounded.map(|(i, _)| i), OBJECTS)?;
        let mut scene = Scene {
            unit: space.unit,
            coordinate_rounding: 2.0 * COORDINATE * largest(space.eye),
            has_moved_bodies: materials.iter().any(|material| material.range_scale < 1.0),
            materials,
            lights: Vec::new(),
            unbounded,
            bvh: Bvh::new(numbered().filter_map(|(i, shape)| Some((i, shape.bounds()?))))?,
            shapes,
        };
        scene.lights = collect(
            world.lights.iter().map(|light| scene.light(&space, world, light)),
            "the lights",
        )?;
        Ok(scene)
    }

    fn light(&self, space: &CameraSpace, world: &World, light: &LightDesc) -> Light {
        // A light moved nearer weakens by the square of the factor.
        let scaled = space.scaled(light.position);
        let range_scale = space.range_scale(scaled, 0.0);
        let unit = space.unit * range_scale;
        let intensity = light.intensity * unit * unit / (4.0 * PI);
        let position = scale(space.point(scaled), range_scale);
        let close = |i: u32| {
            let object = &world.objects[i as usize];
            let contact = object.shape.contact(space, space.scaled(object.position), scaled);
            let rounding = FAR_FROM_ROUNDING * (l1_norm(position) + self.shapes[i as usize].magnitude());
            contact.is_within(rounding).then_some((i, contact))
        };
        let mut stack = Stack::default();
        let around = Cone::around(
            position,
            self.coordinate_rounding + 2.0 * COORDINATE * l1_norm(position),
        );
        let mut traversal = self.bvh.traverse(&around, &mut stack);
        let candidates = iter::from_fn(|| traversal.next(0.0)).chain(self.unbounded.iter().copied());
        Light {
            position,
            range_scale,
            power: scale(light.color, intensity.min(f64::MAX)),
            carrier: light.carrier.map_or(NO_OBJECT, |carrier| carrier as u32),
            contacts: candidates.filter_map(close).collect(),
        }
    }
}

fn materials(world: &World, space: &CameraSpace) -> Result<Vec<Material>, OutOfMemory> {
    let material = |object: &Object| Material {
        albedo: object.color,
        emitted: None,
        range_scale: object.shape.range_scale(space, space.scaled(object.position)),
    };
    let mut materials = collect(world.objects.iter().map(material), OBJECTS)?;
    for light in &world.lights {
        if let Some(carrier) = light.carrier {
            materials[carrier].emitted = Some(seen_directly(light, world.camera.position));
        }
    }
    Ok(materials)
}

/// L = intensity color / (4 pi r^2), r from the light to the eye (document, section 3.4).
fn seen_directly(light: &LightDesc, eye: Vector) -> [f32; 3] {
    let largest = f64::from(f32::MAX);
    let r = length(sub(light.position, eye));
    let arriving = light.intensity / (4.0 * PI * r * r);
    // 0 / 0: a light without power at the eye.
    let arriving = if arriving.is_nan() { 0.0 } else { arriving.min(largest) };
    light.color.map(|channel| (channel * arriving).min(largest) as f32)
}

#[cfg(test)]
mod tests;
