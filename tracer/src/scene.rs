//! A world in camera space, ready for tracing.

use crate::accel::cone::Cone;
use crate::accel::{Bvh, Stack};
use crate::apex::Apex;
use crate::camera::{Camera, Projection};
use crate::camera_space::{CameraSpace, FAR_FROM_ROUNDING};
use crate::checker::Checker;
use crate::memory::{OutOfMemory, collect, filled, par_collect, reserve, with_capacity};
use crate::sampling::emitter_places;
use crate::scene::emitter::{Emitter, LIGHTS};
use crate::scene::far::{FarObjects, is_far};
use crate::scene::unit::suitable_unit;
use crate::shapes::contact::{COORDINATE, Contact};
use crate::shapes::primitive::Primitive;
use crate::shapes::{OBJECTS, Placed, ShapeDesc, Shapes};
use crate::vector::{Vector, add, dot, l1_norm, largest, length, normalized, scale, sub};
use crate::world::{CheckerDesc, LightDesc, LightSource, Objects, World};
use rayon::prelude::*;
use std::f64::consts::PI;
use std::hint::black_box;
use std::iter;
use std::sync::atomic::AtomicBool;
use std::sync::atomic::Ordering::Relaxed;

pub(crate) mod emitter;
pub(crate) mod far;
mod unit;

/// A light in camera space.
#[derive(Clone, Debug)]
pub(crate) struct Light {
    pub(crate) apex: Apex,
    /// The factor by which it was moved toward the eye, see `CameraSpace::range_scale`; 0 if it is infinitely far away.
    pub(crate) range_scale: f64,
    /// intensity * color / (4 pi), in units of camera space: L_i = power / r^2. Of a sun, L_i.
    pub(crate) power: Vector,
    /// The number in the world of the object that carries it, which casts no shadow in its light.
    pub(crate) carrier: Option<u32>,
    /// Its places, if it has a size.
    pub(crate) emitter: Option<Emitter>,
    /// The objects that it, or one of its places, is on, or so close to that rounding in camera space might move it
    /// to the other side: the number of the place and of the object.
    pub(crate) contacts: Vec<(u32, u32, Contact)>,
}

impl Light {
    /// Where it, or one of its places, is relative to an object that it is close to.
    #[inline(always)]
    pub(crate) fn contact(&self, place: u32, object: u32) -> Option<&Contact> {
        let close = self.contacts.iter().find(|(at, number, _)| *number == object && *at == place);
        close.map(|(_, _, contact)| contact)
    }

    /// Whether it was moved toward the eye.
    #[inline(always)]
    pub(crate) fn was_moved(&self) -> bool {
        0.0 < self.range_scale && self.range_scale < 1.0
    }
}

/// A scene ready for tracing.
#[derive(Debug)]
pub(crate) struct Scene {
    pub(crate) projection: Projection,
    /// Units of camera space per unit of the world: a power of two.
    pub(crate) unit: f64,
    /// The rounding of the eye's coordinates, in units of camera space.
    pub(crate) coordinate_rounding: f64,
    /// The objects, kind by kind, those of each kind in the order of the tree: neighbours in space are neighbours in
    /// memory. An object's index here is its number in the kernel.
    pub(crate) shapes: Shapes,
    /// Linear RGB of each object.
    pub(crate) albedos: Vec<Vector>,
    /// The range scale of each object; empty if all are 1.
    pub(crate) range_scales: Vec<f64>,
    /// The objects whose shadows may have to be found in float64.
    pub(crate) far: FarObjects,
    /// The radiance of each object that carries a light, uniform over its surface; empty if none does.
    emitted: Vec<Option<[f32; 3]>>,
    /// The checkers, in the order of the objects.
    pub(crate) checkers: Vec<Checker>,
    /// The number of each object in the world.
    pub(crate) numbers: Vec<u32>,
    pub(crate) lights: Vec<Light>,
    /// The number of lights, counting each place of one that has a size.
    pub(crate) pencils: u64,
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
    pub(crate) fn new(world: &World<impl Objects>) -> Result<Scene, OutOfMemory> {
        let (space, objects) = (CameraSpace::new(&world.camera, suitable_unit(world)), &world.objects);
        let (are_moved, are_far) = (AtomicBool::new(false), AtomicBool::new(false));
        let place = |number: u32| {
            let (shape, position) =
                (objects.shape(number as usize), space.scaled(objects.position(number as usize)));
            let range_scale = match world.camera.projection {
                Projection::Perspective => shape.range_scale(&space, position),
                // Elsewhere it would not look the same.
                Projection::Orthographic => 1.0,
            };
            if range_scale < 1.0 {
                are_moved.store(true, Relaxed);
            }
            Placed { shape, position, range_scale }
        };
        let bounds = (0..objects.count()).into_par_iter().map(|number| {
            let placed = place(number as u32);
            let bounds = placed.bounds(&space);
            if is_far(bounds, placed.range_scale) {
                are_far.store(true, Relaxed);
            }
            bounds
        });
        let (mut bvh, mut numbers) = Bvh::new(bounds)?;
        let counts = sort_by_kind(&mut numbers, &mut bvh, |number| objects.kind(number as usize))?;
        let read = |number: u32| {
            black_box((objects.position(number as usize), objects.shape(number as usize)));
        };
        let shapes = Shapes::new(&space, (&numbers, &counts), (place, read))?;
        let range_scale = |&number: &u32| place(number).range_scale;
        let mut scene = Scene {
            projection: world.camera.projection,
            unit: space.unit,
            coordinate_rounding: 2.0 * COORDINATE * largest(space.eye),
            albedos: par_collect(numbers.par_iter().map(|&number| objects.color(number as usize)), OBJECTS)?,
            range_scales: if are_moved.load(Relaxed) {
                par_collect(numbers.par_iter().map(range_scale), OBJECTS)?
            } else {
                Vec::new()
            },
            far: FarObjects::default(),
            emitted: emitted(world, &numbers)?,
            checkers: Vec::new(),
            lights: Vec::new(),
            pencils: 0,
            unbounded: shapes.unbounded()?,
            bvh,
            shapes,
            numbers,
        };
        if are_far.load(Relaxed) {
            let scales = (0..).map(|index| (index, scene.range_scale(index)));
            let objects = scales.take(scene.numbers.len());
            let far = objects.filter(|&(index, scale)| is_far(scene.shapes.get(index).bounds(), scale));
            scene.far = FarObjects::new(far)?;
        }
        scene.checkers = scene.place_checkers(&space, world)?;
        let mut lights = with_capacity(world.lights.len(), LIGHTS)?;
        let pattern = emitter_places(world.settings.shadow_samples);
        for light in &world.lights {
            let light = scene.light(&space, world, (light, &pattern))?;
            scene.pencils += light.emitter.as_ref().map_or(1, |emitter| emitter.places.len() as u64);
            lights.push(light);
        }
        scene.lights = lights;
        Ok(scene)
    }

