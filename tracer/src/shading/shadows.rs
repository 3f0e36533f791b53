//! Shadows of other objects on the points of a face.

use crate::accel::Stack;
use crate::accel::cone::Cone;
use crate::scene::{Light, Scene};
use crate::shapes::points::ShadowRays;
use crate::shapes::primitive::Primitive;
use crate::vector::{l1_norm, sub};

/// Darken the points from which another object hides the light.
///
/// The object that the points lie on, `receiver`, and the one that carries the light cast no shadow: see
/// `Lighting::accumulate_direct`.
#[inline(always)]
pub(crate) fn darken_occluded(
    shadow: &mut ShadowRays<'_>,
    light: &Light,
    scene: &Scene,
    receiver: u32,
    stack: &mut Stack,
) {
    for &i in &scene.unbounded {
        if i != receiver {
            scene.shapes[i as usize].occlude(light.contact(i), shadow);
        }
    }
    if shadow.is_dark() {
        return;
    }
    let farthest = l1_norm(sub(shadow.bounds.center, shadow.points.reference)) + shadow.bounds.radius;
    let cone = Cone::from_apex(light.position, shadow.bounds, farthest);
    let mut traversal = scene.bvh.traverse(&cone, stack);
    while let Some(i) = traversal.next(f32::INFINITY) {
        if i == receiver || Some(i) == light.carrier {
            continue;
        }
        scene.shapes[i as usize].occlude(light.contact(i), shadow);
        if shadow.is_dark() {
            return;
        }
    }
}
