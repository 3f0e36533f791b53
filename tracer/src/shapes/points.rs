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
    /// How many.
    pub(crate) count: usize,
    /// What they are relative to.
    pub(crate) reference: Vector,
    /// The points minus the reference.
    pub(crate) offset: [Lanes; 3],
    /// Unit normals that face the eye; of spheres only.
    pub(crate) normal: [Lanes; 3],
    /// The rounding of their positions beside the share of their offsets.
    pub(crate) blur: f32,
}

impl Points {
    pub(crate) fn new() -> Points {
        Points {
            count: 0,
            reference: [0.0; 3],
            offset: [[0.0; LANES]; 3],
            normal: [[0.0; LANES]; 3],
            blur: 0.0,
        }
    }

    /// Make room for points on a shape of a magnitude.
    #[inline(always)]
    pub(crate) fn start(&mut self, count: usize, magnitude: f64) {
        self.count = count;
        self.blur = (ROUNDING * magnitude) as f32;
    }

    /// The count rounded up to whole steps.
    #[inline(always)]
    pub(crate) fn padded(&self) -> usize {
        self.count.next_multiple_of(STEP).min(LANES)
    }

    /// From a point to a place, given as it is from the reference.
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
        TOUCHING * (x[i].abs() + y[i].abs() + z[i].abs()) + self.blur
    }

    /// A sphere that holds all points.
    #[inline(always)]
    pub(crate) fn bounds(&self) -> BoundingSphere {
        let mut middle = [0.0; 3];
        let mut half = [0.0; 3];
        for axis in 0..3 {
            // Step by step, each lane for itself, and as integers: of floats the compiler makes no vectors, or
            // shuffles minima and maxima into one, at a third more time for a whole picture.
            let (mut low, mut high) = ([i32::MAX; STEP], [i32::MIN; STEP]);
            for step in self.offset[axis][..self.padded()].as_chunks::<STEP>().0 {
                for i in 0..STEP {
                    let (bits, known) = (ordered(step[i].to_bits() as i32), !step[i].is_nan());
                    low[i] = low[i].min(if known { bits } else { i32::MAX });
                    high[i] = high[i].max(if known { bits } else { i32::MIN });
                }
            }
            let low = low.into_iter().fold(i32::MAX, i32::min);
            let high = high.into_iter().fold(i32::MIN, i32::max);
            let [low, high] = [low, high].map(|bits| f32::from_bits(ordered(bits) as u32));
            middle[axis] = (f64::from(low) + f64::from(high)) / 2.0;
            half[axis] = (f64::from(high) - f64::from(low)) / 2.0;
        }
        BoundingSphere {
            center: add(self.reference, middle),
            radius: length(half),
        }
    }
}

/// The bits of a float as an integer in the same order, and back.
#[inline(always)]
fn ordered(bits: i32) -> i32 {
    bits ^ ((bits >> 31) as u32 >> 1) as i32
}
