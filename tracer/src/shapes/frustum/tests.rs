use super::*;
use crate::oracle::*;
use crate::tile::hits::NO_FACE;
use crate::tile::{SIDE as TILE_SIDE, View};
use crate::vector::normalized;
use proptest::prelude::*;

type Tile = (View, (u32, u32));

/// A tile and a shape round about an axis whose outline it is likely to see; or the eye is inside.
fn tile_and_round(distances: std::ops::Range<f64>) -> impl Strategy<Value = (Tile, OracleShape)> {
    any_tile()
        .prop_flat_map(move |tile| (Just(tile), shape_before(tile, distances.clone())))
        .prop_filter("round", |(_, shape)| is_round(shape))
        .prop_filter("the eye is not on it", |(_, shape)| shape.distance([0.0; 3]) > 1e-5 * shape.size())
}

fn is_round(shape: &OracleShape) -> bool {
    matches!(shape, OracleShape::Frustum { .. } | OracleShape::Capsule { .. })
}

/// What a tile sees of the neighbourhood of a shape.
fn across(shape: &OracleShape, tile: Tile) -> f64 {
    length(shape.center()) * tile.0.half_pixel.0 * f64::from(TILE_SIDE)
}

/// The shape around the origin, of half the height 1, along z.
fn upright(base: f64, top: f64, center: Vector) -> OracleShape {
    OracleShape::Frustum { center, axis: [0.0, 1.0, 0.0], radii: [base, top], half: 1.0 }
}

/// The tile in the middle of a picture whose middle ray runs along z.
fn straight(half_pixel: f64) -> Tile {
    (View::centered(16, 16, half_pixel), (0, 0))
}

fn intersect(shape: &OracleShape, tile: Tile) -> HitBuffer {
    let mut hits = HitBuffer::new();
    shape.to_kernel().get(0).intersect(FACE, &rays_of(tile.0, tile.1), &mut hits);
    hits
}

