//! The solid shapes of a scene as convex bodies: how far one reaches in a direction, and how far two are apart.
//!
//! - `boxes`: the boxes around many objects
//! - `enclosures`: the search for boxes that hold others

#![forbid(unsafe_code)]

pub mod boxes;
pub mod enclosures;

use parry3d_f64::math::{Pose, Rotation, Vector};
use parry3d_f64::query::details::distance_support_map_support_map;
use parry3d_f64::shape::{Cuboid, SupportMap};

/// A kind of shape: its name in a scene file, and its form from the parameters of an object.
type Kind = (&'static str, fn(&[f64]) -> Form);

/// The solid shapes, with the parameters of `rtcli_tracer::world::ShapeDesc::KINDS`.
const KINDS: &[Kind] = &[
    ("sphere", |p| Form::round(Frustum::default(), p[0], Vector::Y)),
    ("box", |p| Form {
        core: Box::new(Cuboid::new(Vector::new(p[0], p[1], p[2]) / 2.0)),
        inradius: p[0].min(p[1]).min(p[2]) / 2.0,
        radius: 0.0,
        rotation: rotation([p[4], p[3], p[5]]),
    }),
    ("cylinder", |p| Form::round(Frustum::new(p[0], p[0], p[1]), 0.0, axis(&p[2..]))),
    ("capsule", |p| Form::round(Frustum::new(0.0, 0.0, p[1]), p[0], axis(&p[2..]))),
    ("cone", |p| Form::round(Frustum::new(p[0], p[1], p[2]), 0.0, axis(&p[3..]))),
];

/// All points within a radius of a core, which is turned about its middle.
struct Form {
    core: Box<dyn SupportMap + Send + Sync>,
    /// The radius of the largest ball around the middle that is within the core.
    inradius: f64,
    radius: f64,
    rotation: Rotation,
}

impl Form {
    /// All points within a radius of a frustum with an axis.
    fn round(core: Frustum, radius: f64, axis: Vector) -> Form {
        let inradius = core.inradius();
        Form { core: Box::new(core), inradius, radius, rotation: Rotation::from_rotation_arc(Vector::Y, axis) }
    }
}

/// The frustum of a cone around the y axis, its middle at the origin; a segment or a point if the radii are 0.
#[derive(Default)]
struct Frustum {
    /// The radii of the base and the top.
    radii: [f64; 2],
    half_height: f64,
}

impl Frustum {
    fn new(base: f64, top: f64, height: f64) -> Frustum {
        Frustum { radii: [base, top], half_height: height / 2.0 }
    }

    /// The radius of the largest ball around the origin: it touches a disc, or the side.
    ///
    /// The side has the distance (r_base + r_top) h / sqrt(4 h^2 + (r_base - r_top)^2) from the origin, where h is half
    /// the height.
    fn inradius(&self) -> f64 {
        let ([base, top], height) = (self.radii, self.half_height);
        if height == 0.0 {
            return 0.0;
        }
        let side = (base + top) * height / (4.0 * height * height + (base - top) * (base - top)).sqrt();
        side.min(height)
    }
}

impl SupportMap for Frustum {
    /// The farthest point is on the rim of the base or of the top.
    fn local_support_point(&self, direction: Vector) -> Vector {
        let across = Vector::new(direction.x, 0.0, direction.z).normalize_or_zero();
        let [base, top] = self.radii;
        let lower = across * base - Vector::Y * self.half_height;
        let upper = across * top + Vector::Y * self.half_height;
        if lower.dot(direction) > upper.dot(direction) { lower } else { upper }
    }
}

/// A solid object.
pub struct Body {
    form: Form,
    pose: Pose,
}

impl Body {
    /// Return the body of an object, or None if objects of its kind are not solid. The position is its middle.
    pub fn new(kind: &str, position: [f64; 3], parameters: &[f64]) -> Option<Body> {
        let (_, form) = KINDS.iter().find(|(name, _)| *name == kind)?;
        let form = form(parameters);
        Some(Body { pose: Pose::from_parts(Vector::from(position), form.rotation), form })
    }

    /// Return the largest product of a direction and a point of the body, relative to its position.
    pub fn reach(&self, direction: [f64; 3]) -> f64 {
        let local = self.pose.rotation.inverse() * Vector::from(direction);
        self.form.core.local_support_point(local).dot(local) + self.form.radius * local.length()
    }

    /// Return the radius of the largest ball around the position that is within the body.
    pub fn inradius(&self) -> f64 {
        self.form.inradius + self.form.radius
    }

    /// Return the distance between the surfaces of two bodies, 0 if they overlap.
    pub fn distance(&self, other: &Body) -> f64 {
        let between = self.pose.inv_mul(&other.pose);
        let cores = distance_support_map_support_map(&between, &*self.form.core, &*other.form.core);
        (cores - self.form.radius - other.form.radius).max(0.0)
    }
}

/// Return a direction of any length as a unit vector.
fn axis(direction: &[f64]) -> Vector {
    Vector::new(direction[0], direction[1], direction[2]).normalize()
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
    fn a_cylinder_reaches_out_with_its_rim() {
        let upright = Body::new("cylinder", [0.0; 3], &[1.0, 4.0, 0.0, 3.0, 0.0]).unwrap();
        assert_close(upright.reach([1.0, 1.0, 0.0]), 3.0);
        let lying = Body::new("cylinder", [0.0, 1.0, 0.0], &[1.0, 4.0, 0.0, 0.0, -2.0]).unwrap();
        assert_close(lying.reach([0.0, -1.0, 0.0]), 1.0);
        assert_close(lying.distance(&sphere([0.0, 5.0, 0.0], 1.0)), 2.0);
        assert_close(lying.distance(&sphere([0.0, 1.0, 5.0], 1.0)), 2.0);
    }

    #[test]
    fn a_capsule_is_round_at_its_ends() {
        let capsule = Body::new("capsule", [0.0; 3], &[1.0, 4.0, 0.0, 1.0, 0.0]).unwrap();
        assert_close(capsule.reach([0.0, 1.0, 0.0]), 3.0);
        assert_close(capsule.distance(&sphere([3.0, 6.0, 0.0], 1.0)), 3.0);
        assert_close(capsule.distance(&sphere([4.0, 1.5, 0.0], 1.0)), 2.0);
        let point = Body::new("capsule", [0.0; 3], &[1.0, 0.0, 0.0, 1.0, 0.0]).unwrap();
        assert_close(point.distance(&sphere([3.0, 4.0, 0.0], 1.0)), 3.0);
    }

    #[test]
    fn a_cone_ends_in_its_tip() {
        let cone = Body::new("cone", [0.0; 3], &[1.0, 0.0, 2.0, 0.0, -1.0, 0.0]).unwrap();
        assert_close(cone.reach([0.0, -1.0, 0.0]), 1.0);
        assert_close(cone.reach([1.0, 0.0, 0.0]), 1.0);
        assert_close(cone.distance(&sphere([0.0, -4.0, 0.0], 1.0)), 2.0);
        let frustum = Body::new("cone", [0.0; 3], &[2.0, 1.0, 2.0, 0.0, 1.0, 0.0]).unwrap();
        assert_close(frustum.reach([1.0, 1.0, 0.0]), 2.0);
    }

    #[test]
    fn the_largest_ball_in_a_body_touches_its_nearest_side() {
        let inradius = |kind, parameters: &[f64]| Body::new(kind, [1.0; 3], parameters).unwrap().inradius();
        assert_close(inradius("sphere", &[1.5]), 1.5);
        assert_close(inradius("box", &[2.0, 6.0, 4.0, 30.0, 20.0, 10.0]), 1.0);
        assert_close(inradius("cylinder", &[1.0, 4.0, 0.0, 3.0, 0.0]), 1.0);
        assert_close(inradius("cylinder", &[3.0, 4.0, 0.0, 3.0, 0.0]), 2.0);
        assert_close(inradius("capsule", &[1.0, 4.0, 0.0, 1.0, 0.0]), 1.0);
        // Its side goes from 3 beside the base's middle to the tip, 4 above it: 1.2 from the middle between them.
        assert_close(inradius("cone", &[3.0, 0.0, 4.0, 0.0, 1.0, 0.0]), 1.2);
    }

    #[test]
    fn a_plane_is_no_body() {
        assert!(Body::new("plane", [0.0; 3], &[0.0, 1.0, 0.0]).is_none());
    }
}
