//! Lights with a size, as many pencils of rays: fixed places, each an apex of its own.

use crate::apex::Apex;
use crate::camera_space::CameraSpace;
use crate::memory::{OutOfMemory, with_capacity};
use crate::scene::LIGHTS;
use crate::vector::{Vector, add, cross, normalized, scale};
use std::f64::consts::PI;

/// Emitters are at most as large, so that the squares of distances to them stay within float32: 2^59.
const LARGEST: f64 = (1_u64 << 59) as f64;

/// A light with a size.
#[derive(Clone, Debug)]
pub(crate) struct Emitter {
    /// The radius of a ball; the sine of half the angular diameter of a sun. Its middle must be so high above a
    /// tangent plane for all of it to be above.
    pub(crate) size: f64,
    pub(crate) places: Vec<Apex>,
    /// Places count as no nearer to a point than this.
    pub(crate) nearest: f64,
    /// The share of one place in the light of all of them.
    pub(crate) share: f32,
    /// The objects whose surface may cut it.
    pub(crate) cut: Vec<u32>,
}

impl Emitter {
    /// A ball in camera space, with a pattern of places in the world's axes. It has no objects that cut it yet.
    ///
    /// # Errors
    ///
    /// If memory runs out.
    pub(crate) fn ball(
        space: &CameraSpace,
        position: Vector,
        radius: f64,
        pattern: &[Vector],
    ) -> Result<Emitter, OutOfMemory> {
        let size = radius.min(LARGEST);
        let mut places = with_capacity(pattern.len(), LIGHTS)?;
        let place = |&place: &Vector| Apex::point(add(position, scale(space.direction(place), size)));
        places.extend(pattern.iter().map(place));
        Ok(Emitter {
            size,
            // So that a surface inside the ball has no bright spots.
            nearest: size / 4.0,
            share: (1.0 / places.len() as f64) as f32,
            places,
            cut: Vec::new(),
        })
    }

    /// A sun: a disk of directions of even radiance around the one `toward` it, in the world's axes.
    ///
    /// With the half angle a, the places (x, y) of a disk of radius 1 and any axes u, v across:
    ///
    /// 1 - cos(t) = (x^2 + y^2) (1 - cos(a)),  l = cos(t) toward + sin(t) (x u + y v) / |(x, y)|
    ///
    /// Its light on a surface that faces it is L pi sin^2(a), and a place is seen in a solid angle of
    /// 2 pi (1 - cos(a)) / n.
    ///
    /// # Errors
    ///
    /// If memory runs out.
    pub(crate) fn sun(
        space: &CameraSpace,
        toward: Vector,
        angle: f64,
        pattern: &[Vector],
    ) -> Result<Emitter, OutOfMemory> {
        let half = angle * (PI / 360.0);
        let (size, cosine) = (libm::sin(half), libm::cos(half));
        // 1 - cos(a), without cancellation.
        let depth = size * size / (1.0 + cosine);
        let (u, v) = axes_across(toward);
        let mut places = with_capacity(pattern.len(), LIGHTS)?;
        let place = |&[x, y, _]: &Vector| {
            let fall = (x * x + y * y) * depth;
            // sin(t) / |(x, y)|
            let out = (depth * (2.0 - fall)).sqrt();
            let across = add(scale(u, out * x), scale(v, out * y));
            Apex::direction(space.direction(add(scale(toward, 1.0 - fall), across)))
        };
        places.extend(pattern.iter().map(place));
        let share = (2.0 / (1.0 + cosine) / places.len() as f64) as f32;
        Ok(Emitter { size, nearest: 0.0, share, places, cut: Vec::new() })
    }
}

/// Return two unit vectors at right angles to a third and to each other.
fn axes_across(direction: Vector) -> (Vector, Vector) {
    let mut least = 0;
    for axis in 1..3 {
        if direction[axis].abs() < direction[least].abs() {
            least = axis;
        }
    }
    let mut axis = [0.0; 3];
    axis[least] = 1.0;
    let u = normalized(cross(axis, direction));
    (u, cross(direction, u))
}
