//! A cone, or the frustum of one, closed by discs.

use crate::camera_space::CameraSpace;
use crate::shapes::contact::Contact;
use crate::shapes::frustum::{Frustum, Profile};
use crate::shapes::primitive::Description;
use crate::vector::{Vector, normalized};

pub(crate) use crate::shapes::frustum::Frustum as Cone;

/// A cone around the middle of its axis, which is its position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConeDesc {
    /// The radius of the base, greater than 0.
    pub radius: f64,
    /// 0 or more.
    pub top_radius: f64,
    /// Greater than 0.
    pub height: f64,
    /// From the base to the top, any length but 0.
    pub axis: Vector,
}

impl ConeDesc {
    fn profile(&self, space: &CameraSpace) -> Profile {
        let [base, top, height] = [self.radius, self.top_radius, self.height].map(|length| space.length(length));
        Profile::new(base, top, height)
    }
}

impl Description for ConeDesc {
    const PARAMETERS: usize = 6;

    type Shape = Cone;

    fn new(parameters: &[f64]) -> ConeDesc {
        let p = parameters;
        ConeDesc { radius: p[0], top_radius: p[1], height: p[2], axis: [p[3], p[4], p[5]] }
    }

    fn size(&self) -> f64 {
        self.height.max(self.radius).max(self.top_radius)
    }

    fn contact(&self, space: &CameraSpace, position: Vector, point: Vector) -> Contact {
        Frustum::contact(point, position, normalized(self.axis), &self.profile(space))
    }

    fn transform(&self, space: &CameraSpace, position: Vector, range_scale: f64) -> Cone {
        Frustum::transform(space, (position, normalized(self.axis)), &self.profile(space), range_scale)
    }
}
