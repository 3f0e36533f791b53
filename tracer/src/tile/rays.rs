//! The rays of a tile: 16 x 16 pixels of the image plane, at a fixed position in the whole picture.
//!
//! Everything in a tile is computed relative to its middle ray, whose constants are float64. So float32 only
//! carries differences within the tile, and a small object far away is as round as a large one nearby. The grid of
//! tiles is fixed to the picture: no pixel depends on the division among threads, or on a crop.

use crate::camera::Projection;
use crate::tile::{LANES, Lanes, SIDE, STEP, View};
use crate::vector::{Vector, to_f32};

/// Faces whose depths differ by less than this share are compared in float64. Rounding is a fifth of it where the
/// ray does not graze them.
pub(crate) const CLOSE: f32 = 3e-6;

/// The rounding of the plane on which parallel rays start, as a share of how far they are from its middle.
const START_ROUNDING: f64 = 1e-13;

/// A ray o + t v; t is the depth.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    pub(crate) origin: Vector,
    pub(crate) direction: Vector,
    /// Only what it meets at a larger depth counts.
    pub(crate) start: f64,
}

/// Rays of a tile, through the same point of each pixel, or some of them.
///
/// Through the point (x, y, 1) of the image plane, those of a pencil are v = (x, y, 1) from the eye, which is the
/// origin, and parallel ones v = (0, 0, 1) from (x, y, 0).
#[derive(Clone, Debug)]
pub(crate) struct Rays {
    /// The number of rays.
    pub(crate) count: usize,
    pub(crate) projection: Projection,
    /// The origin of the ray through the middle of the part of the tile that is inside the picture.
    pub(crate) origin: Vector,
    /// The direction of that ray.
    pub(crate) middle: Vector,
    /// Half the width and half the height of that part on the image plane.
    pub(crate) half_size: (f64, f64),
    /// x on the image plane minus that of the middle.
    pub(crate) dx: Lanes,
    /// y on the image plane minus that of the middle.
    pub(crate) dy: Lanes,
    /// The components of v.
    pub(crate) x: Lanes,
    pub(crate) y: Lanes,
    /// v . v
    pub(crate) vv: Lanes,
    /// The pattern that dx and dy hold.
    pattern: Pattern,
}

/// The parameters of a tile's rays that do not depend on its position.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Pattern {
    /// Columns and rows that are inside the picture.
    inside: (u32, u32),
    /// Half the width and half the height of a pixel on the image plane.
    half_pixel: (f64, f64),
    /// The sample's offset in each pixel.
    within: (f64, f64),
}

impl Pattern {
    /// The offset of a lane's ray from the middle one, on the image plane.
    #[inline(always)]
    fn offset(self, lane: usize) -> (f64, f64) {
        let (i, j) = (lane as u32 % SIDE, lane as u32 / SIDE);
        let right = 2.0 * (f64::from(i) + self.within.0) - f64::from(self.inside.0);
        let down = 2.0 * (f64::from(j) + self.within.1) - f64::from(self.inside.1);
        (right * self.half_pixel.0, -down * self.half_pixel.1)
    }
}

/// The rounding of the depths of parallel rays, which is generous, suffices down to this |cos|, and grows at most by
/// the factor.
const SLANT: f32 = 1.0 / 16.0;
pub(crate) const MOST_AT_A_SLANT: f32 = 1000.0;

/// The rounding of the depths of parallel rays on a surface that they meet at some |cos|: it grows like the depths
/// across the tile.
#[inline(always)]
pub(crate) fn at_a_slant(rounding: f32, cosine: f64) -> f32 {
    rounding * (SLANT / cosine.abs() as f32).clamp(1.0, MOST_AT_A_SLANT)
}

impl Rays {
    pub(crate) fn new() -> Rays {
        Rays {
            count: 0,
            projection: Projection::Perspective,
            origin: [0.0; 3],
            middle: [0.0, 0.0, 1.0],
            half_size: (0.0, 0.0),
            dx: [0.0; LANES],
            dy: [0.0; LANES],
            x: [0.0; LANES],
            y: [0.0; LANES],
            vv: [0.0; LANES],
            pattern: Pattern::default(),
        }
    }

