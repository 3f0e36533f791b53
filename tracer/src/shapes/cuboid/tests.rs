use super::*;
use crate::apex::Apex;
use crate::oracle::*;
use crate::shapes::points::Points;
use crate::tile::hits::NO_FACE;
use crate::tile::{SIDE, View};
use crate::vector::{add, dot, normalized};
use proptest::prelude::*;

const STRAIGHT: [Vector; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn brick(center: Vector, half: Vector) -> OracleShape {
    OracleShape::Box { center, axes: STRAIGHT, half }
}

/// A tile and a box whose outline it is likely to see; or the eye is inside.
fn tile_and_box(distances: std::ops::Range<f64>) -> impl Strategy<Value = ((View, (u32, u32)), OracleShape)> {
    any_tile()
        .prop_flat_map(move |tile| (Just(tile), shape_before(tile, distances.clone())))
        .prop_filter("a box", |(_, shape)| matches!(shape, OracleShape::Box { .. }))
        .prop_filter("the eye is not on it", |(_, shape)| shape.distance([0.0; 3]) > 1e-5 * shape.size())
}

/// The tile in the middle of a picture whose middle ray runs along z.
fn straight(half_pixel: f64) -> (View, (u32, u32)) {
    let view = View::centered(16, 16, half_pixel);
    (view, (0, 0))
}

proptest! {
    #[test]
    fn rays_meet_a_box_where_float64_says((tile, shape) in tile_and_box(-1.0..5.0)) {
        let across = length(shape.center()) * tile.0.half_pixel.0 * f64::from(SIDE);
        check_intersection(&shape, tile, 2e-6 * (shape.size() + across))?;
    }

    #[test]
    fn parallel_rays_meet_a_box_where_float64_says(
        (tile, shape) in any_parallel_tile()
            .prop_flat_map(|tile| (Just(tile), shape_before(tile, -1.0..5.0)))
            .prop_filter("a box", |(_, shape)| matches!(shape, OracleShape::Box { .. }))
    ) {
        check_parallel(&shape, tile)?;
    }

    #[test]
    fn points_lie_on_the_box_and_on_their_rays((tile, shape) in tile_and_box(-1.0..5.0)) {
        for (lanes, points) in surface_points(&shape, tile) {
            let plane = points.plane.unwrap();
            prop_assert!(plane.height([0.0; 3]) >= 0.0);
            for (i, &lane) in lanes.iter().enumerate() {
                let point = point_of(&points, i);
                let v = exact_ray(tile.0, tile.1, lane.into()).direction;
                let v = scale(v, 1.0 / length(v));
                let across = length(shape.center()) * tile.0.half_pixel.0 * f64::from(SIDE);
                let rounding = 4e-6 * (shape.size() + across);
                // A ray along the face meets it anywhere: then only the plane of the face is sure.
                prop_assert!(plane.height(point).abs() < rounding, "lane {}: {}", lane, plane.height(point));
                let steep = dot(plane.normal, v).abs();
                let beside = length(cross(v, point));
                prop_assert!(beside < rounding / steep.max(1e-6), "lane {}: {} off the ray", lane, beside);
                let off = shape.distance(point);
                prop_assert!(off < rounding / steep.max(1e-6), "lane {}: {} off the box", lane, off);
            }
        }
    }

    #[test]
    fn a_box_hides_what_float64_says(
        (tile, receiver, light, center) in any_tile().prop_flat_map(|tile| {
            (Just(tile), shape_before(tile, -1.0..3.0), any_direction(), any_direction())
        }),
        axes in any_axes(),
        half in [0.1..1.0, 0.1..1.0, 0.1..1.0],
        distances in (any_size(-1.5..1.5), any_size(-1.5..1.5), any_size(-2.0..1.0)),
        light_inside in prop::bool::weighted(0.1),
    ) {
        for (_, points) in surface_points(&receiver, tile) {
            // In the size of what the tile sees.
            let size = points.bounds().radius;
            let half = half.map(|half| half * distances.2 * size);
            let middle = points.bounds().center;
            let position = add(middle, scale(center, distances.0 * size));
            let toward = if light_inside { add(position, scale(light, 0.05 * distances.2 * size)) } else {
                add(position, scale(sub(add(position, scale(light, half[0])), middle), distances.1))
            };
            let occluder = OracleShape::Box { center: position, axes, half };
            check_occlusion(&occluder, toward, &points)?;
            check_occlusion(&occluder, Apex::direction(normalized(sub(toward, middle))), &points)?;
        }
    }

    /// However the camera turns, which rounds positions differently.
    #[test]
    fn a_light_on_a_box_lights_what_is_above_it_and_not_what_is_below(axes in any_axes(), edge in any::<bool>()) {
        // Rows and columns of a turn are each other's turn back.
        let center = rotate(&axes, [0.0, 0.5, 0.0]);
        let directions = STRAIGHT.map(|axis| rotate(&axes, axis));
        let carrier = OracleShape::Box { center, axes: directions, half: [0.4, 0.5, 0.6] };
        let light = rotate(&axes, [if edge { 0.4 } else { 0.1 }, 1.0, 0.0]);
        let points = points_at(&[[3.0, 1.5, 1.0], [-1.5, -1.0, 0.2]].map(|p| rotate(&axes, p)));
        let left = irradiance_left(&carrier, light, &points);
        prop_assert_eq!(&left[..2], &[1.0, 0.0]);
    }
}

fn points_at(positions: &[Vector]) -> Points {
    let mut points = Points::new();
    points.count = positions.len();
    for (i, position) in positions.iter().enumerate() {
        (0..3).for_each(|axis| points.offset[axis][i] = position[axis] as f32);
    }
    points
}

#[test]
fn each_face_has_a_number_and_a_normal_that_faces_the_eye() {
    let outside = [
        ([3.0, 0.0, 0.0], 1, [-1.0, 0.0, 0.0]),
        ([-3.0, 0.0, 0.0], 0, [1.0, 0.0, 0.0]),
        ([0.0, 3.0, 0.0], 3, [0.0, -1.0, 0.0]),
        ([0.0, -3.0, 0.0], 2, [0.0, 1.0, 0.0]),
        ([0.0, 0.0, 3.0], 5, [0.0, 0.0, -1.0]),
    ];
    for (center, number, normal) in outside {
        // Rays toward the box, which lies anywhere around the eye: its axes are turned instead of the camera.
        let forward = scale(center, 1.0 / 3.0);
        let side = if forward[1] == 0.0 { [0.0, 1.0, 0.0] } else { [1.0, 0.0, 0.0] };
        let camera = [cross(side, forward), side, forward];
        let axes = STRAIGHT.map(|axis| rotate(&camera, axis));
        let cuboid = Cuboid { center: rotate(&camera, center), axes, half: [1.0; 3], eye: scale(center, -1.0) };
        let (view, corner) = straight(1e-4);
        let mut hits = HitBuffer::new();
        cuboid.intersect(FACE, &rays_of(view, corner), &mut hits);
        // An even number: it is seen from outside.
        let number = 2 * number;
        assert!(hits.face.iter().all(|&face| face == FACE + number), "{center:?}");
        assert!(hits.t.iter().all(|&t| t == 2.0), "{center:?}");
        let plane = cuboid.face(FACE + number);
        assert_eq!(plane.normal, rotate(&camera, normal), "{center:?}");
        assert_eq!(plane.offset, -2.0, "{center:?}");
    }
}

#[test]
fn from_inside_each_face_looks_inward() {
    let cuboid = Cuboid { center: [0.0; 3], axes: STRAIGHT, half: [1.0, 2.0, 3.0], eye: [0.0; 3] };
    let (view, corner) = straight(1e-4);
    let mut hits = HitBuffer::new();
    cuboid.intersect(FACE, &rays_of(view, corner), &mut hits);
    assert!(hits.t.iter().all(|&t| t == 3.0));
    let plane = cuboid.face(hits.face[0]);
    assert_eq!(plane.normal, [0.0, 0.0, -1.0]);
    assert_eq!(plane.offset, -3.0);
}

#[test]
fn a_box_behind_the_eye_is_not_seen() {
    let (view, corner) = straight(1e-2);
    let mut hits = HitBuffer::new();
    brick([0.0, 0.0, -3.0], [1.0; 3]).to_kernel().get(0).intersect(FACE, &rays_of(view, corner), &mut hits);
    assert!(hits.face.iter().all(|&face| face == NO_FACE));
}

/// A ray exactly along two pairs of faces has 0 in its direction there.
#[test]
fn a_ray_along_the_faces_is_between_them_or_not() {
    let view = View::centered(15, 15, 0.25);
    let middle = 7 * SIDE as usize + 7;
    assert_eq!(exact_ray(view, (0, 0), middle).direction, [0.0, 0.0, 1.0]);
    for (aside, expected) in [(0.0, 4.0), (0.99, 4.0), (1.01, f32::INFINITY)] {
        for center in [[aside, 0.0, 5.0], [0.0, aside, 5.0], [-aside, aside, 5.0]] {
            let mut hits = HitBuffer::new();
            let rays = rays_of(view, (0, 0));
            brick(center, [1.0; 3]).to_kernel().get(0).intersect(FACE, &rays, &mut hits);
            assert_eq!(hits.t[middle], expected, "{center:?}");
        }
    }
}

#[test]
fn far_away_and_through_a_telescope_the_edges_of_a_box_are_as_straight_as_nearby() {
    let turn = [[0.6, 0.0, 0.8], [0.0, 1.0, 0.0], [-0.8, 0.0, 0.6]];
    let far = OracleShape::Box { center: [0.0, 0.0, 1e5], axes: turn, half: [0.7; 3] };
    let (view, corner) = straight(1.2e-5 / 16.0);
    let mut hits = HitBuffer::new();
    far.to_kernel().get(0).intersect(FACE, &rays_of(view, corner), &mut hits);
    for lane in 0..LANES {
        let expected = far.depth(exact_ray(view, corner, lane)).is_some();
        assert_eq!(hits.face[lane] != NO_FACE, expected, "lane {lane}");
    }
}

/// Points on the top of a unit box on the ground, whose top is in the plane y = 0.
fn points_on_top() -> Points {
    let axes = [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]];
    let top = OracleShape::Box { center: [0.0, 0.0, 3.0], axes, half: [1.0; 3] };
    let (_, points) = surface_points(&top, straight(0.01)).pop().unwrap();
    points
}

