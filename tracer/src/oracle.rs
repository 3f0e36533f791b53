//! The oracle of the kernel's tests: shapes intersected in float64, by independent formulas.

use crate::apex::Apex;
use crate::camera::{Projection, half_tangent};
use crate::shapes::Shapes;
use crate::shapes::capsule::Capsule;
use crate::shapes::contact::{Contact, Side};
use crate::shapes::cuboid::Cuboid;
use crate::shapes::frustum::{Frustum, Profile};
use crate::shapes::plane::Plane;
use crate::shapes::points::{Points, ShadowRays};
use crate::shapes::primitive::Primitive;
use crate::shapes::sphere::Sphere;
use crate::tile::hits::{FACE_BITS, HitBuffer, NO_FACE};
use crate::tile::rays::{Ray, Rays};
use crate::tile::{LANES, Lanes, SIDE, View};
use crate::vector::{Vector, add, dot, length, scale, sub};
use crate::world::{
    Camera, CapsuleDesc, CheckerDesc, ConeDesc, CuboidDesc, CylinderDesc, LightDesc, LightSource, Object,
    PlaneDesc, Settings, ShapeDesc, SphereDesc, World,
};
use proptest::prelude::*;

const EYE: Vector = [0.0; 3];

impl From<Vector> for Apex {
    fn from(position: Vector) -> Apex {
        Apex::point(position)
    }
}

impl View {
    /// Return a view of square pixels with the principal point in the middle.
    pub(crate) fn centered(width: u32, height: u32, half_pixel: f64) -> View {
        let projection = Projection::Perspective;
        View { width, height, projection, half_pixel: (half_pixel, half_pixel), center: (0.0, 0.0) }
    }

    /// Return the same view with parallel rays.
    pub(crate) fn parallel(width: u32, height: u32, half_pixel: f64) -> View {
        View { projection: Projection::Orthographic, ..View::centered(width, height, half_pixel) }
    }
}

impl Camera {
    /// Return a camera at the origin that looks along -z.
    pub(crate) fn along_z(width: u32, height: u32, fov: f64) -> Camera {
        Camera {
            width,
            height,
            projection: Projection::Perspective,
            half_height: half_tangent(fov),
            pixel_aspect: 1.0,
            center: (0.0, 0.0),
            position: [0.0; 3],
            right: [1.0, 0.0, 0.0],
            up: [0.0, 1.0, 0.0],
            forward: [0.0, 0.0, -1.0],
        }
    }
}

/// A shape in camera space.
#[derive(Clone, Debug)]
pub(crate) enum OracleShape {
    Sphere { center: Vector, radius: f64 },
    Plane { normal: Vector, offset: f64 },
    Box { center: Vector, axes: [Vector; 3], half: Vector },
    Frustum { center: Vector, axis: Vector, radii: [f64; 2], half: f64 },
    Capsule { center: Vector, axis: Vector, radius: f64, half: f64 },
}

impl OracleShape {
    /// The same shape for the kernel, with the index 0.
    pub(crate) fn to_kernel(&self) -> Shapes {
        let mut shapes = Shapes::default();
        match *self {
            OracleShape::Sphere { center, radius } => shapes.sphere.push(Sphere::new(center, radius, None)),
            OracleShape::Plane { normal, offset } => shapes.plane.push(Plane::new(normal, offset, offset.abs())),
            OracleShape::Box { center, axes, half } => {
                shapes.cuboid.push(Cuboid { center, axes, half, eye: self.contact(EYE).local });
            }
            OracleShape::Frustum { center, axis, radii: [base, top], half } => {
                shapes.cone.push(Frustum::new(center, axis, Profile::new(base, top, 2.0 * half), None));
            }
            OracleShape::Capsule { center, axis, radius, half } => {
                let profile = Profile::new(radius, radius, 2.0 * half);
                let tube = Frustum::new(center, axis, profile, None);
                shapes.capsule.push(Capsule::new(tube, &self.contact(EYE), false));
            }
        }
        shapes
    }

