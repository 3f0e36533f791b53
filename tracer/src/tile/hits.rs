//! The nearest hits of the rays of a tile.

use crate::tile::rays::{CLOSE, Rays};
use crate::tile::{LANES, Lanes};

/// The nearest hit of each ray of a tile.
#[derive(Clone, Debug)]
pub(crate) struct HitBuffer {
    /// The parameter t, which is the depth; +inf where the ray misses.
    pub(crate) t: Lanes,
    /// The face of the object; `NO_FACE` where the ray misses.
    pub(crate) face: [u32; LANES],
    /// The number of times that two faces were too close for float32 to order them.
    pub(crate) close: u32,
}

/// The face of a ray that misses everything.
pub(crate) const NO_FACE: u32 = u32::MAX;

/// A face number holds the object's number in its upper bits, the side of a box in the middle ones, and `INSIDE` in the
/// lowest one.
pub(crate) const FACE_BITS: u32 = 4;

/// The bit of a face number for a face that is seen from inside the shape, or against the normal of a plane.
pub(crate) const INSIDE: u32 = 1;

/// Whether a face is seen from inside.
#[inline(always)]
pub(crate) fn from_inside(face: u32) -> bool {
    face & INSIDE != 0
}

impl HitBuffer {
    pub(crate) fn new() -> HitBuffer {
        HitBuffer { t: [f32::INFINITY; LANES], face: [NO_FACE; LANES], close: 0 }
    }

    /// Reset to misses. Rays outside the picture get depth 0, so that they cannot hit anything.
    #[inline(always)]
    pub(crate) fn clear(&mut self, rays: &Rays) {
        self.t = [f32::INFINITY; LANES];
        self.face = [NO_FACE; LANES];
        self.close = 0;
        if !rays.is_inside(LANES - 1) {
            for lane in 0..LANES {
                if !rays.is_inside(lane) {
                    self.t[lane] = 0.0;
                }
            }
        }
    }

    /// The largest depth of the tile: everything farther is hidden.
    #[inline(always)]
    pub(crate) fn farthest(&self) -> f32 {
        // Positive floats have the order of their bits, and the reduction of integers vectorizes.
        let mut farthest = 0;
        for t in &self.t {
            farthest = farthest.max(t.to_bits());
        }
        f32::from_bits(farthest)
    }

    /// The smallest depth of the tile.
    #[inline(always)]
    pub(crate) fn closest(&self) -> f32 {
        let mut closest = u32::MAX;
        for t in &self.t {
            closest = closest.min(t.to_bits());
        }
        f32::from_bits(closest)
    }

    /// The first lane that hits a face at a depth.
    pub(crate) fn lane(&self, face: u32, t: f32) -> usize {
        let found = (0..LANES).find(|&lane| self.face[lane] == face && self.t[lane] == t);
        found.unwrap_or(0)
    }
}

/// Keep a face if it is nearer than the best hit so far; return 1 if the two are close, else 0. NaN and infinity
/// are misses.
#[inline(always)]
pub(crate) fn offer((best, best_face): (&mut f32, &mut u32), t: f32, face: u32) -> u32 {
    let close = (t - *best).abs() < CLOSE * t;
    let nearer = (t > 0.0) & (t < *best);
    *best = if nearer { t } else { *best };
    *best_face = if nearer { face } else { *best_face };
    u32::from(close)
}

/// The same for parallel rays that start at a depth, the depths of which have a rounding that does not shrink with
/// them.
#[inline(always)]
pub(crate) fn offer_parallel(
    (best, best_face): (&mut f32, &mut u32),
    (start, rounding): (f32, f32),
    t: f32,
    face: u32,
) -> u32 {
    let ahead = t > start;
    let close = ahead & ((t - *best).abs() < CLOSE * t + rounding);
    let nearer = ahead & (t < *best);
    *best = if nearer { t } else { *best };
    *best_face = if nearer { face } else { *best_face };
    u32::from(close)
}