fn assert_light(occluder: &OracleShape, light: Vector, expected: f32) {
    assert_all_lit(occluder, light, &points_on_top(), expected);
}

#[test]
fn a_box_between_a_light_and_the_points_hides_it() {
    assert_light(&brick([0.0, 0.0, 0.5], [0.5; 3]), [0.0, 0.0, -2.0], 0.0);
}

#[test]
fn a_box_behind_the_light_or_behind_the_points_hides_nothing() {
    assert_light(&brick([0.0, 0.0, -3.0], [0.5; 3]), [0.0, 0.0, -2.0], 1.0);
    assert_light(&brick([0.0, 0.0, 3.0], [0.5; 3]), [0.0, 0.0, -2.0], 1.0);
}

#[test]
fn a_box_of_any_size_hides_the_sun_behind_it_and_no_other() {
    let along = Apex::direction([0.0, 0.0, -1.0]);
    let aslant = Apex::direction([0.0, 0.6, -0.8]);
    for size in [1.0, 1e20, 1e40, 1e60, 1e100] {
        let far = brick([0.0, 0.0, -10.0 * size], [size; 3]);
        assert_all_lit(&far, along, &points_on_top(), 0.0);
        assert_all_lit(&far, aslant, &points_on_top(), 1.0);
        // A ceiling, and a wall to which the light is parallel.
        let (ceiling, wall) = ([size, size, 0.5], [0.5, size, size]);
        assert_all_lit(&brick([0.0, 0.0, -3.0], ceiling.map(|half| 3.0 * half)), along, &points_on_top(), 0.0);
        assert_all_lit(&brick([3.0, 0.0, 0.0], wall), along, &points_on_top(), 1.0);
    }
}