    /// Return where a point is relative to the surface.
    pub(crate) fn contact(&self, point: Vector) -> Contact {
        match *self {
            OracleShape::Sphere { center, radius } => Sphere::contact(point, center, radius),
            OracleShape::Plane { normal, offset } => Plane::contact(point, scale(normal, offset), normal),
            OracleShape::Box { center, axes, half } => Cuboid::contact(point, center, &axes, half),
            OracleShape::Frustum { center, axis, radii: [base, top], half } => {
                Frustum::contact(point, center, axis, &Profile::new(base, top, 2.0 * half))
            }
            OracleShape::Capsule { center, axis, radius, half } => {
                Capsule::contact(point, center, axis, &Profile::new(radius, radius, 2.0 * half))
            }
        }
    }

    /// The shape with its surface moved outward.
    pub(crate) fn swollen(&self, by: f64) -> OracleShape {
        let mut shape = self.clone();
        match &mut shape {
            OracleShape::Sphere { radius, .. } => *radius += by,
            OracleShape::Plane { offset, .. } => *offset += by,
            OracleShape::Box { half, .. } => half.iter_mut().for_each(|half| *half += by),
            OracleShape::Capsule { radius, .. } => *radius += by,
            OracleShape::Frustum { radii, half, .. } => {
                // The side moves by this at right angles to it, and the discs cut it off farther out.
                let slope = (radii[1] - radii[0]) / (2.0 * *half);
                let aside = by * (1.0 + slope * slope).sqrt();
                radii[0] = (radii[0] + aside - by * slope).max(0.0);
                radii[1] = (radii[1] + aside + by * slope).max(0.0);
                *half += by;
            }
        }
        shape
    }

    /// The radius, or something like it, or 0 for a plane.
    pub(crate) fn size(&self) -> f64 {
        match *self {
            OracleShape::Sphere { radius, .. } => radius,
            OracleShape::Plane { .. } => 0.0,
            OracleShape::Box { half, .. } => length(half),
            OracleShape::Frustum { radii, half, .. } => half + radii[0].max(radii[1]),
            OracleShape::Capsule { radius, half, .. } => half + radius,
        }
    }

    /// A point in the middle of it.
    pub(crate) fn center(&self) -> Vector {
        match *self {
            OracleShape::Sphere { center, .. }
            | OracleShape::Box { center, .. }
            | OracleShape::Frustum { center, .. }
            | OracleShape::Capsule { center, .. } => center,
            OracleShape::Plane { normal, offset } => scale(normal, offset),
        }
    }

    /// The parameters at which a line enters and leaves the shape; equal for a plane.
    pub(crate) fn span(&self, origin: Vector, direction: Vector) -> Option<(f64, f64)> {
        match *self {
            OracleShape::Sphere { center, radius } => sphere_span(sub(center, origin), radius, direction),
            OracleShape::Plane { normal, offset } => {
                let t = (offset - dot(normal, origin)) / dot(normal, direction);
                t.is_finite().then_some((t, t))
            }
            OracleShape::Box { center, axes, half } => {
                let mut span = (f64::NEG_INFINITY, f64::INFINITY);
                for i in 0..3 {
                    let from = dot(axes[i], sub(origin, center));
                    let along = dot(axes[i], direction);
                    let (a, b) = ((-half[i] - from) / along, (half[i] - from) / along);
                    span = (span.0.max(a.min(b)), span.1.min(a.max(b)));
                }
                (span.0 <= span.1 && half.iter().all(|&half| half > 0.0)).then_some(span)
            }
            OracleShape::Frustum { center, axis, radii, half } => {
                frustum_span(sub(origin, center), direction, axis, radii, half)
            }
            OracleShape::Capsule { center, axis, radius, half } => {
                // From the first of its parts to the last.
                let from = sub(origin, center);
                let end = |sign: f64| sphere_span(sub(scale(axis, sign * half), from), radius, direction);
                let tube = frustum_span(from, direction, axis, [radius; 2], half);
                let parts = [end(-1.0), end(1.0), tube];
                parts.into_iter().flatten().reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
            }
        }
    }

    /// The parameter at which a ray first meets the surface.
    pub(crate) fn depth(&self, ray: Ray) -> Option<f64> {
        let (near, far) = self.span(ray.origin, ray.direction)?;
        [near, far].into_iter().find(|&t| t > 0.0)
    }

    /// Whether the surface crosses the segment between a light and a point.
    pub(crate) fn stands_between(&self, light: Apex, point: Vector) -> bool {
        let crossing = self.span(point, light.way_from(point));
        let end = if light.is_direction() { f64::INFINITY } else { 1.0 };
        crossing.is_some_and(|(near, far)| [near, far].into_iter().any(|t| 0.0 < t && t < end))
    }

