//! A cylinder, closed by two discs.

use crate::camera_space::CameraSpace;
use crate::shapes::contact::Contact;
use crate::shapes::frustum::{Frustum, Profile};
use crate::shapes::primitive::Description;
use crate::vector::{Vector, normalized};

pub(crate) use crate::shapes::frustum::Frustum as Cylinder;

/// A cylinder around its position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CylinderDesc {
    /// Greater than 0.
    pub radius: f64,
    /// Greater than 0.
    pub height: f64,
    /// Any length but 0.
    pub axis: Vector,
}

impl CylinderDesc {
    fn profile(&self, space: &CameraSpace) -> Profile {
        let radius = space.length(self.radius);
        Profile::new(radius, radius, space.length(self.height))
    }
}

impl Description for CylinderDesc {
    const PARAMETERS: usize = 5;

    type Shape = Cylinder;

    fn new(parameters: &[f64]) -> CylinderDesc {
        let p = parameters;
        CylinderDesc { radius: p[0], height: p[1], axis: [p[2], p[3], p[4]] }
    }

    fn size(&self) -> f64 {
        self.height.max(self.radius)
    }

    fn contact(&self, space: &CameraSpace, position: Vector, point: Vector) -> Contact {
        Frustum::contact(point, position, normalized(self.axis), &self.profile(space))
    }

    fn transform(&self, space: &CameraSpace, position: Vector, range_scale: f64) -> Cylinder {
        Frustum::transform(space, (position, normalized(self.axis)), &self.profile(space), range_scale)
    }
}