    /// The factor by which an object was moved toward the eye; see `CameraSpace::range_scale`.
    #[inline(always)]
    pub(crate) fn range_scale(&self, object: u32) -> f64 {
        self.range_scales.get(object as usize).copied().unwrap_or(1.0)
    }

    /// Whether an object carries a light.
    #[inline(always)]
    pub(crate) fn carries(&self, object: u32, light: &Light) -> bool {
        light.carrier.is_some_and(|number| number == self.numbers[object as usize])
    }

    /// The radiance of an object, if it carries a light.
    #[inline(always)]
    pub(crate) fn emitted(&self, object: u32) -> Option<[f32; 3]> {
        self.emitted.get(object as usize).copied().flatten()
    }

    /// The checker of an object, if it has one.
    #[inline(always)]
    pub(crate) fn checker(&self, object: u32) -> Option<&Checker> {
        if self.checkers.is_empty() {
            return None;
        }
        let index = self.checkers.binary_search_by_key(&object, |checker| checker.object);
        index.ok().map(|index| &self.checkers[index])
    }

    /// Return the checkers in the order of the objects; objects without flat faces have none.
    fn place_checkers(
        &self,
        space: &CameraSpace,
        world: &World<impl Objects>,
    ) -> Result<Vec<Checker>, OutOfMemory> {
        if world.checkers.is_empty() {
            return Ok(Vec::new());
        }
        let mut in_kernel = filled(self.numbers.len(), 0, OBJECTS)?;
        for (index, &number) in (0..).zip(&self.numbers) {
            in_kernel[number as usize] = index;
        }
        let place = |checker: &CheckerDesc| {
            let axes = world.objects.shape(checker.object).face_axes(space)?;
            let (index, position) = (in_kernel[checker.object], world.objects.position(checker.object));
            Some(Checker::new(space, checker, (index, axes), (space.scaled(position), self.range_scale(index))))
        };
        let mut checkers = Vec::new();
        reserve(&mut checkers, world.checkers.len(), OBJECTS)?;
        checkers.extend(world.checkers.iter().filter_map(place));
        checkers.sort_unstable_by_key(|checker| checker.object);
        Ok(checkers)
    }

