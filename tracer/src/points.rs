//! The points of a block that lie on one face, as the lamps see them.

use crate::grid::{LANES, Lanes, Rays, STEP};
use crate::plane::Plane;
use crate::scene::Shape;
use crate::shadow::ROUNDING;
use crate::vector::{add, length};
use crate::world::Vector;

/// Rounding in float32 is less than this share of the distances from the reference.
const TOUCHING: f32 = 4e-6;

/// Where rays of a block meet one flat face, or one sphere.
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
    /// What rounding may have taken from their places beside the share of their offsets.
    pub(crate) blur: f32,
}

/// A ball around points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ball {
    pub(crate) center: Vector,
    pub(crate) radius: f64,
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

    /// Put the points where rays meet a face of a shape, whose smallest depth is `t`, on the ray that `nearest` gives,
    /// and return its plane if it is flat.
    #[inline(always)]
    pub(crate) fn place(
        &mut self,
        rays: &Rays,
        shape: &Shape,
        face: u32,
        (t, nearest): (f64, impl Fn() -> Vector),
    ) -> Option<Plane> {
        self.count = rays.count;
        self.blur = (ROUNDING * shape.reach_of(face)) as f32;
        let plane = match shape {
            Shape::Sphere(sphere) => {
                self.reference = sphere.place(t, nearest, rays, self);
                return None;
            }
            Shape::Plane(plane) => plane.facing_the_eye(),
            Shape::Cuboid(cuboid) => cuboid.face(face),
        };
        self.reference = plane.place(t, rays, self);
        Some(plane)
    }

    /// A ball that holds all points.
    #[inline(always)]
    pub(crate) fn bound(&self) -> Ball {
        let mut middle = [0.0; 3];
        let mut half = [0.0; 3];
        for axis in 0..3 {
            // Step by step, each lane for itself: a single running minimum would not be vectorised.
            let (mut low, mut high) = ([f32::INFINITY; STEP], [f32::NEG_INFINITY; STEP]);
            for step in self.offset[axis][..self.padded()].chunks_exact(STEP) {
                for i in 0..STEP {
                    low[i] = if step[i] < low[i] { step[i] } else { low[i] };
                    high[i] = if step[i] > high[i] { step[i] } else { high[i] };
                }
            }
            let low = low.iter().fold(f32::INFINITY, |a, &b| a.min(b));
            let high = high.iter().fold(f32::NEG_INFINITY, |a, &b| a.max(b));
            middle[axis] = (f64::from(low) + f64::from(high)) / 2.0;
            half[axis] = (f64::from(high) - f64::from(low)) / 2.0;
        }
        Ball {
            center: add(self.reference, middle),
            radius: length(half),
        }
    }
}
