//! Shadows of objects so far away that float32 cannot hold the lengths that decide.
//!
//! In perspective such an object was moved toward the eye, and so was such a light: then which of them is nearer is
//! no longer known. Elsewhere the object is where it was. Either way one shadow ray after another is traced in
//! float64, with point and light in the scale of the object. Nothing near touches it.

use crate::accel::Stack;
use crate::apex::Apex;
use crate::bounds::BoundingSphere;
use crate::budget::WorkCounter;
use crate::camera_space::FAR_FROM_ROUNDING;
use crate::scene::{Light, Scene};
use crate::shapes::points::Points;
use crate::shapes::primitive::Primitive;
use crate::tile::Lanes;
use crate::tile::rays::Ray;
use crate::vector::{Vector, add, dot, l1_norm, length, normalized, scale, sub};

/// From this sine on, the directions of a sun are not narrowed down.
const WIDE: f64 = 0.5;

/// A light, or one of its places, and points, in the scale of an object.
struct Scale {
    points: f64,
    light: f64,
}

impl Scale {
    fn new(scene: &Scene, light: &Light, (receiver, object): (u32, u32)) -> Scale {
        let own = scene.range_scale(object);
        let light = if light.was_moved() { own / light.range_scale } else { own };
        Scale { points: own / scene.range_scale(receiver), light }
    }

    fn apex(&self, apex: Apex) -> Apex {
        Apex { at: scale(apex.at, self.light), ..apex }
    }

    fn point(&self, point: Vector) -> Vector {
        scale(point, self.points)
    }
}

/// Whether a far object may hide a part of an emitter from points of another: a ball of radius `size` around an apex,
/// or directions up to an angle of that sine.
fn may_hide(
    scene: &Scene,
    light: &Light,
    (receiver, object): (u32, u32),
    (apex, size): (Apex, f64),
    bounds: BoundingSphere,
) -> bool {
    let in_scale = Scale::new(scene, light, (receiver, object));
    let Some(body) = scene.shapes.get_bounded(object).bounds() else { return true };
    let (from, apex) = (in_scale.point(bounds.center), in_scale.apex(apex));
    let to_body = sub(body.center, from);
    let way = normalized(apex.way_from(from));
    let along = dot(to_body, way);
    let beside = length(sub(to_body, scale(way, along)));
    let spread = match apex.is_direction() {
        true if size >= WIDE => return true,
        true => 2.0 * size * length(to_body),
        false => size * in_scale.light,
    };
    let reach = body.radius + bounds.radius * in_scale.points + spread + FAR_FROM_ROUNDING * l1_norm(to_body);
    beside <= reach && along >= -reach
}

/// Whether any far object may hide a part of an emitter of a size from points of a receiver.
#[inline(never)]
pub(crate) fn any_may_hide(
    scene: &Scene,
    (light, size): (&Light, f64),
    receiver: u32,
    bounds: BoundingSphere,
    work: &mut WorkCounter,
) -> bool {
    let far = scene.far.before(light.was_moved());
    let may_be_hidden_by = |object: u32| {
        let is_candidate = object != receiver && !scene.carries(object, light);
        is_candidate && may_hide(scene, light, (receiver, object), (light.apex, size), bounds)
    };
    work.take(far.len()) && far.iter().any(may_be_hidden_by)
}

/// Darken the points of a receiver from which far objects hide a light, or one of its places.
///
/// Away from the loops over shadow rays, which vectorize only while nothing else knows the rays.
#[inline(never)]
pub(crate) fn darken(
    scene: &Scene,
    (light, apex): (&Light, Apex),
    receiver: u32,
    (points, bounds): (&Points, BoundingSphere),
    irradiance: &mut Lanes,
    stack: &mut Stack,
) {
    let far = scene.far.before(light.was_moved());
    if !stack.work.take(far.len()) {
        return;
    }
    for object in far.iter() {
        if object == receiver || scene.carries(object, light) {
            continue;
        }
        if may_hide(scene, light, (receiver, object), (apex, 0.0), bounds) {
            if !stack.work.take(stack.steps_per_object) {
                return;
            }
            occlude(scene, (light, apex), (receiver, object), points, irradiance);
        }
    }
}

/// Darken the points of a receiver from which a far object hides the light. A light on its surface is not hidden by the
/// surface there.
fn occlude(
    scene: &Scene,
    (light, apex): (&Light, Apex),
    (receiver, object): (u32, u32),
    points: &Points,
    irradiance: &mut Lanes,
) {
    let in_scale = Scale::new(scene, light, (receiver, object));
    let apex = in_scale.apex(apex);
    let shape = scene.shapes.get_bounded(object);
    for (lane, irradiance) in irradiance[..points.count].iter_mut().enumerate() {
        let origin = in_scale.point(add(points.reference, points.offset_of(lane).map(f64::from)));
        let way = apex.way_from(origin);
        // Of length 1, so that no product overflows.
        let (depth, _) = shape.depth(Ray { origin, direction: normalized(way), start: 0.0 });
        let end = if apex.is_direction() { f64::INFINITY } else { length(way) * (1.0 - FAR_FROM_ROUNDING) };
        if depth < end {
            *irradiance = 0.0;
        }
    }
}