#[test]
fn a_ceiling_of_any_extent_hides_a_light_above_it_and_none_below() {
    let below = points_at(&[[0.0; 3], [1.0, 2.0, 0.0]]);
    for size in [1e2, 1e20, 1e60, 1e100] {
        let ceiling = brick([0.0, 0.0, -3.0], [size, size, 0.5]);
        for aside in [0.0, 1.0] {
            assert_all_lit(&ceiling, [aside, aside, -9.0], &below, 0.0);
            assert_all_lit(&ceiling, [aside, aside, -2.0], &below, 1.0);
        }
    }
}

#[test]
fn a_light_in_a_box_is_hidden_from_all_outside() {
    assert_light(&brick([0.0, 0.0, -2.0], [0.5; 3]), [0.0, 0.2, -2.1], 0.0);
    assert_light(&brick([0.0, 0.0, 0.0], [50.0; 3]), [0.0, 0.2, -2.1], 1.0);
}

#[test]
fn points_in_a_box_are_hidden_from_a_light_outside() {
    assert_light(&brick([0.0, 0.0, 3.0], [1.5; 3]), [0.0, 0.0, -2.0], 0.0);
}

#[test]
fn a_second_box_with_the_same_top_hides_nothing() {
    assert_light(&brick([0.0, 0.0, 3.0], [1.0; 3]), [0.0, 0.0, -2.0], 1.0);
    assert_light(&brick([0.3, 0.1, 2.7], [0.9, 1.5, 0.7]), [0.2, 0.1, -2.0], 1.0);
    assert_light(&brick([0.3, 0.1, 2.7], [0.9, 1.5, 0.7]), [8.0, 5.0, 1.0], 1.0);
}

