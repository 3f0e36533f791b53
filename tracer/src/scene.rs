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

/// A point light in camera space.
#[derive(Clone, Debug)]
pub(crate) struct Light {
    pub(crate) position: Vector,
    /// The factor by which it was moved toward the eye; see `CameraSpace::range_scale`.
    pub(crate) range_scale: f64,
    /// intensity * color / (4 pi), in units of camera space: L_i = power / r^2.
    pub(crate) power: Vector,
    /// The object that carries it, which casts no shadow in its light.
    pub(crate) carrier: Option<u32>,
    /// The objects that it is on, or so close to that rounding in camera space might move it to the other side.
    pub(crate) contacts: Vec<(u32, Contact)>,
}

impl Light {
    /// Where it is relative to an object that it is close to.
    #[inline(always)]
    pub(crate) fn contact(&self, object: u32) -> Option<&Contact> {
        let close = self.contacts.iter().find(|(number, _)| *number == object);
        close.map(|(_, contact)| contact)
    }
}

/// The appearance of an object, beside its shape.
#[derive(Clone, Debug)]
pub(crate) struct Material {
    /// Albedo, linear RGB.
    pub(crate) albedo: Vector,
    /// The radiance of an object that carries a light, uniform over its surface.
    pub(crate) emitted: Option<[f32; 3]>,
    /// The factor by which it was moved toward the eye; see `CameraSpace::range_scale`.
    pub(crate) range_scale: f64,
}

/// A scene ready for tracing.
#[derive(Debug)]
pub(crate) struct Scene {
    /// Units of camera space per unit of the world: a power of two.
    pub(crate) unit: f64,
    /// The rounding of the eye's coordinates, in units of camera space.
    pub(crate) coordinate_rounding: f64,
    pub(crate) shapes: Vec<Shape>,
    pub(crate) materials: Vec<Material>,
    /// Whether any object has a range scale other than 1.
    pub(crate) has_range_scales: bool,
    pub(crate) lights: Vec<Light>,
    /// The infinite shapes, which no tree can hold, by number.
    pub(crate) unbounded: Vec<u32>,
    /// The tree over all other shapes.
    pub(crate) bvh: Bvh,
}

impl Scene {
    /// Transform a world to camera space.
    ///
    /// # Errors
    ///
    /// If memory runs out.
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
            has_range_scales: materials.iter().any(|material| material.range_scale < 1.0),
            materials,
            lights: Vec::new(),
            unbounded,
            bvh: Bvh::new(numbered().filter_map(|(i, shape)| Some((i, shape.bounds()?))))?,
            shapes,
        };
        scene.lights = collect(world.lights.iter().map(|light| scene.light(&space, world, light)), "the lights")?;
        Ok(scene)
    }

    fn light(&self, space: &CameraSpace, world: &World, light: &LightDesc) -> Light {
        // The power of a light that is moved toward the eye shrinks by the square of the factor.
        let scaled = space.scaled(light.source.position());
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
        let around = Cone::around(position, self.coordinate_rounding + 2.0 * COORDINATE * l1_norm(position));
        let mut traversal = self.bvh.traverse(&around, &mut stack);
        let candidates = iter::from_fn(|| traversal.next(0.0)).chain(self.unbounded.iter().copied());
        Light {
            position,
            range_scale,
            power: scale(light.color, intensity.min(f64::MAX)),
            carrier: light.carrier.map(|carrier| carrier as u32),
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
    let r = length(sub(light.source.position(), eye));
    let arriving = light.intensity / (4.0 * PI * r * r);
    // 0 / 0: a light without power at the eye.
    let arriving = if arriving.is_nan() { 0.0 } else { arriving.min(largest) };
    light.color.map(|channel| (channel * arriving).min(largest) as f32)
}

#[cfg(test)]
mod tests;
