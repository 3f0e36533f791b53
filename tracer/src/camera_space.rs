//! Camera space: relative to the eye, in the camera's axes, in a unit that suits the scene.
//!
//! With x to the right, y up and z along the view, the ray through a point of the image plane is v = (x, y, 1),
//! not normalised: its parameter t is the depth z. Subtracting the eye in float64 keeps a scene far from the
//! origin as accurate as one around it; the unit, a power of two, keeps lengths within float32.

use crate::camera::Camera;
use crate::vector::{Vector, largest, rotate, sub};

/// Rounding in camera space is less than this share of distances from the eye and sizes.
pub(crate) const FAR_FROM_ROUNDING: f64 = 1e-12;

/// Lengths are clamped to this many units; its square still fits into float64.
const MAX_LENGTH: f64 = 1e120;

/// Points farther than this many units, 2^60, are moved to this distance.
pub(crate) const MAX_RANGE: f64 = (1_u64 << 60) as f64;

/// The transformation from world space to camera space.
pub(crate) struct CameraSpace {
    /// The eye, scaled.
    pub(crate) eye: Vector,
    /// The camera's axes in world space: right, up, forward.
    axes: [Vector; 3],
    /// Units of camera space per unit of the world: a power of two.
    pub(crate) unit: f64,
}

impl CameraSpace {
    pub(crate) fn new(camera: &Camera, unit: f64) -> CameraSpace {
        let mut space = CameraSpace { eye: [0.0; 3], axes: [camera.right, camera.up, camera.forward], unit };
        space.eye = space.scaled(camera.position);
        space
    }

    /// Scale a length.
    pub(crate) fn length(&self, length: f64) -> f64 {
        (length * self.unit).clamp(-MAX_LENGTH, MAX_LENGTH)
    }

    /// Scale a point of world space, keeping its origin and axes.
    pub(crate) fn scaled(&self, point: Vector) -> Vector {
        // Scaled before the eye is subtracted: the difference of huge coordinates might overflow.
        point.map(|component| self.length(component))
    }

    /// Transform a direction of world space.
    pub(crate) fn direction(&self, direction: Vector) -> Vector {
        rotate(&self.axes, direction)
    }

    /// Transform a scaled point.
    pub(crate) fn point(&self, scaled: Vector) -> Vector {
        self.direction(sub(scaled, self.eye))
    }

    /// Return the factor by which an object at a scaled point is moved toward the eye, so that its distance fits
    /// float32; 1 for all but extreme distances. `size` is scaled too. The object shrinks by the same factor, so
    /// that it looks the same from the eye.
    pub(crate) fn range_scale(&self, scaled: Vector, size: f64) -> f64 {
        let distance = largest(sub(scaled, self.eye));
        if size < distance / 2.0 { range_scale_at(distance) } else { 1.0 }
    }
}

/// Return the factor that moves a point at a distance from the eye into range, 1 if it is in range.
pub(crate) fn range_scale_at(distance: f64) -> f64 {
    (MAX_RANGE / distance).min(1.0)
}
