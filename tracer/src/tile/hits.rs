//! The first hits of a tile's rays.

use crate::tile::rays::Rays;
use crate::tile::{LANES, Lanes};

/// The first hit of each ray of a tile.
#[derive(Clone, Debug)]
pub(crate) struct HitBuffer {
    /// The parameter t, which is the depth; +inf where the ray misses.
    pub(crate) t: Lanes,
    /// The face of the object; `NO_FACE` where the ray misses.
    pub(crate) face: [u32; LANES],
    /// How often two faces were so close to each other that float32 may have taken the wrong one.
    pub(crate) close: u32,
}

/// The face of a ray that misses everything.
pub(crate) const NO_FACE: u32 = u32::MAX;

/// Two faces whose depths differ by less than this share are compared in float64. Where a ray does not graze them,
/// rounding is a fifth of it.
pub(crate) const CLOSE: f32 = 3e-6;

/// A face has its object's number in its upper bits, and 3 bits for the face of a box.
pub(crate) const FACE_BITS: u32 = 3;

impl HitBuffer {
    pub(crate) fn new() -> HitBuffer {
        HitBuffer {
            t: [f32::INFINITY; LANES],
            face: [NO_FACE; LANES],
            close: 0,
        }
    }

    /// Nothing is met yet. Outside of the picture nothing will be: nothing is nearer than 0.
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

    /// The largest depth of the tile: what lies farther cannot be seen.
    #[inline(always)]
    pub(crate) fn farthest(&self) -> f32 {
        // Positive floats order as their bits do, and integers are reduced in vectors.
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

    /// The first lane that meets a face at a depth.
    pub(crate) fn lane(&self, face: u32, t: f32) -> usize {
        let found = (0..LANES).find(|&lane| self.face[lane] == face && self.t[lane] == t);
        found.unwrap_or(0)
    }
}

/// Keep a face where it is nearer than what was found so far, its depth and face; return 1 if the two are close,
/// else 0. NaN and infinity count as a miss.
#[inline(always)]
pub(crate) fn offer((best, known): (&mut f32, &mut u32), t: f32, face: u32) -> u32 {
    let close = (t - *best).abs() < CLOSE * t;
    let nearer = (t > 0.0) & (t < *best);
    *best = if nearer { t } else { *best };
    *known = if nearer { face } else { *known };
    u32::from(close)
}
