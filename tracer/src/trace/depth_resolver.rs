//! The nearest of several faces whose depths float32 cannot distinguish.
//!
//! For a distant eye the depths of surfaces may differ by less than float32 resolves, and two boxes may share a
//! face. Depths that close are computed again in float64, ray by ray; the first object's face wins among
//! coincident ones.

use crate::accel::Stack;
use crate::accel::cone::Cone;
use crate::scene::Scene;
use crate::shapes::contact::ON_SURFACE;
use crate::shapes::primitive::Primitive;
use crate::tile::LANES;
use crate::tile::hits::{FACE_BITS, HitBuffer};
use crate::tile::rays::{CLOSE, MOST_AT_A_SLANT, Rays, at_a_slant};
use crate::vector::l1_norm;
use std::iter;

/// Faces whose depths differ by less than this share are coincident.
const COINCIDENT: f64 = 1.0 / (1_u64 << 41) as f64;

/// Where two surfaces cross within this share of a pixel, float32 decides which is visible.
const CROSSING: f64 = 2e-5;

/// A face that may be the nearest one of a lane.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    lane: u8,
    /// The number of its object in the world.
    number: u32,
    face: u32,
    /// The depth in float32.
    t: f32,
    depth: f64,
    /// The rounding of the depth.
    slack: f64,
}

/// Working memory.
#[derive(Debug)]
pub(crate) struct DepthResolver {
    /// The hits of one object alone.
    alone: HitBuffer,
    candidates: Vec<Candidate>,
}

impl DepthResolver {
    pub(crate) fn new() -> DepthResolver {
        DepthResolver { alone: HitBuffer::new(), candidates: Vec::new() }
    }

    /// Correct the faces of the hits.
    #[inline(never)]
    pub(crate) fn resolve(&mut self, scene: &Scene, rays: &Rays, hits: &mut HitBuffer, stack: &mut Stack) {
        self.candidates.clear();
        let cone = Cone::of_tile(rays);
        let rounding = rays.limits().1;
        let limit = cone.along_axis(rays, hits.farthest() * (1.0 + CLOSE) + rounding);
        let mut traversal = scene.bvh.traverse(&cone, stack);
        let bounded = iter::from_fn(|| traversal.next(limit));
        for object in bounded.chain(scene.unbounded.iter().copied()) {
            self.take(scene, rays, hits, object);
        }
        self.candidates.sort_unstable_by_key(|candidate| (candidate.lane, candidate.number));
        // A single close ray is usually where two surfaces cross.
        let tolerance = if hits.close == 1 { CROSSING * rays.pixel() } else { 0.0 };
        for candidates in self.candidates.chunk_by(|a, b| a.lane == b.lane) {
            if let Some(seen) = first_of_the_nearest(candidates, |depth| tolerance * rays.divergence(depth)) {
                let lane = usize::from(seen.lane);
                // The float32 depth of this object alone.
                (hits.face[lane], hits.t[lane]) = (seen.face, seen.t);
            }
        }
    }

    /// Add an object as a candidate wherever it is close to the nearest hit.
    fn take(&mut self, scene: &Scene, rays: &Rays, hits: &HitBuffer, object: u32) {
        let shape = scene.shapes.get(object);
        let alone = &mut self.alone;
        alone.clear(rays);
        shape.intersect(object << FACE_BITS, rays, alone);
        let rounding = rays.limits().1;
        let sideways = l1_norm(rays.origin);
        for lane in 0..LANES {
            let (t, best) = (alone.t[lane], hits.t[lane]);
            let is_close = |rounding: f32| (t - best).abs() <= 2.0 * (CLOSE * best + rounding) && t > 0.0;
            if !is_close(rounding * MOST_AT_A_SLANT) {
                continue;
            }
            let (depth, along) = shape.depth(rays.exact(lane));
            if is_close(if depth.is_finite() { at_a_slant(rounding, along) } else { rounding }) {
                self.candidates.push(Candidate {
                    lane: lane as u8,
                    number: scene.numbers[object as usize],
                    face: alone.face[lane],
                    t,
                    depth,
                    slack: (ON_SURFACE * (shape.magnitude_across(alone.face[lane]) + sideways)
                        + scene.coordinate_rounding)
                        / along,
                });
            }
        }
    }
}

/// Return the visible one of several candidates: the first object's among coincident ones. If none coincide and
/// all depths differ by less than the tolerance at the nearest one, their order in float32 decides.
fn first_of_the_nearest(candidates: &[Candidate], tolerance: impl Fn(f64) -> f64) -> Option<Candidate> {
    let all = candidates.iter().copied();
    let nearest = all.clone().min_by(|a, b| a.depth.total_cmp(&b.depth))?;
    if candidates.len() == 1 || !nearest.depth.is_finite() {
        return None;
    }
    let before = nearest.depth * (1.0 + COINCIDENT) + nearest.slack;
    let mut in_one_place = all.clone().filter(|candidate| candidate.depth - candidate.slack <= before);
    let first = in_one_place.next()?;
    let tolerance = tolerance(nearest.depth);
    let crossing = all.clone().all(|candidate| candidate.depth - nearest.depth < tolerance);
    if crossing && in_one_place.next().is_none() {
        return all.min_by(|a, b| a.t.total_cmp(&b.t));
    }
    Some(first)
}

#[cfg(test)]
mod tests;