    /// Generate the rays at an offset `within` each pixel of the tile whose first column and row are `corner`.
    ///
    /// With half a pixel's width and height, and the picture's middle on the image plane (document, section 2.1, as
    /// corrected, which has it at (0, 0)):
    ///
    /// x = (2 pixel_x - width) half_width + center_x,  y = (height - 2 pixel_y) half_height + center_y
    #[inline(always)]
    pub(crate) fn generate(&mut self, view: View, corner: (u32, u32), within: (f64, f64)) {
        let inside = (SIDE.min(view.width - corner.0), SIDE.min(view.height - corner.1));
        let (half_width, half_height) = view.half_pixel;
        let (center_x, center_y) = view.center;
        self.count = LANES;
        // 2 (corner + inside / 2) is a whole number.
        let x = (f64::from(2 * corner.0 + inside.0) - f64::from(view.width)) * half_width + center_x;
        let y = (f64::from(view.height) - f64::from(2 * corner.1 + inside.1)) * half_height + center_y;
        self.projection = view.projection;
        (self.origin, self.middle) = match view.projection {
            Projection::Perspective => ([0.0; 3], [x, y, 1.0]),
            Projection::Orthographic => ([x, y, 0.0], [0.0, 0.0, 1.0]),
        };
        self.half_size = (f64::from(inside.0) * half_width, f64::from(inside.1) * half_height);
        let pattern = Pattern { inside, half_pixel: view.half_pixel, within };
        if self.pattern != pattern {
            self.pattern = pattern;
            self.spread();
        }
        self.complete();
    }

    /// Compute dx and dy.
    fn spread(&mut self) {
        // A copy, which writes to dx cannot alias.
        let pattern = self.pattern;
        for lane in 0..LANES {
            let (dx, dy) = pattern.offset(lane);
            self.dx[lane] = dx as f32;
            self.dy[lane] = dy as f32;
        }
    }

    /// The ray of a lane of a whole tile, in float64.
    pub(crate) fn exact(&self, lane: usize) -> Ray {
        let (dx, dy) = self.pattern.offset(lane);
        let beside = |[x, y, z]: Vector| [x + dx, y + dy, z];
        match self.projection {
            Projection::Perspective => Ray { origin: [0.0; 3], direction: beside(self.middle), start: 0.0 },
            Projection::Orthographic => {
                Ray { origin: beside(self.origin), direction: self.middle, start: self.start() }
            }
        }
    }

    /// Whether the rays are parallel.
    #[inline(always)]
    pub(crate) fn are_parallel(&self) -> bool {
        self.projection == Projection::Orthographic
    }

    /// How far apart two rays are at a depth, per distance on the image plane.
    #[inline(always)]
    pub(crate) fn divergence(&self, depth: f64) -> f64 {
        if self.are_parallel() { 1.0 } else { depth }
    }

    /// The depth at which a surface counts as seen: a surface in the plane on which parallel rays start is not.
    #[inline(always)]
    pub(crate) fn start(&self) -> f64 {
        START_ROUNDING * (self.origin[0].abs() + self.origin[1].abs() + self.parallel_extent())
    }

    /// The depth at which parallel rays start, and the rounding of their depths in float32; see `at_a_slant`.
    #[inline(always)]
    pub(crate) fn limits(&self) -> (f32, f32) {
        (self.start() as f32, CLOSE * self.parallel_extent() as f32)
    }

    /// The size of the tile for parallel rays, 0 for a pencil: float32 depths have a rounding that is a share of it.
    #[inline(always)]
    pub(crate) fn parallel_extent(&self) -> f64 {
        if self.are_parallel() { self.half_size.0 + self.half_size.1 } else { 0.0 }
    }

    /// The width of a pixel on the image plane.
    pub(crate) fn pixel(&self) -> f64 {
        2.0 * self.pattern.half_pixel.0
    }

    /// Whether the pixel of a lane is inside the picture.
    pub(crate) fn is_inside(&self, lane: usize) -> bool {
        let (columns, rows) = self.pattern.inside;
        (lane as u32 % SIDE) < columns && lane as u32 / SIDE < rows
    }

    /// Select some of the rays of a tile; padding repeats the first.
    #[inline(always)]
    pub(crate) fn pick(&mut self, tile: &Rays, lanes: &[u8]) {
        self.count = lanes.len().min(LANES);
        (self.projection, self.half_size) = (tile.projection, tile.half_size);
        (self.origin, self.middle) = (tile.origin, tile.middle);
        for i in 0..self.padded() {
            let lane = usize::from(lanes[if i < self.count { i } else { 0 }]);
            self.dx[i] = tile.dx[lane];
            self.dy[i] = tile.dy[lane];
        }
        self.complete();
    }

    /// Compute x, y and v . v from the middle ray, dx and dy.
    #[inline(always)]
    fn complete(&mut self) {
        if self.are_parallel() {
            (self.x, self.y, self.vv) = ([0.0; LANES], [0.0; LANES], [1.0; LANES]);
            return;
        }
        let [x, y, _] = to_f32(self.middle);
        for i in 0..self.padded() {
            self.x[i] = x + self.dx[i];
            self.y[i] = y + self.dy[i];
            self.vv[i] = 1.0 + self.x[i] * self.x[i] + self.y[i] * self.y[i];
        }
    }

    /// The count rounded up to a multiple of `STEP`.
    #[inline(always)]
    pub(crate) fn padded(&self) -> usize {
        self.count.next_multiple_of(STEP).min(LANES)
    }
}