    /// The distance of a point from the surface.
    pub(crate) fn distance(&self, point: Vector) -> f64 {
        match *self {
            OracleShape::Sphere { center, radius } => (length(sub(point, center)) - radius).abs(),
            OracleShape::Plane { normal, offset } => (dot(normal, point) - offset).abs(),
            OracleShape::Box { center, axes, half } => {
                let beyond: Vector = std::array::from_fn(|i| dot(axes[i], sub(point, center)).abs() - half[i]);
                let deepest = beyond.into_iter().fold(f64::NEG_INFINITY, f64::max);
                if deepest < 0.0 { -deepest } else { length(beyond.map(|b| b.max(0.0))) }
            }
            OracleShape::Frustum { center, axis, radii: [base, top], half } => {
                // The distance to the three segments of its section.
                let relative = sub(point, center);
                let z = dot(relative, axis);
                let away = length(sub(relative, scale(axis, z)));
                let corners = [[0.0, -half], [base, -half], [top, half], [0.0, half]];
                let to = |pair: &[[f64; 2]]| {
                    let way = [pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]];
                    let from = [away - pair[0][0], z - pair[0][1]];
                    let share =
                        (from[0] * way[0] + from[1] * way[1]) / (way[0] * way[0] + way[1] * way[1]).max(1e-300);
                    let share = share.clamp(0.0, 1.0);
                    (from[0] - share * way[0]).hypot(from[1] - share * way[1])
                };
                corners.windows(2).map(to).fold(f64::INFINITY, f64::min)
            }
            OracleShape::Capsule { center, axis, radius, half } => {
                let relative = sub(point, center);
                let z = dot(relative, axis).clamp(-half, half);
                (length(sub(relative, scale(axis, z))) - radius).abs()
            }
        }
    }
}

fn sphere_span(center: Vector, radius: f64, direction: Vector) -> Option<(f64, f64)> {
    let speed = length(direction);
    let unit = scale(direction, 1.0 / speed);
    let middle = dot(center, unit);
    let foot = sub(center, scale(unit, middle));
    let half = (radius * radius - dot(foot, foot)).sqrt();
    (radius > 0.0 && half >= 0.0).then_some(((middle - half) / speed, (middle + half) / speed))
}

/// Where a line is inside a frustum around the origin: between the roots where |p - (p.a) a| = r(p.a), as far as
/// they are between the discs, and the discs where the line crosses them inside.
fn frustum_span(
    from: Vector,
    direction: Vector,
    axis: Vector,
    [base, top]: [f64; 2],
    half: f64,
) -> Option<(f64, f64)> {
    let (z, rise) = (dot(from, axis), dot(direction, axis));
    let (p, v) = (sub(from, scale(axis, z)), sub(direction, scale(axis, rise)));
    let slope = (top - base) / (2.0 * half);
    let radius = (base + top) / 2.0 + slope * z;
    let a = dot(v, v) - slope * rise * slope * rise;
    let b = dot(p, v) - radius * slope * rise;
    let c = length(p) * length(p) - radius * radius;
    let root = (b * b - a * c).sqrt();
    let between = |t: &f64| (z + t * rise).abs() <= half;
    let mut ends: Vec<f64> = [(-b - root) / a, (-b + root) / a].into_iter().filter(between).collect();
    for (end, radius) in [(-half, base), (half, top)] {
        let t = (end - z) / rise;
        if length(add(p, scale(v, t))) <= radius {
            ends.push(t);
        }
    }
    let near = ends.iter().copied().reduce(f64::min)?;
    let far = ends.iter().copied().reduce(f64::max)?;
    (base.max(top) > 0.0 && half > 0.0).then_some((near, far))
}

/// The ray of a lane, in float64.
pub(crate) fn exact_ray(view: View, corner: (u32, u32), lane: usize) -> Ray {
    let x = f64::from(corner.0 + lane as u32 % SIDE) + 0.5;
    let y = f64::from(corner.1 + lane as u32 / SIDE) + 0.5;
    let x = (2.0 * x - f64::from(view.width)) * view.half_pixel.0 + view.center.0;
    let y = (f64::from(view.height) - 2.0 * y) * view.half_pixel.1 + view.center.1;
    match view.projection {
        Projection::Perspective => Ray { origin: EYE, direction: [x, y, 1.0], start: 0.0 },
        Projection::Orthographic => Ray { origin: [x, y, 0.0], direction: [0.0, 0.0, 1.0], start: 0.0 },
    }
}

