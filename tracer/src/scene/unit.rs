//! The unit of camera space.

use crate::camera::{Camera, Projection};
use crate::vector::Vector;
use crate::world::{LightSource, Objects, World};
use rayon::prelude::*;

/// The farthest object or light stays within this power of two, so that its square stays within float32.
const LARGEST_EXPONENT: i32 = 58;

/// Objects and lights farther than this power of two times the typical distance do not affect the unit; see
/// `CameraSpace::range_scale`.
const FARTHEST_EXPONENT: i32 = 80;

/// The distance of a light counts at most this power of two times the largest distance of an object: its light is
/// parallel anyway.
const AS_GOOD_AS_PARALLEL: i32 = 30;

/// Along parallel rays, the typical distance counts at most this power of two times the size of the picture: what is
/// seen is that small, however far away most objects are.
const FARTHEST_FROM_PICTURE: i32 = 40;

/// Return a power of two that scales the median of the objects' and lights' distances from the eye, or their sizes
/// if larger, and the size of the picture along parallel rays, to about 1, or below if something is very far away.
pub(crate) fn suitable_unit(world: &World<impl Objects>) -> f64 {
    let (eye, objects) = (world.camera.position, &world.objects);
    let exponent = |position: Vector, size: f64| {
        let away = |largest: f64, i: usize| largest.max((position[i] / 2.0 - eye[i] / 2.0).abs());
        let distance = (0..3).fold(size / 2.0, away);
        (distance > 0.0).then(|| libm::ilogb(distance.min(f64::MAX)))
    };
    let of_object = |number: usize| exponent(objects.position(number), objects.shape(number).size());
    let numbers = (0..objects.count()).into_par_iter();
    let picture = picture_exponent(&world.camera);
    let mut exponents = numbers
        .fold(Exponents::new, |exponents, number| exponents.with(of_object(number)))
        .reduce(Exponents::new, Exponents::joined)
        .with(picture);
    let Some(farthest_object) = exponents.largest() else {
        return 1.0;
    };
    for light in &world.lights {
        if let LightSource::Point { position, radius } = light.source {
            let light = exponent(position, radius);
            exponents = exponents.with(light.map(|light| light.min(farthest_object + AS_GOOD_AS_PARALLEL)));
        }
    }
    let typical = exponents.median();
    let typical = picture.map_or(typical, |picture| typical.min(picture + FARTHEST_FROM_PICTURE));
    let farthest = exponents.largest().unwrap_or(farthest_object).min(typical + FARTHEST_EXPONENT);
    let farthest = picture.map_or(farthest, |picture| farthest.max(picture));
    let exponent = typical.max(farthest - LARGEST_EXPONENT);
    libm::scalbn(1.0, -exponent.clamp(-1000, 1000))
}

/// The number of distances with each exponent.
struct Exponents(Vec<usize>);

impl Exponents {
    const SMALLEST: i32 = f64::MIN_EXP - f64::MANTISSA_DIGITS as i32;

    fn new() -> Exponents {
        Exponents(vec![0; (f64::MAX_EXP - Exponents::SMALLEST) as usize])
    }

    fn with(mut self, exponent: Option<i32>) -> Exponents {
        if let Some(exponent) = exponent {
            self.0[(exponent - Exponents::SMALLEST) as usize] += 1;
        }
        self
    }

    fn joined(mut self, other: Exponents) -> Exponents {
        self.0.iter_mut().zip(other.0).for_each(|(count, more)| *count += more);
        self
    }

    fn largest(&self) -> Option<i32> {
        self.0.iter().rposition(|&count| count > 0).map(|index| index as i32 + Exponents::SMALLEST)
    }

    /// The lower of two in the middle: near objects matter more.
    fn median(&self) -> i32 {
        let total: usize = self.0.iter().sum();
        let mut up_to = self.0.iter().scan(0, |sum, count| {
            *sum += count;
            Some(*sum)
        });
        up_to.position(|sum| 2 * sum >= total).expect("there are distances") as i32 + Exponents::SMALLEST
    }
}

/// The exponent of half the larger side of the picture in the world, where it has one.
fn picture_exponent(camera: &Camera) -> Option<i32> {
    let aspect = camera.pixel_aspect * f64::from(camera.width) / f64::from(camera.height);
    let half = (camera.half_height * aspect.max(1.0)).min(f64::MAX);
    (camera.projection == Projection::Orthographic && half > 0.0).then(|| libm::ilogb(half))
}
