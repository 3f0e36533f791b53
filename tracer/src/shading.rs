//! The light that points reflect to the eye, and the shadows of other objects on them.

use crate::accel::cone::Cone;
use crate::accel::node::{Node, WIDTH};
use crate::accel::pyramid::{Footprint, Pyramid};
use crate::accel::{ObjectList, Stack, Volume};
use crate::apex::Apex;
use crate::bounds::BoundingSphere;
use crate::camera::Projection;
use crate::scene::{Light, Scene};
use crate::shapes::contact::Contact;
use crate::shapes::points::{Points, ShadowRays};
use crate::shapes::primitive::Primitive;
use crate::tile::hits::FACE_BITS;
use crate::tile::{LANES, Lanes};
use crate::vector::{Vector, l1_norm, scale, sub, to_f32};
use crate::world::Settings;
use std::f64::consts::PI;

mod far;
mod soft;

/// Bound on the rounding error of a light's height above a face's plane, relative to distances.
const HEIGHT_ROUNDING: f64 = 4e-15;

/// Points on a face and the light that reaches them.
#[derive(Debug)]
pub(crate) struct Lighting {
    pub(crate) points: Points,
    /// The squared length of the vector to a light.
    squared: Lanes,
    /// cos(theta) / r^2 of one light, and 0 where it is hidden.
    irradiance: Lanes,
    soft: SoftLight,
    pub(crate) stack: Stack,
}

/// What the places of one emitter sum up to at the points of a face, and what may hide them.
#[derive(Debug)]
pub(crate) struct SoftLight {
    /// The height of the emitter's middle above the tangent plane; of a sun, the cosine.
    heights: Lanes,
    /// cos(theta) / r^2 of the middle, as if the emitter were a point; of a sun, cos(theta).
    middle: Lanes,
    /// The sums over all places, and over those that are not hidden.
    unhidden: Lanes,
    reached: Lanes,
    /// The objects that may hide a place.
    occluders: ObjectList,
    /// Whether far objects may, too.
    far: bool,
}

impl SoftLight {
    pub(crate) fn new() -> SoftLight {
        let zero = [0.0; LANES];
        SoftLight {
            heights: zero,
            middle: zero,
            unhidden: zero,
            reached: zero,
            occluders: ObjectList::default(),
            far: false,
        }
    }
}

impl Lighting {
    pub(crate) fn new() -> Lighting {
        Lighting {
            points: Points::new(),
            squared: [0.0; LANES],
            irradiance: [0.0; LANES],
            soft: SoftLight::new(),
            stack: Stack::default(),
        }
    }

    /// Add the light that the points reflect to the eye, and return the number of shadow rays.
    ///
    /// radiance = albedo ambient + sum over lights of albedo / pi L_i cos(theta), L_i = power / r^2, or power of a sun
    /// (document, sections 2.3.1, 2.3.2)
    ///
    /// Only lights on the eye's side illuminate a surface. All shapes are convex, so an object cannot shadow
    /// itself where eye and light are on the same side and cos(theta) > 0: it is skipped, and no epsilon is
    /// needed.
    #[inline(always)]
    pub(crate) fn accumulate_direct(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        face: u32,
        radiance: &mut [Lanes; 3],
    ) -> u64 {
        let object = face >> FACE_BITS;
        let (albedo, range_scale) = (scene.albedos[object as usize], scene.range_scale(object));
        // The second is that of the odd squares of a checker.
        let albedos = [albedo, scene.checker(object).map_or(albedo, |checker| checker.albedo)];
        // The distance to the eye of an object that was moved toward it is the real one.
        let falloff = settings.eye_falloff.then_some((scene.projection, scene.unit * range_scale));
        if settings.ambient != [0.0; 3] {
            self.irradiance = [1.0; LANES];
            let reflected = |albedo: Vector| std::array::from_fn(|i| settings.ambient[i] * albedo[i]);
            self.add_reflected(albedos.map(reflected), falloff, radiance);
        }
        let bounds = self.points.bounds();
        let footprint = self.points.plane.filter(|_| scene.bvh.is_deep());
        let footprint = footprint.map(|plane| Footprint::new(plane, &self.points));
        let mut rays = 0;
        for light in &scene.lights {
            let traced = match &light.emitter {
                Some(emitter) => {
                    self.irradiate_softly(scene, (light, emitter), face, (bounds, footprint.as_ref()))
                }
                None => self.irradiate_sharply(scene, light, face, (bounds, footprint.as_ref())),
            };
            if traced == 0 {
                continue;
            }
            rays += traced;
            // An object that was moved toward the eye gets no more light than at its real distance.
            let dimmed = (range_scale / light.range_scale).min(1.0);
            // albedo / pi times the light's power
            let weights = albedos.map(|albedo| {
                let albedo = scale(albedo, dimmed * dimmed);
                std::array::from_fn(|i| light.power[i] * (albedo[i] / PI))
            });
            self.add_reflected(weights, falloff, radiance);
        }
        rays
    }