/// The rays through the pixel centres of a tile.
pub(crate) fn rays_of(view: View, corner: (u32, u32)) -> Rays {
    let mut rays = Rays::new();
    rays.generate(view, corner, (0.5, 0.5));
    rays
}

/// The point of a lane, relative to the eye.
pub(crate) fn point_of(points: &Points, lane: usize) -> Vector {
    let offset = points.offset.each_ref().map(|axis| f64::from(axis[lane]));
    add(points.reference, offset)
}

/// A number of any size between two powers of ten.
pub(crate) fn any_size(exponents: std::ops::Range<f64>) -> impl Strategy<Value = f64> {
    exponents.prop_map(|exponent| 10_f64.powf(exponent))
}

/// A direction.
pub(crate) fn any_direction() -> impl Strategy<Value = Vector> {
    let component = || -1.0..1.0;
    [component(), component(), component()]
        .prop_filter("not too short", |v| length(*v) > 0.1)
        .prop_map(|v| scale(v, 1.0 / length(v)))
}

/// Axes at right angles to each other.
pub(crate) fn any_axes() -> impl Strategy<Value = [Vector; 3]> {
    (any_direction(), any_direction()).prop_filter("not parallel", |(a, b)| dot(*a, *b).abs() < 0.9).prop_map(
        |(a, b)| {
            let b = sub(b, scale(a, dot(a, b)));
            let b = scale(b, 1.0 / length(b));
            [a, b, crate::vector::cross(a, b)]
        },
    )
}

/// A tile of a picture, at any focal length from telescope to fisheye.
pub(crate) fn any_tile() -> impl Strategy<Value = (View, (u32, u32))> {
    (any_size(-8.0..-2.0), 0_u32..10, 0_u32..10).prop_map(|(half_pixel, column, row)| {
        let view = View::centered(160, 160, half_pixel);
        (view, (column * SIDE, row * SIDE))
    })
}

/// A tile of parallel rays.
pub(crate) fn any_parallel_tile() -> impl Strategy<Value = (View, (u32, u32))> {
    (any_size(-3.0..3.0), 0_u32..10, 0_u32..10).prop_map(|(half_pixel, column, row)| {
        let view = View::parallel(160, 160, half_pixel);
        (view, (column * SIDE, row * SIDE))
    })
}

/// The ray through the middle of a tile.
pub(crate) fn middle_of((view, corner): (View, (u32, u32))) -> Ray {
    let rays = rays_of(view, corner);
    Ray { origin: rays.origin, direction: rays.middle, start: 0.0 }
}

/// A bounded shape whose outline is likely to cross a tile, or around the eye.
///
/// `distances` are powers of ten: its distance from the eye, relative to its size.
pub(crate) fn shape_before(
    tile: (View, (u32, u32)),
    distances: std::ops::Range<f64>,
) -> impl Strategy<Value = OracleShape> {
    let center = (any_size(-6.0..6.0), any_size(distances), any_direction(), 0.0..1.5_f64);
    (center, any_axes(), [0.1..1.0, 0.1..1.0, 0.1..1.0], (0..3, 0..5)).prop_map(
        move |((size, distance, aside, share), axes, sides, (place, kind))| {
            let (view, _) = tile;
            let away = size * (1.0 + distance);
            let reach = size + rays_of(view, tile.1).divergence(away) * view.half_pixel.0 * f64::from(SIDE);
            let Ray { origin, direction, .. } = middle_of(tile);
            let ahead = scale(direction, away / length(direction));
            // The eye may also be inside.
            let offset = if place == 0 {
                scale(aside, 0.9 * share.min(1.0) * size / 3.0_f64.sqrt() * 0.1)
            } else {
                add(ahead, scale(aside, share * reach))
            };
            let center = add(origin, offset);
            let (half, axis) = (sides.map(|side| side * size), axes[0]);
            match kind {
                0 => OracleShape::Sphere { center, radius: size },
                1 => OracleShape::Box { center, axes, half },
                2 => OracleShape::Frustum { center, axis, radii: [half[1]; 2], half: half[0] },
                3 => {
                    // Half of the cones end in a point.
                    let top = if sides[2] < 0.5 { 0.0 } else { half[2] };
                    OracleShape::Frustum { center, axis, radii: [half[1], top], half: half[0] }
                }
                _ => OracleShape::Capsule { center, axis, radius: half[1], half: half[0] },
            }
        },
    )
}

