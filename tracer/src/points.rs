//! The points of a block that lie on one face, as the lamps see them.

use crate::grid::{Grid, LANES, Lanes};
use crate::plane::Plane;
use crate::scene::Shape;
use crate::vector::{add, length};
use crate::world::Vector;

/// Points are handled in groups of this many, so that loops over them need no rest.
pub(crate) const STEP: usize = 16;

/// Up to 256 points on one flat face, or on one sphere, gathered from the rays of a block.
#[derive(Clone, Debug)]
pub(crate) struct Points {
    /// How many.
    pub(crate) count: usize,
    /// The lane of each in its block.
    pub(crate) lane: [u8; LANES],
    /// The ray through the middle of the block.
    pub(crate) middle: Vector,
    /// What they are relative to.
    pub(crate) reference: Vector,
    /// Their rays, as in `Grid`.
    pub(crate) dx: Lanes,
    pub(crate) dy: Lanes,
    pub(crate) x: Lanes,
    pub(crate) y: Lanes,
    pub(crate) vv: Lanes,
    /// The points minus the reference.
    pub(crate) offset: [Lanes; 3],
    /// Unit normals that face the eye; of spheres only.
    pub(crate) normal: [Lanes; 3],
}

/// A ball around points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ball {
    pub(crate) center: Vector,
    pub(crate) radius: f64,
}

impl Points {
    pub(crate) fn new() -> Points {
        const ZERO: Lanes = [0.0; LANES];
        Points {
            count: 0,
            lane: [0; LANES],
            middle: [0.0; 3],
            reference: [0.0; 3],
            dx: ZERO,
            dy: ZERO,
            x: ZERO,
            y: ZERO,
            vv: ZERO,
            offset: [ZERO; 3],
            normal: [ZERO; 3],
        }
    }

    /// The count rounded up to whole steps.
    #[inline(always)]
    pub(crate) fn padded(&self) -> usize {
        self.count.next_multiple_of(STEP).min(LANES)
    }

    /// Take the rays of some lanes; the last step is filled up with the first of them.
    #[inline(always)]
    pub(crate) fn gather(&mut self, grid: &Grid, lanes: &[u8]) {
        self.middle = grid.middle;
        self.count = lanes.len().min(LANES);
        if self.count == LANES {
            // All lanes, which are in order.
            self.lane.copy_from_slice(&lanes[..LANES]);
            (self.dx, self.dy) = (grid.dx, grid.dy);
            (self.x, self.y, self.vv) = (grid.x, grid.y, grid.vv);
            return;
        }
        for i in 0..self.padded() {
            let lane = lanes[if i < self.count { i } else { 0 }];
            self.lane[i] = lane;
            let lane = usize::from(lane);
            self.dx[i] = grid.dx[lane];
            self.dy[i] = grid.dy[lane];
            self.x[i] = grid.x[lane];
            self.y[i] = grid.y[lane];
            self.vv[i] = grid.vv[lane];
        }
    }

    /// Put the points on a face of a shape whose smallest depth is `t`, and return its plane if it is flat.
    #[inline(always)]
    pub(crate) fn place(&mut self, shape: &Shape, face: u32, t: f64) -> Option<Plane> {
        let plane = match shape {
            Shape::Sphere(sphere) => {
                self.reference = sphere.place(t, self);
                return None;
            }
            Shape::Plane(plane) => plane.facing_the_eye(),
            Shape::Cuboid(cuboid) => cuboid.face(face),
        };
        self.reference = plane.place(t, self);
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
