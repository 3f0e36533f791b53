//! The solid shapes of a scene as convex bodies: how far one reaches in a direction, and how far two are apart.

#![forbid(unsafe_code)]

use parry3d_f64::math::{Pose, Rotation, Vector};
use parry3d_f64::query;
use parry3d_f64::shape::SharedShape;

/// A kind of shape: its name in a scene file, and its form and rotation from the parameters of an object.
type Kind = (&'static str, fn(&[f64]) -> (SharedShape, Rotation));

/// The solid shapes, with the parameters of `rtcli_tracer::world::ShapeDesc::KINDS`.
const KINDS: &[Kind] = &[
    ("sphere", |p| (SharedShape::ball(p[0]), Rotation::IDENTITY)),
    ("box", |p| (SharedShape::cuboid(p[0] / 2.0, p[1] / 2.0, p[2] / 2.0), rotation([p[4], p[3], p[5]]))),
];

/// A solid object.
pub struct Body {
    shape: SharedShape,
    pose: Pose,
}

impl Body {
    /// Return the body of an object, or None if objects of its kind are not solid. The position is its center.
    pub fn new(kind: &str, position: [f64; 3], parameters: &[f64]) -> Option<Body> {
        let (_, form) = KINDS.iter().find(|(name, _)| *name == kind)?;
        let (shape, rotation) = form(parameters);
        Some(Body { shape, pose: Pose::from_parts(Vector::from(position), rotation) })
    }

    /// Return the largest product of a direction and a point of the body, relative to its center.
    pub fn reach(&self, direction: [f64; 3]) -> f64 {
        let local = self.pose.rotation.inverse() * Vector::from(direction);
        let support = self.shape.as_support_map().expect("all solid shapes are convex");
        support.local_support_point(local).dot(local)
    }

    /// Return the distance between the surfaces of two bodies, 0 if they overlap.
    pub fn distance(&self, other: &Body) -> f64 {
        query::distance(&self.pose, &*self.shape, &other.pose, &*other.shape)
            .expect("all solid shapes are convex")
            .distance
    }
}

/// Return the rotation about x, then y, then z, by degrees.
fn rotation([x, y, z]: [f64; 3]) -> Rotation {
    let about = |axis: Vector, degrees: f64| {
        let half = degrees.to_radians() / 2.0;
        let (sine, cosine) = (libm::sin(half), libm::cos(half));
        Rotation::from_xyzw(axis.x * sine, axis.y * sine, axis.z * sine, cosine)
    };
    about(Vector::Z, z) * about(Vector::Y, y) * about(Vector::X, x)
}

#[cfg(test)]
mod tests {
    use super::Body;

    fn sphere(position: [f64; 3], radius: f64) -> Body {
        Body::new("sphere", position, &[radius]).unwrap()
    }

    fn cuboid(position: [f64; 3], size: [f64; 3], [x, y, z]: [f64; 3]) -> Body {
        Body::new("box", position, &[size[0], size[1], size[2], y, x, z]).unwrap()
    }

    fn assert_close(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-9, "{found} instead of {expected}");
    }

    #[test]
    fn spheres_are_as_far_apart_as_their_centers_less_the_radii() {
        assert_close(sphere([0.0; 3], 1.0).distance(&sphere([3.0, 4.0, 0.0], 1.5)), 2.5);
        assert_close(sphere([0.0; 3], 1.0).distance(&sphere([1.0, 0.0, 0.0], 1.0)), 0.0);
    }

    #[test]
    fn a_turned_box_reaches_out_with_its_edge() {
        let turned = cuboid([0.0; 3], [2.0; 3], [0.0, 45.0, 0.0]);
        assert_close(turned.reach([1.0, 0.0, 0.0]), 2f64.sqrt());
        assert_close(turned.reach([0.0, -1.0, 0.0]), 1.0);
        assert_close(turned.distance(&cuboid([5.0, 0.0, 0.0], [2.0; 3], [0.0; 3])), 4.0 - 2f64.sqrt());
        assert_close(turned.distance(&sphere([5.0, 0.0, 0.0], 1.0)), 4.0 - 2f64.sqrt());
    }

    #[test]
    fn a_box_is_turned_about_x_then_y_then_z() {
        // 90 degrees about x take y to z, and 90 degrees about y take z to x.
        let turned = cuboid([0.0; 3], [2.0, 6.0, 4.0], [90.0, 90.0, 0.0]);
        assert_close(turned.reach([1.0, 0.0, 0.0]), 3.0);
        assert_close(turned.reach([0.0, 1.0, 0.0]), 2.0);
        assert_close(turned.reach([0.0, 0.0, 1.0]), 1.0);
    }

    #[test]
    fn a_plane_is_no_body() {
        assert!(Body::new("plane", [0.0; 3], &[0.0, 1.0, 0.0]).is_none());
    }
}