/// A plane in front of or behind the eye.
pub(crate) fn any_plane() -> impl Strategy<Value = OracleShape> {
    (any_direction(), any_size(-6.0..6.0), any::<bool>()).prop_map(|(normal, offset, behind)| OracleShape::Plane {
        normal,
        offset: if behind { -offset } else { offset },
    })
}

/// Check the kernel's hits of the rays of a tile against the shape, allowing an error of `error` in the position
/// of its surface.
pub(crate) fn check_intersection(
    shape: &OracleShape,
    (view, corner): (View, (u32, u32)),
    error: f64,
) -> Result<HitBuffer, TestCaseError> {
    let mut hits = HitBuffer::new();
    shape.to_kernel().get(0).intersect(FACE, &rays_of(view, corner), &mut hits);
    for lane in 0..LANES {
        let v = exact_ray(view, corner, lane);
        let bounds = [shape.swollen(error).depth(v), shape.swollen(-error).depth(v)];
        let t = f64::from(hits.t[lane]);
        let hit = hits.face[lane] != NO_FACE;
        prop_assert_eq!(hit, t.is_finite(), "lane {}: {}", lane, t);
        match bounds {
            [Some(a), Some(b)] => {
                let rounding = 2e-6 * t;
                prop_assert!(
                    hit && a.min(b) - rounding <= t && t <= a.max(b) + rounding,
                    "lane {lane} of {v:?} hits it at {t}, not between {a} and {b}"
                );
            }
            [None, None] => prop_assert!(!hit, "lane {lane} of {v:?} hits it at {t}"),
            _ => (),
        }
    }
    Ok(hits)
}

/// Check the hits of a tile of parallel rays, and the points on the faces that they see.
pub(crate) fn check_parallel(shape: &OracleShape, tile: (View, (u32, u32))) -> Result<(), TestCaseError> {
    let across = tile.0.half_pixel.0 * f64::from(SIDE);
    let lengths = shape.size() + across + length(middle_of(tile).origin) * 1e-6;
    // The plane on which the rays start may touch the surface.
    prop_assume!(shape.size() == 0.0 || (shape.center()[2].abs() - shape.size()).abs() > 1e-5 * lengths);
    check_intersection(shape, tile, 2e-6 * lengths)?;
    for (lanes, points) in surface_points(shape, tile) {
        for (i, &lane) in lanes.iter().enumerate() {
            let Ray { origin, direction, .. } = exact_ray(tile.0, tile.1, lane.into());
            let normal = match points.plane {
                Some(plane) => plane.normal,
                None => points.normal.each_ref().map(|axis| f64::from(axis[i])),
            };
            let steep = -dot(normal, direction);
            prop_assert!(steep > -1e-3, "lane {}: {:?} faces away", lane, normal);
            let point = point_of(&points, i);
            let [x, y, _] = sub(point, origin);
            let rounding = 4e-6 * (lengths + length(sub(point, origin)) * 1e-3) / steep.max(1e-6);
            prop_assert!(x.abs() + y.abs() < rounding, "lane {}: {:?} off the ray", lane, [x, y]);
            let off = shape.distance(point);
            prop_assert!(off < rounding, "lane {}: {} off the surface", lane, off);
            // The normal points out of the shape, or into it where the ray starts inside.
            let inside = shape.contact(origin).side == Side::Inside;
            let step = 1e-3 * shape.size() * if inside { -1.0 } else { 1.0 };
            let beyond = shape.contact(add(point, scale(normal, step))).side;
            let is_plane = shape.size() == 0.0;
            prop_assert!(is_plane || steep < 0.1 || beyond == Side::Outside, "lane {}: {:?}", lane, normal);
        }
    }
    Ok(())
}

/// The first face number in tests.
pub(crate) const FACE: u32 = 5 << FACE_BITS;

