//! The visible one of several faces whose depths float32 cannot distinguish.
//!
//! An eye far away sees surfaces whose depths differ by less than float32 holds, and two boxes may share a face.
//! Where depths are that close they are found again in float64, ray by ray; of faces in one place the first
//! object's is seen.

use crate::accel::Stack;
use crate::accel::cone::Cone;
use crate::scene::Scene;
use crate::shapes::contact::ON_SURFACE;
use crate::shapes::primitive::Primitive;
use crate::tile::LANES;
use crate::tile::hits::{CLOSE, FACE_BITS, HitBuffer};
use crate::tile::rays::Rays;

/// Faces that a ray meets within this share of the depth from each other are in one place.
const COINCIDENT: f64 = 1.0 / (1_u64 << 41) as f64;

/// Where two surfaces cross within this share of a pixel, float32 decides which of them is seen.
const CROSSING: f64 = 2e-5;

/// A face that may be the nearest one of a lane.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    lane: u8,
    face: u32,
    /// The depth in float32.
    t: f32,
    depth: f64,
    /// What rounding may have done to the depth.
    slack: f64,
}

/// The room to work in.
#[derive(Debug)]
pub(crate) struct DepthResolver {
    /// What one object alone would show.
    alone: HitBuffer,
    candidates: Vec<Candidate>,
}

impl DepthResolver {
    pub(crate) fn new() -> DepthResolver {
        DepthResolver {
            alone: HitBuffer::new(),
            candidates: Vec::new(),
        }
    }

    /// Put right which faces are the hits.
    #[inline(never)]
    pub(crate) fn resolve(&mut self, scene: &Scene, rays: &Rays, hits: &mut HitBuffer, stack: &mut Stack) {
        self.candidates.clear();
        let cone = Cone::of_tile(rays);
        let limit = cone.along_axis(rays, hits.farthest() * (1.0 + CLOSE));
        let mut traversal = scene.bvh.traverse(&cone, stack);
        while let Some(object) = traversal.next(limit) {
            self.take(scene, rays, hits, object);
        }
        for &object in &scene.unbounded {
            self.take(scene, rays, hits, object);
        }
        self.candidates
            .sort_unstable_by_key(|candidate| (candidate.lane, candidate.face));
        // A single close ray is most often where two surfaces cross.
        let blur = if hits.close == 1 { CROSSING * rays.pixel() } else { 0.0 };
        for candidates in self.candidates.chunk_by(|a, b| a.lane == b.lane) {
            if let Some(seen) = first_of_the_nearest(candidates, blur) {
                let lane = usize::from(seen.lane);
                // Its own depth, which no other object has a part in.
                (hits.face[lane], hits.t[lane]) = (seen.face, seen.t);
            }
        }
    }

    /// Take an object for a candidate wherever it is as near as what was found.
    fn take(&mut self, scene: &Scene, rays: &Rays, hits: &HitBuffer, object: u32) {
        let shape = &scene.shapes[object as usize];
        let alone = &mut self.alone;
        alone.clear(rays);
        shape.intersect(object << FACE_BITS, rays, alone);
        for lane in 0..LANES {
            let (t, best) = (alone.t[lane], hits.t[lane]);
            if (t - best).abs() <= 2.0 * CLOSE * best && t > 0.0 {
                let (depth, along) = shape.depth(rays.exact(lane));
                self.candidates.push(Candidate {
                    lane: lane as u8,
                    face: alone.face[lane],
                    t,
                    depth,
                    slack: (ON_SURFACE * shape.magnitude_across(alone.face[lane]) + scene.coordinate_rounding)
                        / along,
                });
            }
        }
    }
}

/// The first object's among the nearest candidates, if there are several.
///
/// Among candidates in one place, the first object's is visible. Elsewhere, if all are within the share `blur` of
/// the depth from each other, their order in float32 is as good as any.
fn first_of_the_nearest(candidates: &[Candidate], blur: f64) -> Option<Candidate> {
    let all = candidates.iter().copied();
    let nearest = all.clone().min_by(|a, b| a.depth.total_cmp(&b.depth))?;
    if candidates.len() == 1 || !nearest.depth.is_finite() {
        return None;
    }
    let before = nearest.depth * (1.0 + COINCIDENT) + nearest.slack;
    let mut in_one_place = all
        .clone()
        .filter(|candidate| candidate.depth - candidate.slack <= before);
    let first = in_one_place.next()?;
    let crossing = all
        .clone()
        .all(|candidate| candidate.depth - nearest.depth < blur * nearest.depth);
    if crossing && in_one_place.next().is_none() {
        return all.min_by(|a, b| a.t.total_cmp(&b.t));
    }
    Some(first)
}

#[cfg(test)]
mod tests;
