//! The unit of camera space.

use crate::camera::{Camera, Projection};
use crate::memory::{OutOfMemory, collect, par_collect, reserve};
use crate::shapes::OBJECTS;
use crate::vector::Vector;
use crate::world::{LightDesc, LightSource, Object, World};
use rayon::prelude::*;

/// The farthest object or light stays within this power of two, so that its square stays within float32.
const LARGEST_EXPONENT: i32 = 58;

/// Objects and lights farther than this power of two times the typical distance do not affect the unit; see
/// `CameraSpace::range_scale`.
const FARTHEST_EXPONENT: i32 = 80;

/// The distance of a light counts at most this power of two times the largest distance of an object: its light is
/// parallel anyway.
const AS_GOOD_AS_PARALLEL: i32 = 30;

/// Return a power of two that scales the median of the objects' and lights' distances from the eye, or their sizes
/// if larger, to about 1, or below if something is very far away.
pub(crate) fn suitable_unit(world: &World) -> Result<f64, OutOfMemory> {
    let eye = world.camera.position;
    let exponent = |position: Vector, size: f64| {
        let away = |largest: f64, i: usize| largest.max((position[i] / 2.0 - eye[i] / 2.0).abs());
        let distance = (0..3).fold(size / 2.0, away);
        (distance > 0.0).then(|| libm::ilogb(distance))
    };
    let of_object = |object: &Object| exponent(object.position, object.shape.size());
    let exponents = par_collect(world.objects.par_iter().map(of_object), OBJECTS)?;
    let mut exponents = collect(exponents.into_iter().flatten(), OBJECTS)?;
    let Some(&farthest_object) = exponents.iter().max() else {
        return Ok(1.0);
    };
    let of_light = |light: &LightDesc| match light.source {
        LightSource::Point { position, radius } => exponent(position, radius),
        LightSource::Sun { .. } => None,
    };
    let lights = world.lights.iter().filter_map(of_light);
    reserve(&mut exponents, world.lights.len(), "the lights")?;
    exponents.extend(lights.map(|light| light.min(farthest_object + AS_GOOD_AS_PARALLEL)));
    let farthest = exponents.iter().copied().fold(farthest_object, i32::max);
    // The lower of two: near objects matter more.
    let middle = (exponents.len() - 1) / 2;
    let (_, &mut typical, _) = exponents.select_nth_unstable(middle);
    let farthest = farthest.min(typical + FARTHEST_EXPONENT).max(picture_exponent(&world.camera));
    let exponent = typical.max(farthest - LARGEST_EXPONENT);
    Ok(libm::scalbn(1.0, -exponent.clamp(-1000, 1000)))
}

/// The exponent of half the larger side of the picture in the world, where it has one.
fn picture_exponent(camera: &Camera) -> i32 {
    let aspect = camera.pixel_aspect * f64::from(camera.width) / f64::from(camera.height);
    match camera.projection {
        Projection::Perspective => i32::MIN / 2,
        Projection::Orthographic => libm::ilogb((camera.half_height * aspect.max(1.0)).min(f64::MAX)),
    }
}
