//! The light that points reflect to the eye, and the shadows of other objects on them.

use crate::accel::cone::Cone;
use crate::accel::pyramid::{Footprint, Pyramid};
use crate::accel::{Stack, Volume};
use crate::scene::{Light, Material, Scene};
use crate::shapes::points::{Points, ShadowRays};
use crate::shapes::primitive::Primitive;
use crate::tile::hits::FACE_BITS;
use crate::tile::{LANES, Lanes};
use crate::vector::{Vector, l1_norm, scale, sub, to_f32};
use crate::world::Settings;
use std::f64::consts::PI;

/// Bound on the rounding error of a light's height above a face's plane, relative to distances.
const HEIGHT_ROUNDING: f64 = 4e-15;

/// Points on a face and the light that reaches them.
#[derive(Debug)]
pub(crate) struct Lighting {
    pub(crate) points: Points,
    /// The squared distance to a light.
    squared: Lanes,
    /// cos(theta) / r^2 of one light, and 0 where it is hidden.
    irradiance: Lanes,
    pub(crate) stack: Stack,
}

impl Lighting {
    pub(crate) fn new() -> Lighting {
        Lighting {
            points: Points::new(),
            squared: [0.0; LANES],
            irradiance: [0.0; LANES],
            stack: Stack::default(),
        }
    }

    /// Add the light that the points reflect to the eye, and return the number of shadow rays.
    ///
    /// radiance = albedo ambient + sum over lights of albedo / pi L_i cos(theta), L_i = power / r^2 (document,
    /// sections 2.3.1, 2.3.2)
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
        let Material { albedo, range_scale, .. } = scene.materials[object as usize];
        // The second is that of the odd squares of a checker.
        let albedos = [albedo, scene.checker(object).map_or(albedo, |checker| checker.albedo)];
        // The distance to the eye of an object that was moved toward it is the real one.
        let falloff = settings.eye_falloff.then_some(scene.unit * range_scale);
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
            let facing = self.irradiate(light, scene, face);
            if facing == 0 {
                continue;
            }
            rays += facing;
            let mut shadow = ShadowRays {
                points: &self.points,
                light: light.position,
                squared: &self.squared,
                irradiance: &mut self.irradiance,
                bounds,
            };
            darken_occluded(&mut shadow, light, scene, (object, footprint.as_ref()), &mut self.stack);
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
    fn add_reflected(&mut self, mut weights: [Vector; 2], falloff: Option<f64>, radiance: &mut [Lanes; 3]) {
        if let Some(unit) = falloff {
            let magnitude = magnitude(std::array::from_fn(|i| weights[0][i].max(weights[1][i])));
            weights = weights.map(|weight| scale(weight, 1.0 / f64::from(magnitude)));
            self.apply_eye_falloff(unit, magnitude);
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

    /// Compute the unoccluded irradiance of a light at the points, and return the number of points that face it.
    #[inline(always)]
    fn irradiate(&mut self, light: &Light, scene: &Scene, face: u32) -> u64 {
        let object = face >> FACE_BITS;
        let (shape, contact) = (scene.shapes.get(object), light.contact(object));
        if !shape.is_lit_from(contact, light.position) {
            return 0;
        }
        let to_light = to_f32(sub(light.position, self.points.reference));
        if let Some(plane) = self.points.plane {
            let (height, rounding) = match contact {
                Some(contact) => (shape.height(face, contact), 0.0),
                None => (
                    plane.height(light.position),
                    HEIGHT_ROUNDING * (l1_norm(light.position) + plane.offset.abs()),
                ),
            };
            // A light in the plane of a face, within rounding, does not illuminate it.
            if height <= rounding {
                return 0;
            }
            self.irradiate_flat(to_light, height as f32);
            return self.points.count as u64;
        }
        self.irradiate_curved(to_light);
        let facing = |&irradiance: &f32| u32::from(irradiance > 0.0);
        u64::from(self.irradiance[..self.points.count].iter().map(facing).sum::<u32>())
    }

    /// cos(theta) / r^2 = height / r^3: the height of the light is the same at all points of a flat face.
    #[inline(always)]
    fn irradiate_flat(&mut self, to_light: [f32; 3], height: f32) {
        for lane in 0..self.points.padded() {
            let w = self.points.toward(to_light, lane);
            let squared = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
            self.squared[lane] = squared;
            self.irradiance[lane] = per_cube(height, squared);
        }
    }

    /// cos(theta) / r^2 = n . w / r^3
    #[inline(always)]
    fn irradiate_curved(&mut self, to_light: [f32; 3]) {
        for lane in 0..self.points.padded() {
            let w = self.points.toward(to_light, lane);
            let squared = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
            let n = &self.points.normal;
            let along = n[0][lane] * w[0] + n[1][lane] * w[1] + n[2][lane] * w[2];
            self.squared[lane] = squared;
            // Also 0 if NaN, for a light on the surface.
            let irradiance = per_cube(along, squared);
            self.irradiance[lane] = if irradiance > 0.0 { irradiance } else { 0.0 };
        }
    }

    /// Divide by 4 pi t^2 (document, section 3.4), t the distance to the eye in the world's units; multiply by
    /// `magnitude`.
    #[inline(always)]
    fn apply_eye_falloff(&mut self, unit: f64, magnitude: f32) {
        let eye = to_f32(self.points.reference.map(|component| -component));
        let (unit, per_sphere) = (bounded(unit), (0.25 / PI) as f32);
        for lane in 0..self.points.padded() {
            let p = self.points.toward(eye, lane);
            let factor = unit / (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt();
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
            scene.shapes.get(i).occlude(light.contact(i), shadow);
        }
    }
    if shadow.is_dark() {
        return;
    }
    if let Some(footprint) = footprint {
        let pyramid = Pyramid::new(light.position, footprint);
        darken_occluded_within(&pyramid, shadow, light, scene, receiver, stack);
    } else {
        let farthest = l1_norm(sub(shadow.bounds.center, shadow.points.reference)) + shadow.bounds.radius;
        let cone = Cone::from_apex(light.position, shadow.bounds, farthest);
        darken_occluded_within(&cone, shadow, light, scene, receiver, stack);
    }
}

/// Darken the points behind the objects of the tree that a volume around all their shadow rays intersects.
#[inline(always)]
fn darken_occluded_within(
    volume: &impl Volume,
    shadow: &mut ShadowRays<'_>,
    light: &Light,
    scene: &Scene,
    receiver: u32,
    stack: &mut Stack,
) {
    let mut traversal = scene.bvh.traverse(volume, stack);
    while let Some(i) = traversal.next(f32::INFINITY) {
        if i == receiver || light.carrier.is_some_and(|number| number == scene.numbers[i as usize]) {
            continue;
        }
        scene.shapes.get(i).occlude(light.contact(i), shadow);
        if shadow.is_dark() {
            return;
        }
    }
}