    fn light(
        &self,
        space: &CameraSpace,
        world: &World<impl Objects>,
        (light, pattern): (&LightDesc, &[Vector]),
    ) -> Result<Light, OutOfMemory> {
        let carrier = light.carrier.map(|carrier| carrier as u32);
        let powered = |intensity: f64| scale(light.color, intensity.min(f64::MAX));
        let (position, radius) = match light.source {
            LightSource::Point { position, radius } => (position, radius),
            LightSource::Sun { direction, angle } => {
                let toward = scale(normalized(direction), -1.0);
                return Ok(Light {
                    apex: Apex::direction(space.direction(toward)),
                    range_scale: 0.0,
                    power: powered(light.intensity),
                    carrier,
                    emitter: if angle > 0.0 { Some(Emitter::sun(space, toward, angle, pattern)?) } else { None },
                    contacts: Vec::new(),
                });
            }
        };
        // The power of a light that is moved toward the eye shrinks by the square of the factor.
        let scaled = space.scaled(position);
        let range_scale = space.range_scale(scaled, space.length(radius));
        let unit = space.unit * range_scale;
        let intensity = light.intensity * unit * unit / (4.0 * PI);
        let position = scale(space.point(scaled), range_scale);
        let mut emitter = match space.length(radius) * range_scale {
            radius if radius > 0.0 => Some(Emitter::ball(space, position, radius, pattern)?),
            _ => None,
        };
        let mut contacts = Vec::new();
        let size = emitter.as_ref().map_or(0.0, |emitter| emitter.size);
        let mut stack = Stack::default();
        let slack = size + self.coordinate_rounding + 2.0 * COORDINATE * l1_norm(position);
        let around = Cone::around(position, slack);
        let mut traversal = self.bvh.traverse(&around, &mut stack);
        let candidates = iter::from_fn(|| traversal.next(0.0)).chain(self.unbounded.iter().copied());
        for i in candidates {
            let number = self.numbers[i as usize] as usize;
            let (shape, center) = (world.objects.shape(number), space.scaled(world.objects.position(number)));
            let rounding = FAR_FROM_ROUNDING * (l1_norm(position) + self.shapes.get(i).magnitude());
            let mut touch = |place: u32, point: Vector| {
                let contact = shape.contact(space, center, point);
                if contact.is_within(rounding) {
                    contacts.push((place, i, contact));
                }
            };
            let Some(emitter) = &mut emitter else {
                touch(0, scaled);
                continue;
            };
            // In the units of the world, as contacts are.
            if shape.contact(space, center, scaled).is_within(size / range_scale + rounding) {
                emitter.cut.push(i);
                for (place, way) in (0..).zip(pattern) {
                    touch(place, add(scaled, scale(*way, size / range_scale)));
                }
            }
        }
        Ok(Light {
            apex: Apex::point(position),
            range_scale,
            power: powered(intensity),
            carrier,
            emitter,
            contacts,
        })
    }
}

/// Sort objects, which are in the order of a tree, by their kinds, renumber its leaves, and return the count of each
/// kind.
fn sort_by_kind(
    numbers: &mut Vec<u32>,
    bvh: &mut Bvh,
    kind: impl Fn(u32) -> usize + Sync,
) -> Result<Vec<usize>, OutOfMemory> {
    let kinds = par_collect(numbers.par_iter().map(|&number| kind(number) as u8), OBJECTS)?;
    let mut counts = vec![0; ShapeDesc::KINDS.len()];
    for &kind in &kinds {
        counts[usize::from(kind)] += 1;
    }
    if kinds.is_sorted() {
        return Ok(counts);
    }
    let mut next: Vec<usize> = (0..counts.len()).map(|kind| counts[..kind].iter().sum()).collect();
    let mut sorted = filled(numbers.len(), 0, OBJECTS)?;
    let place = |(&number, &kind): (&u32, &u8)| {
        let next = &mut next[usize::from(kind)];
        let position = *next;
        *next += 1;
        sorted[position] = number;
        position as u32
    };
    let positions = collect(numbers.iter().zip(&kinds).map(place), OBJECTS)?;
    bvh.renumber(&positions);
    *numbers = sorted;
    Ok(counts)
}

/// Return the radiance of each object that carries a light, for objects given by their numbers; nothing if none does.
fn emitted(world: &World<impl Objects>, numbers: &[u32]) -> Result<Vec<Option<[f32; 3]>>, OutOfMemory> {
    if world.lights.iter().all(|light| light.carrier.is_none()) {
        return Ok(Vec::new());
    }
    let mut emitted = filled(numbers.len(), None, OBJECTS)?;
    for light in &world.lights {
        if let (Some(carrier), Some(position)) = (light.carrier, light.source.position()) {
            emitted[carrier] = Some(seen_directly(light, position, &world.camera));
        }
    }
    par_collect(numbers.par_iter().map(|&number| emitted[number as usize]), OBJECTS)
}

/// L = intensity color / (4 pi r^2), r from the light to the eye (document, section 3.4), or along the view to the
/// plane on which parallel rays start.
fn seen_directly(light: &LightDesc, position: Vector, camera: &Camera) -> [f32; 3] {
    let largest = f64::from(f32::MAX);
    let to_light = sub(position, camera.position);
    let r = match camera.projection {
        Projection::Perspective => length(to_light),
        Projection::Orthographic => dot(camera.forward, to_light).abs(),
    };
    let arriving = light.intensity / (4.0 * PI * r * r);
    // 0 / 0: a light without power at the eye.
    let arriving = if arriving.is_nan() { 0.0 } else { arriving.min(largest) };
    light.color.map(|channel| (channel * arriving).min(largest) as f32)
}

#[cfg(test)]
mod tests;