    /// Add the irradiance, times a weight for each channel, the second on the odd squares of a checker; with the
    /// world's length of a unit, it falls off toward the eye.
    #[inline(always)]
    fn add_reflected(
        &mut self,
        mut weights: [Vector; 2],
        falloff: Option<(Projection, f64)>,
        radiance: &mut [Lanes; 3],
    ) {
        if let Some((projection, unit)) = falloff {
            let magnitude = magnitude(std::array::from_fn(|i| weights[0][i].max(weights[1][i])));
            weights = weights.map(|weight| scale(weight, 1.0 / f64::from(magnitude)));
            self.apply_eye_falloff(projection, unit, magnitude);
        }
        let [even, odd] = weights.map(|weight| weight.map(bounded));
        for (channel, (even, odd)) in radiance.iter_mut().zip(even.into_iter().zip(odd)) {
            if self.points.checkered {
                for lane in 0..self.points.padded() {
                    let weight = if self.points.odd[lane] == 0 { even } else { odd };
                    channel[lane] += weight * self.irradiance[lane];
                }
            } else {
                for lane in 0..self.points.padded() {
                    channel[lane] += even * self.irradiance[lane];
                }
            }
        }
    }

    /// Compute the irradiance of a light without a size at the points, and return the number of shadow rays.
    #[inline(always)]
    fn irradiate_sharply(
        &mut self,
        scene: &Scene,
        light: &Light,
        face: u32,
        (bounds, footprint): (BoundingSphere, Option<&Footprint>),
    ) -> u64 {
        let object = face >> FACE_BITS;
        let contact = light.contact(0, object);
        if !scene.shapes.get(object).is_lit_from(face, contact, light.apex) {
            return 0;
        }
        let facing = self.irradiate((light.apex, contact), scene, face);
        if facing > 0 {
            if !scene.far.before(light.was_moved()).is_empty() {
                let points = (&self.points, bounds);
                far::darken(scene, (light, light.apex), object, points, &mut self.irradiance, &mut self.stack);
            }
            let mut shadow = ShadowRays {
                points: &self.points,
                light: light.apex,
                squared: &self.squared,
                irradiance: &mut self.irradiance,
                bounds,
            };
            darken_occluded(&mut shadow, light, scene, (object, footprint), &mut self.stack);
        }
        facing
    }

    /// Compute the unoccluded irradiance of an apex at the points, and return the number of points that face it.
    /// `contact` is given if it is close to the surface.
    #[inline(always)]
    fn irradiate(&mut self, (apex, contact): (Apex, Option<&Contact>), scene: &Scene, face: u32) -> u64 {
        let shape = scene.shapes.get(face >> FACE_BITS);
        let to_light = apex.way_from_f32(self.points.reference);
        if let Some(plane) = self.points.plane {
            let (height, rounding) = match contact {
                Some(contact) => (shape.height(face, contact), 0.0),
                None => (
                    plane.height_of_apex(apex),
                    HEIGHT_ROUNDING * (l1_norm(apex.at) + apex.weight * plane.offset.abs()),
                ),
            };
            // A light in the plane of a face, within rounding, does not illuminate it.
            if height <= rounding {
                return 0;
            }
            if apex.is_direction() {
                self.irradiate_flat::<true>(to_light, height as f32);
            } else {
                self.irradiate_flat::<false>(to_light, height as f32);
            }
            return self.points.count as u64;
        }
        if apex.is_direction() {
            self.irradiate_curved::<true>(to_light);
        } else {
            self.irradiate_curved::<false>(to_light);
        }
        let facing = |&irradiance: &f32| u32::from(irradiance > 0.0);
        u64::from(self.irradiance[..self.points.count].iter().map(facing).sum::<u32>())
    }

    /// cos(theta) / r^2 = height / r^3: the height of the light is the same at all points of a flat face. Infinitely
    /// far away the height is cos(theta), and the vector to the light a unit vector.
    #[inline(always)]
    fn irradiate_flat<const PARALLEL: bool>(&mut self, to_light: [f32; 3], height: f32) {
        for lane in 0..self.points.padded() {
            let w = self.points.toward::<PARALLEL>(to_light, lane);
            let squared = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
            self.squared[lane] = squared;
            self.irradiance[lane] = per_cube(height, squared);
        }
    }

    /// cos(theta) / r^2 = n . w / r^3
    #[inline(always)]
    fn irradiate_curved<const PARALLEL: bool>(&mut self, to_light: [f32; 3]) {
        for lane in 0..self.points.padded() {
            let w = self.points.toward::<PARALLEL>(to_light, lane);
            let squared = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
            let n = &self.points.normal;
            let along = n[0][lane] * w[0] + n[1][lane] * w[1] + n[2][lane] * w[2];
            self.squared[lane] = squared;
            // Also 0 if NaN, for a light on the surface.
            let irradiance = per_cube(along, squared);
            self.irradiance[lane] = if irradiance > 0.0 { irradiance } else { 0.0 };
        }
    }