proptest! {
    #[test]
    fn rays_meet_a_round_shape_where_float64_says((tile, shape) in tile_and_round(-1.0..5.0)) {
        check_intersection(&shape, tile, 2e-6 * (shape.size() + across(&shape, tile)))?;
    }

    #[test]
    fn parallel_rays_meet_a_round_shape_where_float64_says(
        (tile, shape) in any_parallel_tile()
            .prop_flat_map(|tile| (Just(tile), shape_before(tile, -1.0..5.0).prop_filter("round", is_round)))
    ) {
        check_parallel(&shape, tile)?;
    }

    /// Close to the plane on which they start there is no share of the depth to lose.
    #[test]
    fn parallel_rays_meet_a_flat_cone_where_float64_says_however_close_to_where_they_start(
        (corner, pixel) in ((0_u32..2, 0_u32..2), any_size(-2.5..-1.0)),
        (half, radii) in (any_size(-4.0..0.0), (0.1..1.0, prop_oneof![Just(0.0), 0.0..1.0])),
        (axis, aside) in (any_direction(), any_direction()),
        share in 0.0..0.5,
    ) {
        let tile = (View::parallel(32, 32, pixel / 2.0), (corner.0 * TILE_SIDE, corner.1 * TILE_SIDE));
        let center = scale(aside, share);
        let shape = OracleShape::Frustum { center, axis, radii: [1.0, radii.0 * radii.1], half };
        let rays = rays_of(tile.0, tile.1);
        let hits = intersect(&shape, tile);
        let kernel = shape.to_kernel();
        for lane in 0..LANES {
            let (depth, steep) = kernel.get(0).depth(rays.exact(lane));
            // A surface so close to the start, or to the outline, may be missed.
            if depth.is_finite() && steep > 0.05 && depth > 1e-5 * pixel && hits.face[lane] != NO_FACE {
                let apart = (f64::from(hits.t[lane]) - depth).abs();
                let rounding = (1e-5 + 4e-6 / steep) * depth + 5e-6 * pixel / steep;
                prop_assert!(apart < rounding, "lane {}: {} instead of {}", lane, hits.t[lane], depth);
            }
        }
    }

    #[test]
    fn points_lie_on_the_shape_and_on_their_rays((tile, shape) in tile_and_round(-1.0..5.0)) {
        for (lanes, points) in surface_points(&shape, tile) {
            let rounding = 4e-6 * (shape.size() + across(&shape, tile));
            for (i, &lane) in lanes.iter().enumerate() {
                let point = point_of(&points, i);
                let v = exact_ray(tile.0, tile.1, lane.into()).direction;
                let v = scale(v, 1.0 / length(v));
                let normal = points.plane.map_or_else(
                    || points.normal.each_ref().map(|axis| f64::from(axis[i])),
                    |plane| plane.normal,
                );
                prop_assert!((length(normal) - 1.0).abs() < 1e-6, "{}", length(normal));
                let steep = dot(normal, v).abs().max(1e-6);
                let beside = length(cross(v, point));
                prop_assert!(beside < rounding / steep, "lane {}: {} off the ray", lane, beside);
                let off = shape.distance(point);
                prop_assert!(off < rounding / steep, "lane {}: {} off the shape", lane, off);
            }
        }
    }

    /// Outward from the nearest point of the axis, on a cone tilted by the slope of its side.
    #[test]
    fn normals_are_those_of_the_points_and_face_the_eye((tile, shape) in tile_and_round(-1.0..5.0)) {
        let eye_is_outside = shape.contact([0.0; 3]).side == Side::Outside;
        let turn = if eye_is_outside { 1.0 } else { -1.0 };
        for (lanes, points) in surface_points(&shape, tile).into_iter().filter(|(_, points)| points.plane.is_none()) {
            for (i, &lane) in lanes.iter().enumerate() {
                let normal = points.normal.each_ref().map(|axis| f64::from(axis[i]));
                let relative = sub(point_of(&points, i), shape.center());
                let (outward, thick) = match shape {
                    OracleShape::Frustum { axis, radii, half, .. } => {
                        let z = dot(relative, axis);
                        let aside = sub(relative, scale(axis, z));
                        let slope = (radii[1] - radii[0]) / (2.0 * half);
                        (sub(scale(aside, 1.0 / length(aside)), scale(axis, slope)), length(aside))
                    }
                    OracleShape::Capsule { axis, radius, half, .. } => {
                        (sub(relative, scale(axis, dot(relative, axis).clamp(-half, half))), radius)
                    }
                    _ => unreachable!(),
                };
                let expected = scale(outward, turn / length(outward));
                let v = exact_ray(tile.0, tile.1, lane.into()).direction;
                let steep = dot(normal, v).abs() / length(v);
                // Close to the tip of a cone and to the outline a point tells less about its normal.
                let rounding = 4e-6 * (shape.size() + across(&shape, tile)) / (thick * steep.max(1e-3));
                prop_assert!(length(sub(normal, expected)) < rounding, "{normal:?} is not {expected:?}");
                prop_assert!(dot(normal, v) < 1e-3 * length(v), "{}", dot(normal, v));
            }
        }
    }

    #[test]
    fn a_round_shape_hides_what_float64_says(
        (tile, receiver, light, center) in any_tile().prop_flat_map(|tile| {
            (Just(tile), shape_before(tile, -1.0..3.0), any_direction(), any_direction())
        }),
        shape in any_tile().prop_flat_map(|tile| shape_before(tile, 0.0..1.0)).prop_filter("round", is_round),
        distances in (any_size(-1.5..1.5), any_size(-1.5..1.5), any_size(-2.0..1.0)),
        light_inside in prop::bool::weighted(0.1),
    ) {
        for (_, points) in surface_points(&receiver, tile) {
            // In the size of what the tile sees.
            let size = points.bounds().radius;
            let middle = points.bounds().center;
            let by = distances.2 * size / shape.size();
            let position = add(middle, scale(center, distances.0 * size));
            let occluder = match shape {
                OracleShape::Frustum { axis, radii, half, .. } => {
                    let radii = radii.map(|radius| radius * by);
                    OracleShape::Frustum { center: position, axis, radii, half: half * by }
                }
                OracleShape::Capsule { axis, radius, half, .. } => {
                    OracleShape::Capsule { center: position, axis, radius: radius * by, half: half * by }
                }
                _ => unreachable!(),
            };
            let size = occluder.size();
            let toward = if light_inside { add(position, scale(light, 0.02 * size)) } else {
                add(position, scale(sub(add(position, scale(light, size)), middle), distances.1))
            };
            check_occlusion(&occluder, toward, &points)?;
            check_occlusion(&occluder, Apex::direction(normalized(sub(toward, middle))), &points)?;
        }
    }
}