/// The points where rays of a tile hit the faces of a shape: the lanes and points of each face.
pub(crate) fn surface_points(shape: &OracleShape, (view, corner): (View, (u32, u32))) -> Vec<(Vec<u8>, Points)> {
    let rays = rays_of(view, corner);
    let shapes = shape.to_kernel();
    let shape = shapes.get(0);
    let mut hits = HitBuffer::new();
    shape.intersect(FACE, &rays, &mut hits);
    let mut faces: Vec<u32> = hits.face.iter().copied().filter(|&face| face != NO_FACE).collect();
    faces.sort_unstable();
    faces.dedup();
    faces
        .into_iter()
        .map(|face| {
            let lanes: Vec<u8> = (0..=255).filter(|&lane| hits.face[usize::from(lane)] == face).collect();
            let depths = lanes.iter().map(|&lane| hits.t[usize::from(lane)]);
            let t = depths.fold(f32::INFINITY, f32::min);
            let mut some = Rays::new();
            some.pick(&rays, &lanes);
            let mut points = Points::new();
            let first = || exact_ray(view, corner, hits.lane(face, t));
            shape.compute_points(face, &some, (f64::from(t), first), &mut points);
            (lanes, points)
        })
        .collect()
}

/// Return the irradiance that an occluder leaves of 1 at each point.
pub(crate) fn irradiance_left(occluder: &OracleShape, light: impl Into<Apex>, points: &Points) -> Lanes {
    let light = light.into();
    let mut left = [1.0; LANES];
    let mut squared = [0.0; LANES];
    let to_light = light.way_from_f32(points.reference);
    for lane in 0..points.padded() {
        let [x, y, z] = match light.is_direction() {
            true => points.toward::<true>(to_light, lane),
            false => points.toward::<false>(to_light, lane),
        };
        squared[lane] = x * x + y * y + z * z;
    }
    let contact = (!light.is_direction()).then(|| occluder.contact(light.at));
    let contact = contact.filter(|contact| contact.side == Side::On);
    let shadow =
        &mut ShadowRays { points, light, squared: &squared, irradiance: &mut left, bounds: points.bounds() };
    occluder.to_kernel().get(0).occlude(contact.as_ref(), shadow);
    left
}

/// Check the irradiance that an occluder leaves of 1 at all points.
pub(crate) fn assert_all_lit(occluder: &OracleShape, light: impl Into<Apex>, points: &Points, expected: f32) {
    let light = light.into();
    let left = irradiance_left(occluder, light, points);
    assert!(left[..points.count].iter().all(|&left| left == expected), "{occluder:?} {light:?}");
}

/// Check the points that a shape hides from a light, allowing its surface an error in proportion to the lengths
/// involved. Points and lights within that error of the surface are not checked.
pub(crate) fn check_occlusion(
    occluder: &OracleShape,
    light: impl Into<Apex>,
    points: &Points,
) -> Result<(), TestCaseError> {
    let light = light.into();
    let lengths = [
        occluder.size(),
        length(sub(occluder.center(), points.reference)),
        light.weight * length(light.way_from(points.reference)),
        length(sub(points.bounds().center, points.reference)) + points.bounds().radius,
    ];
    let error = 4e-6 * lengths.iter().sum::<f64>();
    let left = irradiance_left(occluder, light, points);
    let (large, small) = (occluder.swollen(error), occluder.swollen(-error));
    for lane in 0..points.count {
        let point = point_of(points, lane);
        // The corners of a box move farther than its faces.
        let close = |place: Vector| occluder.distance(place) < 2.0 * error;
        if close(point) || (!light.is_direction() && close(light.at)) {
            continue;
        }
        if large.stands_between(light, point) && small.stands_between(light, point) {
            prop_assert_eq!(left[lane], 0.0, "hidden: {:?} from {:?}", point, light);
        } else if !large.stands_between(light, point) && !small.stands_between(light, point) {
            prop_assert_eq!(left[lane], 1.0, "seen: {:?} from {:?}", point, light);
        }
    }
    Ok(())
}

/// A small world of all kinds of objects and lights, from any viewpoint.
pub(crate) fn any_world() -> impl Strategy<Value = World> {
    let objects = prop::collection::vec(any_object(), 0..8);
    let squares = (0.05..3.0, any_color());
    (any_camera(), objects, any_settings(), squares).prop_flat_map(|(camera, objects, settings, (size, color))| {
        let checkers: Vec<_> =
            (0..objects.len()).step_by(2).map(|object| CheckerDesc { object, size, color }).collect();
        let lights = prop::collection::vec(any_light(objects.clone()), 0..4);
        lights.prop_map(move |lights| World {
            camera: camera.clone(),
            checkers: checkers.clone(),
            objects: objects.clone(),
            lights,
            settings: settings.clone(),
        })
    })
}

