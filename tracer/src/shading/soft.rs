//! Soft shadows: the light of an emitter, summed over its places.
//!
//! Each place is the apex of a pencil of its own, but one traversal of the tree finds what may hide any of them from
//! any point of the face. Where that is nothing, and the whole emitter is above the face, no place is visited.

use crate::accel::cone::Cone;
use crate::accel::pyramid::Footprint;
use crate::accel::{Volume, next_child};
use crate::bounds::BoundingSphere;
use crate::scene::emitter::Emitter;
use crate::scene::{Light, Scene};
use crate::shading::{Lighting, ShadowVolume, SoftLight, far, farthest, per_cube};
use crate::shapes::points::{ShadowRays, extremes};
use crate::shapes::primitive::Primitive;
use crate::tile::LANES;
use crate::tile::hits::FACE_BITS;
use crate::vector::{length, sub};

impl Lighting {
    /// Compute the irradiance of an emitter at the points, and return the number of shadow rays.
    ///
    /// With g = cos(theta) / r^2 of a place, or 0 where it is below the tangent plane, and v = 1 or 0 where it is
    /// hidden, it is
    ///
    /// g_middle sum(g v) / sum(g)   where all of the emitter is above the tangent plane
    /// sum(g v) / n                 elsewhere
    ///
    /// In the first case the sum over an unhidden emitter, g_middle, is known exactly.
    #[inline(always)]
    pub(crate) fn irradiate_softly(
        &mut self,
        scene: &Scene,
        (light, emitter): (&Light, &Emitter),
        face: u32,
        (bounds, footprint): (BoundingSphere, Option<&Footprint>),
    ) -> u64 {
        let object = face >> FACE_BITS;
        let receiver = scene.shapes.get(object);
        let cut = emitter.cut.contains(&object);
        if !cut && !receiver.is_lit_from(face, None, light.apex) {
            return 0;
        }
        let [lowest, highest] = if light.apex.is_direction() {
            self.irradiate_from_middle::<true>(light)
        } else {
            self.irradiate_from_middle::<false>(light)
        };
        let size = emitter.size as f32;
        if highest <= -size {
            return 0;
        }
        let above = lowest >= size;
        self.find_occluders(scene, (light, emitter), object, (bounds, footprint.filter(|_| above)));
        if above && !cut && !self.soft.far && self.soft.occluders.is_empty() {
            self.irradiance = self.soft.middle;
            return (self.points.count * emitter.places.len()) as u64;
        }
        let rays = self.sum_places(scene, (light, emitter), face, bounds);
        for lane in 0..self.points.padded() {
            let SoftLight { heights, middle, unhidden, reached, .. } = &self.soft;
            let share = if heights[lane] >= size { middle[lane] / unhidden[lane] } else { emitter.share };
            // As where no occluder is near any of the points: a crop must not decide a bit.
            let all = (heights[lane] >= size) & (reached[lane] == unhidden[lane]);
            let irradiance = if all { middle[lane] } else { share * reached[lane] };
            self.irradiance[lane] = if irradiance > 0.0 { irradiance } else { 0.0 };
        }
        rays
    }

    /// Compute the heights and the irradiance of the middle; return the smallest and the largest height.
    #[inline(always)]
    fn irradiate_from_middle<const PARALLEL: bool>(&mut self, light: &Light) -> [f32; 2] {
        let to_light = light.apex.way_from_f32(self.points.reference);
        let height = self.points.plane.map(|plane| plane.height_of_apex(light.apex) as f32);
        let soft = &mut self.soft;
        for lane in 0..self.points.padded() {
            let w = self.points.toward::<PARALLEL>(to_light, lane);
            let squared = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
            let n = &self.points.normal;
            let along = match height {
                Some(height) => height,
                None => n[0][lane] * w[0] + n[1][lane] * w[1] + n[2][lane] * w[2],
            };
            soft.heights[lane] = along;
            soft.middle[lane] = per_cube(along, squared);
        }
        extremes(&soft.heights[..self.points.padded()])
    }