#[test]
fn the_faces_are_the_side_and_the_discs() {
    let seen = |center: Vector| {
        let hits = intersect(&upright(1.0, 2.0, center), straight(1e-9));
        assert!(hits.face.iter().all(|&face| face == hits.face[0]));
        (hits.face[0] - FACE, hits.t[0])
    };
    assert_eq!(seen([0.0, 0.0, 5.0]), (SIDE, 3.5));
    // Along the axis, from below and from above.
    let along = |sign: f64| {
        let shape =
            OracleShape::Frustum { center: [0.0, 0.0, 5.0], axis: [0.0, 0.0, sign], radii: [1.0, 2.0], half: 1.0 };
        let hits = intersect(&shape, straight(1e-9));
        assert!(hits.face.iter().all(|&face| face == hits.face[0]));
        assert!(hits.t.iter().all(|&t| t == 4.0));
        hits.face[0] - FACE
    };
    assert_eq!([along(1.0), along(-1.0)], [BASE, TOP]);
}

#[test]
fn of_a_double_cone_only_the_half_with_the_discs_is_seen() {
    // The tip is 1 above the middle, and the eye looks over it.
    let hits = intersect(&upright(1.0, 0.0, [0.0, -1.5, 5.0]), straight(1e-3));
    assert!(hits.face.iter().all(|&face| face == NO_FACE));
    // The eye is above the tip, inside the other half, and looks down.
    let below =
        OracleShape::Frustum { center: [0.0, 0.0, 4.0], axis: [0.0, 0.0, -1.0], radii: [1.0, 0.0], half: 1.0 };
    let hits = intersect(&below, straight(1e-9));
    assert!(hits.face.iter().all(|&face| face == FACE + SIDE));
    assert!(hits.t.iter().all(|&t| (t - 3.0).abs() < 1e-6), "{:?}", hits.t);
}

#[test]
fn the_tip_has_a_normal_that_faces_the_eye() {
    let cone = Frustum::new([0.0, -1.0, 4.0], [0.0, 1.0, 0.0], Profile::new(1.0, 0.0, 2.0), None);
    let mut rays = Rays::new();
    let tile = straight(1e-3);
    rays.pick(&rays_of(tile.0, tile.1), &[0]);
    (rays.dx[0], rays.dy[0], rays.x[0], rays.y[0], rays.vv[0]) = (0.0, 0.0, 0.0, 0.0, 1.0);
    let mut points = Points::new();
    points.start(1, cone.magnitude());
    cone.compute_points(
        FACE + SIDE,
        &rays,
        (4.0, || Ray { origin: [0.0; 3], direction: [0.0, 0.0, 1.0], start: 0.0 }),
        &mut points,
    );
    assert_eq!(points.normal.each_ref().map(|axis| axis[0]), [0.0, 0.0, -1.0]);
}

#[test]
fn bounds_are_the_smallest_sphere() {
    let ball = |base: f64, top: f64, height: f64| {
        let frustum = Frustum::new([0.0; 3], [0.0, 1.0, 0.0], Profile::new(base, top, height), None);
        let ball = frustum.bounds().unwrap();
        (ball.center[1], ball.radius)
    };
    assert_eq!(ball(3.0, 3.0, 8.0), (0.0, 5.0));
    // Around a flat cone is the sphere around its base.
    assert_eq!(ball(3.0, 0.0, 1.0), (-0.5, 3.0));
    let (center, radius) = ball(1.0, 0.0, 4.0);
    assert_eq!(radius, 2.0 - center);
    assert!(((2.0 + center).hypot(1.0) - radius).abs() < 1e-12);
}

/// The axis as a camera rounds it, turned by angles that leave it some rounding along all axes.
#[test]
fn a_huge_cylinder_hides_a_sun_along_its_axis() {
    let mut points = Points::new();
    points.count = 1;
    for size in [1.0, 1e9, 1e15, 1e18] {
        for turn in 1..100 {
            let (sine, cosine) = (libm::sin(f64::from(turn)), libm::cos(f64::from(turn)));
            let axis = normalized([sine, cosine, 0.3 * sine * cosine]);
            let center = scale(axis, 4.0 * size);
            let column = OracleShape::Frustum { center, axis, radii: [size; 2], half: size };
            let toward = normalized(add(scale(axis, 7.0), scale(perpendicular(axis), 1e-15)));
            assert_all_lit(&column, Apex::direction(toward), &points, 0.0);
        }
    }
}