fn any_place(size: f64) -> impl Strategy<Value = Vector> {
    let axis = move || -size..size;
    [axis(), axis(), axis()]
}

fn any_color() -> impl Strategy<Value = Vector> {
    let channel = || 0.0..1.0;
    [channel(), channel(), channel()]
}

fn any_camera() -> impl Strategy<Value = Camera> {
    let size = (1_u32..70, 1_u32..50);
    // A principal point in the picture or outside.
    let lens = (5.0..120.0, 0.5..2.0, (-1.0..1.0, -1.0..1.0), prop::bool::weighted(0.3));
    (size, lens, any_place(1.0), any_direction(), any_axes()).prop_map(
        |((width, height), (fov, pixel_aspect, (x, y), is_orthographic), aside, toward, axes)| {
            // Mostly outside, looking in.
            let [right, up, _] = axes;
            let forward = crate::vector::cross(up, right);
            let position = add(scale(forward, -8.0), add(aside, scale(toward, 0.5)));
            let (projection, half_height, pixel_aspect) = if is_orthographic {
                (Projection::Orthographic, fov / 20.0, 1.0)
            } else {
                (Projection::Perspective, half_tangent(fov), pixel_aspect)
            };
            let center = if is_orthographic { (0.0, 0.0) } else { (x * half_height, y * half_height) };
            Camera { width, height, projection, half_height, pixel_aspect, center, position, right, up, forward }
        },
    )
}

/// Degrees about the three axes, often about the vertical one alone.
fn any_rotation() -> impl Strategy<Value = Vector> {
    let angle = || -180.0..180.0;
    prop_oneof![angle().prop_map(|y| [0.0, y, 0.0]), [angle(), angle(), angle()]]
}

fn any_object() -> impl Strategy<Value = Object> {
    let size = || 0.1..3.0;
    let shape = prop_oneof![
        3 => size().prop_map(|radius| ShapeDesc::Sphere(SphereDesc { radius })),
        3 => ([size(), size(), size()], any_rotation())
            .prop_map(|(size, rotation)| ShapeDesc::Cuboid(CuboidDesc { size, rotation })),
        1 => any_direction().prop_map(|normal| ShapeDesc::Plane(PlaneDesc { normal })),
        1 => (size(), size(), any_direction())
            .prop_map(|(radius, height, axis)| ShapeDesc::Cylinder(CylinderDesc { radius, height, axis })),
        1 => (size(), size(), any_direction())
            .prop_map(|(radius, height, axis)| ShapeDesc::Capsule(CapsuleDesc { radius, height, axis })),
        2 => (size(), prop_oneof![Just(0.0), size()], size(), any_direction()).prop_map(
            |(radius, top_radius, height, axis)| ShapeDesc::Cone(ConeDesc { radius, top_radius, height, axis })
        ),
    ];
    (any_place(3.0), any_color(), shape).prop_map(|(position, color, shape)| Object { position, color, shape })
}

/// A light, free or carried by a solid.
fn any_light(objects: Vec<Object>) -> impl Strategy<Value = LightDesc> {
    let radius = prop_oneof![Just(0.0), 0.01..2.0];
    (any_place(6.0), any_color(), 1.0..1000.0, radius, any::<prop::sample::Index>()).prop_map(
        move |(position, color, intensity, radius, index)| {
            // As many are free as are carried.
            let number = index.index(2 * objects.len() + 1);
            let carrier = objects.get(number).filter(|object| !matches!(object.shape, ShapeDesc::Plane(_)));
            let source = match carrier {
                Some(object) => LightSource::Point { position: object.position, radius },
                // Free lights are suns as often as not.
                None if number % 2 == 0 => LightSource::Sun { direction: position, angle: 30.0 * radius },
                None => LightSource::Point { position, radius },
            };
            LightDesc { source, color, intensity, carrier: carrier.map(|_| number) }
        },
    )
}

fn any_settings() -> impl Strategy<Value = Settings> {
    let lit = (prop::bool::weighted(0.9), 1_u32..20);
    (1_u32..5, any_color(), any_color(), lit, any::<bool>()).prop_map(
        |(samples, background, ambient, (direct_light, shadow_samples), eye_falloff)| Settings {
            samples,
            background,
            ambient,
            direct_light,
            shadow_samples,
            eye_falloff,
        },
    )
}
