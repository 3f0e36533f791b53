//! The points of a tile that lie on one face, as the lights see them.

use crate::bounds::BoundingSphere;
use crate::tile::{LANES, Lanes, STEP};
use crate::vector::{Vector, add, length};

/// Rounding in float64 is less than this share of the distances from the eye.
pub(crate) const ROUNDING: f64 = 1e-13;

/// Rounding in float32 is less than this share of the distances from the reference.
const TOUCHING: f32 = 4e-6;

/// Where rays of a tile meet one flat face, or one sphere.
#[derive(Clone, Debug)]
pub(crate) struct Points {
    /// The number of points.
    pub(crate) count: usize,
    /// The point that the offsets are relative to.
    pub(crate) reference: Vector,
    /// The points minus the reference.
    pub(crate) offset: [Lanes; 3],
    /// Unit normals that face the eye; of spheres only.
    pub(crate) normal: [Lanes; 3],
    /// The position error that does not depend on the offset.
    pub(crate) error: f32,
}

impl Points {
    pub(crate) fn new() -> Points {
        Points { count: 0, reference: [0.0; 3], offset: [[0.0; LANES]; 3], normal: [[0.0; LANES]; 3], error: 0.0 }
    }

    /// Begin points on a shape of a magnitude.
    #[inline(always)]
    pub(crate) fn start(&mut self, count: usize, magnitude: f64) {
        self.count = count;
        self.error = (ROUNDING * magnitude) as f32;
    }

    /// The count rounded up to a multiple of `STEP`.
    #[inline(always)]
    pub(crate) fn padded(&self) -> usize {
        self.count.next_multiple_of(STEP).min(LANES)
    }

    /// Return the vector from a point to another, given relative to the reference.
    #[inline(always)]
    pub(crate) fn toward(&self, place: [f32; 3], i: usize) -> [f32; 3] {
        std::array::from_fn(|axis| place[axis] - self.offset[axis][i])
    }

    /// What rounding may have taken from the place of a point: what is closer touches.
    ///
    /// It depends on nothing but the point, as all that decides a pixel.
    #[inline(always)]
    pub(crate) fn slack(&self, i: usize) -> f32 {
        let [x, y, z] = &self.offset;
        TOUCHING * (x[i].abs() + y[i].abs() + z[i].abs()) + self.error
    }

    /// A sphere that holds all points.
    #[inline(always)]
    pub(crate) fn bounds(&self) -> BoundingSphere {
        let mut middle = [0.0; 3];
        let mut half = [0.0; 3];
        for axis in 0..3 {
            let [low, high] = extremes(&self.offset[axis][..self.padded()]);
            middle[axis] = (f64::from(low) + f64::from(high)) / 2.0;
            half[axis] = (f64::from(high) - f64::from(low)) / 2.0;
        }
        BoundingSphere { center: add(self.reference, middle), radius: length(half) }
    }
}

/// The smallest and the largest of values, NaN aside.
///
/// As integers in the order of floats, which the compiler reduces in vectors wherever it inlines this. Of floats,
/// or of arrays of integers, it makes shuffles, gathers or nothing, depending on the context: a quarter of a
/// picture's time.
#[inline(always)]
fn extremes(values: &[f32]) -> [f32; 2] {
    let (mut low, mut high) = (i32::MAX, i32::MIN);
    for value in values {
        let bits = ordered(value.to_bits() as i32);
        low = low.min(bits);
        high = high.max(bits);
    }
    let found = [low, high].map(|bits| f32::from_bits(ordered(bits) as u32));
    if found[0].is_nan() || found[1].is_nan() {
        return known_extremes(values);
    }
    found
}

#[cold]
#[inline(never)]
fn known_extremes(values: &[f32]) -> [f32; 2] {
    values.iter().fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], &x| [low.min(x), high.max(x)])
}

/// The bits of a float as an integer in the order of floats, NaN below or above all others, and back.
#[inline(always)]
fn ordered(bits: i32) -> i32 {
    bits ^ ((bits >> 31) as u32 >> 1) as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extremes_are_those_of_the_values_that_are_numbers() {
        assert_eq!(extremes(&[1.5, -2.0, 0.0, -0.5, 1e-40]), [-2.0, 1.5]);
        assert_eq!(extremes(&[-3.0, -1e-40, f32::NEG_INFINITY]), [f32::NEG_INFINITY, -1e-40]);
        assert_eq!(extremes(&[3.0, f32::NAN, 2.0, -f32::NAN]), [2.0, 3.0]);
    }
}