    /// Sum up the irradiance of the places, and return the number of shadow rays.
    #[inline(always)]
    fn sum_places(
        &mut self,
        scene: &Scene,
        (light, emitter): (&Light, &Emitter),
        face: u32,
        bounds: BoundingSphere,
    ) -> u64 {
        let object = face >> FACE_BITS;
        let receiver = scene.shapes.get(object);
        self.soft.unhidden = [0.0; LANES];
        self.soft.reached = [0.0; LANES];
        let mut rays = 0;
        for (number, &apex) in (0..).zip(&emitter.places) {
            let contact = light.contact(number, object);
            let facing = self.irradiate((apex, contact), scene, face);
            if facing == 0 {
                continue;
            }
            let padded = self.points.padded();
            if !apex.is_direction() && length(sub(apex.at, bounds.center)) < bounds.radius + emitter.nearest {
                self.keep_away((emitter.nearest * emitter.nearest) as f32);
            }
            add(&mut self.soft.unhidden[..padded], &self.irradiance[..padded]);
            if !receiver.is_lit_from(face, contact, apex) {
                continue;
            }
            rays += facing;
            if self.soft.far {
                far::darken(
                    scene,
                    (light, apex),
                    object,
                    (&self.points, bounds),
                    &mut self.irradiance,
                    &mut self.stack,
                );
            }
            let mut shadow = ShadowRays {
                points: &self.points,
                light: apex,
                squared: &self.squared,
                irradiance: &mut self.irradiance,
                bounds,
            };
            let cone = Cone::from_apex(apex, 0.0, bounds, farthest(&self.points, bounds));
            'occluders: for node in self.soft.occluders.nodes() {
                let (_, mut met) = cone.intersect(node, cone.range());
                while let Some(i) = next_child(&mut met) {
                    if !self.stack.work.take(self.stack.steps_per_object) {
                        return rays;
                    }
                    let object = node.child[i];
                    scene.shapes.get(object).occlude(light.contact(number, object), &mut shadow);
                    if shadow.is_dark() {
                        break 'occluders;
                    }
                }
            }
            add(&mut self.soft.reached[..padded], &self.irradiance[..padded]);
        }
        rays
    }

    /// Reduce the irradiance of a place to that at a squared distance, at the points that are nearer: cos(theta) / r^2
    /// becomes cos(theta) r / nearest^3.
    #[inline(always)]
    fn keep_away(&mut self, nearest: f32) {
        for lane in 0..self.points.padded() {
            let share = self.squared[lane] / nearest;
            let kept = if share > 0.0 { share * share.sqrt() * self.irradiance[lane] } else { 0.0 };
            self.irradiance[lane] = if share < 1.0 { kept } else { self.irradiance[lane] };
        }
    }

    /// Find the objects that may hide any place from any point. A flat face's points are given their footprint if all
    /// of the emitter is above it.
    #[inline(always)]
    fn find_occluders(
        &mut self,
        scene: &Scene,
        (light, emitter): (&Light, &Emitter),
        receiver: u32,
        (bounds, footprint): (BoundingSphere, Option<&Footprint>),
    ) {
        self.soft.occluders.clear();
        let size = emitter.size;
        for &i in &scene.unbounded {
            if i != receiver && scene.shapes.get_unbounded(i).may_hide((light.apex, size), bounds) {
                self.soft.occluders.push(i, None);
            }
        }
        let far = scene.far.before(light.was_moved());
        let stack = &mut self.stack;
        self.soft.far =
            !far.is_empty() && far::any_may_hide(scene, (light, size), receiver, bounds, &mut stack.work);
        let volume = ShadowVolume::new((light.apex, size), &self.points, (bounds, footprint));
        let mut traversal = scene.bvh.traverse(&volume, &mut self.stack);
        while let Some(i) = traversal.next(f32::INFINITY) {
            if i != receiver && !scene.carries(i, light) && !far.contains(i) {
                self.soft.occluders.push(i, scene.shapes.get_bounded(i).bounds());
            }
        }
    }
}

#[inline(always)]
fn add(sum: &mut [f32], values: &[f32]) {
    for (sum, value) in sum.iter_mut().zip(values) {
        *sum += value;
    }
}