#[test]
fn right_angles_are_exact() {
    for (degrees, expected) in [
        (0.0, (0.0, 1.0)),
        (90.0, (1.0, 0.0)),
        (180.0, (0.0, -1.0)),
        (270.0, (-1.0, 0.0)),
        (-90.0, (-1.0, 0.0)),
        (360.0, (0.0, 1.0)),
        (-180.0, (0.0, -1.0)),
        (360e6 + 90.0, (1.0, 0.0)),
    ] {
        assert_eq!(sine_and_cosine(degrees), expected, "of {degrees} degrees");
    }
}

#[test]
fn other_angles_are_those_of_the_mathematics_library() {
    for tenth in -7200..7200 {
        let degrees = f64::from(tenth) / 10.0;
        let (sine, cosine) = sine_and_cosine(degrees);
        assert!((sine - degrees.to_radians().sin()).abs() < 1e-14, "sin of {degrees} degrees");
        assert!((cosine - degrees.to_radians().cos()).abs() < 1e-14, "cos of {degrees} degrees");
    }
}

#[test]
fn the_axes_of_a_box_turn_counter_clockwise_seen_from_above() {
    // From above, x points right and -z up: a quarter turn takes x to -z.
    assert_eq!(box_axes([0.0, 90.0, 0.0]), [[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]);
}

#[test]
fn a_box_turns_about_x_then_y_then_z_of_the_world() {
    // About x, y goes to z and z to -y; about y, z goes to x and x to -z.
    assert_eq!(box_axes([90.0, 90.0, 0.0]), [[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]);
    // About z, x goes to y and y to -x.
    assert_eq!(box_axes([0.0, 90.0, 90.0]), [[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
}