    /// Divide by 4 pi t^2 (document, section 3.4), t the distance to the eye in the world's units, along parallel rays
    /// the depth; multiply by `magnitude`.
    #[inline(always)]
    fn apply_eye_falloff(&mut self, projection: Projection, unit: f64, magnitude: f32) {
        let eye = to_f32(self.points.reference.map(|component| -component));
        let (unit, per_sphere) = (bounded(unit), (0.25 / PI) as f32);
        for lane in 0..self.points.padded() {
            let p = self.points.toward::<false>(eye, lane);
            let distance = match projection {
                Projection::Perspective => (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt(),
                Projection::Orthographic => p[2].abs(),
            };
            let factor = unit / distance;
            self.irradiance[lane] = self.irradiance[lane] * magnitude * factor * factor * per_sphere;
        }
    }
}

/// value / r^3, from r^2. The cube itself would overflow float32 for a light at the sun's distance from a scene of
/// millimetres.
#[inline(always)]
fn per_cube(value: f32, squared: f32) -> f32 {
    let inverse = 1.0 / squared;
    value * inverse * inverse.sqrt()
}

/// Return a power of two near the largest weight if that is far from 1: factoring it out keeps intermediate
/// radiance within float32.
fn magnitude(weight: Vector) -> f32 {
    let largest = weight.into_iter().fold(0.0, f64::max);
    let exponent = libm::ilogb(largest);
    if largest > 0.0 && !(-40..=40).contains(&exponent) {
        libm::scalbnf(1.0, exponent.clamp(-120, 120))
    } else {
        1.0
    }
}

/// Round to float32, clamping to its largest value.
fn bounded(value: f64) -> f32 {
    value.min(f64::from(f32::MAX)) as f32
}

/// Darken the points from which another object hides the light.
///
/// The object that the points lie on, `receiver`, and the one that carries the light cast no shadow: see
/// `Lighting::accumulate_direct`. A flat face's points are given their footprint.
#[inline(always)]
pub(crate) fn darken_occluded(
    shadow: &mut ShadowRays<'_>,
    light: &Light,
    scene: &Scene,
    (receiver, footprint): (u32, Option<&Footprint>),
    stack: &mut Stack,
) {
    for &i in &scene.unbounded {
        if i != receiver {
            scene.shapes.get_unbounded(i).occlude(light.contact(0, i), shadow);
        }
    }
    if shadow.is_dark() {
        return;
    }
    let far = scene.far.before(light.was_moved());
    let volume = ShadowVolume::new((light.apex, 0.0), shadow.points, (shadow.bounds, footprint));
    let mut traversal = scene.bvh.traverse(&volume, stack);
    while let Some(i) = traversal.next(f32::INFINITY) {
        if i == receiver || scene.carries(i, light) || far.contains(i) {
            continue;
        }
        scene.shapes.get_bounded(i).occlude(light.contact(0, i), shadow);
        if shadow.is_dark() {
            return;
        }
    }
}

/// A volume around all shadow rays from points to an apex, or to an emitter.
enum ShadowVolume {
    Cone(Cone),
    Pyramid(Pyramid),
}

impl ShadowVolume {
    /// Return the volume for an apex and the size of the emitter around it. A flat face's points are given their
    /// footprint.
    #[inline(always)]
    fn new(
        (apex, size): (Apex, f64),
        points: &Points,
        (bounds, footprint): (BoundingSphere, Option<&Footprint>),
    ) -> ShadowVolume {
        match footprint {
            Some(footprint) => ShadowVolume::Pyramid(Pyramid::new(apex, size, footprint)),
            None => ShadowVolume::Cone(Cone::from_apex(apex, size, bounds, farthest(points, bounds))),
        }
    }
}

impl Volume for ShadowVolume {
    #[inline(always)]
    fn range(&self) -> f32 {
        match self {
            ShadowVolume::Cone(cone) => cone.range(),
            ShadowVolume::Pyramid(pyramid) => pyramid.range(),
        }
    }

    #[inline(always)]
    fn intersect(&self, node: &Node, limit: f32) -> ([f32; WIDTH], u64) {
        match self {
            ShadowVolume::Cone(cone) => cone.intersect(node, limit),
            ShadowVolume::Pyramid(pyramid) => pyramid.intersect(node, limit),
        }
    }
}

/// Return a bound on the distance of points from their reference.
#[inline(always)]
fn farthest(points: &Points, bounds: BoundingSphere) -> f64 {
    l1_norm(sub(bounds.center, points.reference)) + bounds.radius
}
