use super::*;
use crate::apex::Apex;
use crate::oracle::*;
use crate::tile::View;
use crate::tile::hits::NO_FACE;
use crate::vector::add;
use crate::vector::normalized;
use proptest::prelude::*;

fn ball(center: Vector, radius: f64) -> OracleShape {
    OracleShape::Sphere { center, radius }
}

/// A tile and a sphere whose outline it is likely to see; or the eye is inside.
fn tile_and_sphere(distances: std::ops::Range<f64>) -> impl Strategy<Value = ((View, (u32, u32)), Vector, f64)> {
    any_tile().prop_flat_map(move |tile| {
        shape_before(tile, distances.clone()).prop_map(move |shape| (tile, shape.center(), shape.size()))
    })
}

/// The tile in the middle of a picture whose middle ray runs along z.
fn straight(half_pixel: f64) -> (View, (u32, u32)) {
    let view = View::centered(16, 16, half_pixel);
    (view, (0, 0))
}

fn intersect(shape: &OracleShape, tile: (View, (u32, u32))) -> HitBuffer {
    let mut hits = HitBuffer::new();
    shape.to_kernel().get(0).intersect(FACE, &rays_of(tile.0, tile.1), &mut hits);
    hits
}

proptest! {
    #[test]
    fn rays_meet_a_sphere_where_float64_says(
        (tile, center, radius) in tile_and_sphere(-4.0..5.0)
    ) {
        let (view, _) = tile;
        let across = length(center) * view.half_pixel.0 * f64::from(SIDE);
        check_intersection(&ball(center, radius), tile, 1e-6 * (radius + across))?;
    }

    #[test]
    fn parallel_rays_meet_a_sphere_where_float64_says(
        (tile, shape) in any_parallel_tile().prop_flat_map(|tile| (Just(tile), shape_before(tile, -4.0..5.0)))
    ) {
        check_parallel(&ball(shape.center(), shape.size()), tile)?;
    }

    #[test]
    fn points_lie_on_the_sphere_and_on_their_rays((tile, center, radius) in tile_and_sphere(-4.0..5.0)) {
        for (lanes, points) in surface_points(&ball(center, radius), tile) {
            prop_assert!(points.plane.is_none());
            for (i, &lane) in lanes.iter().enumerate() {
                let point = point_of(&points, i);
                let v = exact_ray(tile.0, tile.1, lane.into()).direction;
                let v = scale(v, 1.0 / length(v));
                // From inside points are as exact as the radius, from outside also as their distance.
                let near = if length(center) > radius { radius.min(length(point)) } else { radius };
                let off = ball(center, radius).distance(point);
                prop_assert!(off < 1e-6 * near + 1e-15 * length(center), "lane {}: {} off the sphere", lane, off);
                let beside = length(cross(v, point));
                let across = length(center) * tile.0.half_pixel.0 * f64::from(SIDE);
                // Rays that touch the sphere may just miss it.
                prop_assert!(beside < 1e-6 * (radius + across), "lane {}: {} off the ray", lane, beside);
            }
        }
    }

    #[test]
    fn normals_are_those_of_the_points_and_face_the_eye((tile, center, radius) in tile_and_sphere(-4.0..5.0)) {
        let turn = if length(center) > radius { 1.0 } else { -1.0 };
        for (lanes, points) in surface_points(&ball(center, radius), tile) {
            for i in 0..lanes.len() {
                let normal = points.normal.each_ref().map(|axis| f64::from(axis[i]));
                let outward = sub(point_of(&points, i), center);
                let expected = scale(outward, turn / length(outward));
                prop_assert!(length(sub(normal, expected)) < 3e-6, "{normal:?} is not {expected:?}");
                prop_assert!((length(normal) - 1.0).abs() < 1e-6, "{}", length(normal));
                let v = exact_ray(tile.0, tile.1, lanes[i].into()).direction;
                prop_assert!(dot(normal, v) < 1e-3 * length(v), "{}", dot(normal, v));
            }
        }
    }

    #[test]
    fn a_sphere_hides_what_float64_says(
        (tile, receiver, light, center) in any_tile().prop_flat_map(|tile| {
            (Just(tile), shape_before(tile, -2.0..3.0), any_direction(), any_direction())
        }),
        distances in (any_size(-1.5..1.5), any_size(-1.5..1.5), any_size(-2.0..1.0)),
        light_inside in prop::bool::weighted(0.1),
    ) {
        for (_, points) in surface_points(&receiver, tile) {
            // In the size of what the tile sees.
            let size = points.bounds().radius;
            let radius = distances.2 * size;
            let middle = points.bounds().center;
            let position = add(middle, scale(center, distances.0 * size));
            let toward = if light_inside { add(position, scale(light, radius / 2.0)) } else {
                add(position, scale(sub(add(position, scale(light, radius)), middle), distances.1))
            };
            check_occlusion(&ball(position, radius), toward, &points)?;
            check_occlusion(&ball(position, radius), Apex::direction(normalized(sub(toward, middle))), &points)?;
        }
    }
}

#[test]
fn the_middle_ray_meets_a_sphere_ahead_at_its_distance_less_the_radius() {
    let hits = intersect(&ball([0.0, 0.0, 7.0], 2.0), straight(1e-9));
    assert!(hits.t.iter().all(|&t| t == 5.0));
    assert!(hits.face.iter().all(|&face| face == FACE));
}

#[test]
fn from_inside_the_far_root_counts() {
    let hits = intersect(&ball([0.0, 0.0, 0.5], 2.0), straight(1e-9));
    assert!(hits.t.iter().all(|&t| t == 2.5));
}

#[test]
fn a_sphere_behind_the_eye_is_not_seen() {
    let hits = intersect(&ball([0.0, 0.0, -7.0], 2.0), straight(1e-3));
    assert_eq!(hits.farthest(), f32::INFINITY);
    assert!(hits.face.iter().all(|&face| face == NO_FACE));
}

/// The ground of a planet, seen by a viewer standing on it: a little below the horizon its roots are close to each
/// other.
#[test]
fn the_ground_of_a_planet_is_as_far_as_it_should_be() {
    for height in [1e-2, 1e-4, 1e-6, 1e-7] {
        let planet = ball([0.0, -(1.0 + height), 0.0], 1.0);
        let dip = f64::sqrt(2.0 * height);
        let view = View::centered(16, 1600, 1e-3);
        let row = (((3.0 * dip) / 2e-3) as u32 + 800).next_multiple_of(SIDE);
        let hits = intersect(&planet, (view, (0, row)));
        for lane in 0..LANES {
            let t = planet.depth(exact_ray(view, (0, row), lane)).unwrap();
            let off = (f64::from(hits.t[lane]) / t - 1.0).abs();
            assert!(off < 1e-5, "at the height {height}, lane {lane}: {off}");
        }
    }
}

#[test]
fn far_away_and_through_a_telescope_a_sphere_is_as_round_as_nearby() {
    let telescope = straight(1.2e-5 / 16.0);
    let seen = |shape: &OracleShape| {
        let mut hits = HitBuffer::new();
        shape.to_kernel().get(0).intersect(FACE, &rays_of(telescope.0, telescope.1), &mut hits);
        hits.face
    };
    let sphere = ball([0.0, 0.0, 1e5], 1.0);
    for (lane, &face) in seen(&sphere).iter().enumerate() {
        let expected = sphere.depth(exact_ray(telescope.0, telescope.1, lane)).is_some();
        assert_eq!(face != NO_FACE, expected, "lane {lane}");
    }
}

/// Points on the ground, which is a sphere of radius 1 around the origin, seen from above.
fn points_on_the_ground() -> Points {
    let (_, points) = surface_points(&ball([0.0, 0.0, 3.0], 1.0), straight(0.01)).pop().unwrap();
    points
}

fn assert_light(occluder: &OracleShape, light: Vector, expected: f32) {
    assert_all_lit(occluder, light, &points_on_the_ground(), expected);
}

#[test]
fn a_sphere_between_a_light_and_the_points_hides_it() {
    assert_light(&ball([0.0, 0.0, 1.0], 0.5), [0.0, 0.0, -2.0], 0.0);
}

#[test]
fn a_sphere_behind_the_light_or_behind_the_points_hides_nothing() {
    assert_light(&ball([0.0, 0.0, -3.0], 0.5), [0.0, 0.0, -2.0], 1.0);
    assert_light(&ball([0.0, 0.0, 3.0], 0.5), [0.0, 0.0, -2.0], 1.0);
}

#[test]
fn a_light_in_a_sphere_is_hidden_from_all_outside() {
    assert_light(&ball([0.0, 0.0, -2.0], 0.5), [0.0, 0.2, -2.1], 0.0);
    assert_light(&ball([0.0, 0.0, 0.0], 50.0), [0.0, 0.2, -2.1], 1.0);
}

#[test]
fn points_in_a_sphere_are_hidden_from_a_light_outside() {
    assert_light(&ball([0.0, 0.0, 3.0], 1.5), [0.0, 0.0, -2.0], 0.0);
}

#[test]
fn a_second_sphere_in_the_same_place_hides_nothing() {
    assert_light(&ball([0.0, 0.0, 3.0], 1.0), [0.0, 0.0, -2.0], 1.0);
}

#[test]
fn a_sphere_of_any_size_hides_the_sun_behind_it_and_no_other() {
    for size in [1.0, 1e20, 1e40, 1e60, 1e100] {
        let far = ball([0.0, 0.0, -10.0 * size], size);
        let hidden = |toward| 1.0 - irradiance_left(&far, Apex::direction(toward), &points_on_the_ground())[0];
        assert_eq!(hidden([0.0, 0.0, -1.0]), 1.0, "{size}");
        assert_eq!(hidden([0.0, 0.6, -0.8]), 0.0, "{size}");
        assert_eq!(hidden([0.0, 0.0, 1.0]), 0.0, "{size}");
    }
}

proptest! {
    /// The ground of a planet is not in the sky above somebody who stands on it.
    #[test]
    fn the_sphere_under_the_eye_is_not_seen_above(down in any_direction(), height in any_size(-12.0..-1.0)) {
        let down = [down[0], down[1], -down[2].abs() - 0.1];
        let down = scale(down, 1.0 / length(down));
        let hits = intersect(&ball(scale(down, 1.0 + height), 1.0), straight(0.001));
        prop_assert_eq!(hits.closest(), f32::INFINITY);
    }

    /// However the camera turns, which rounds positions differently.
    #[test]
    fn a_light_on_a_sphere_lights_what_is_above_it_and_not_what_is_below(axes in any_axes()) {
        let turned_to = |position| turned(&axes, position);
        let carrier = ball(turned_to([0.0, 1.0, 0.0]), 1.0);
        let light = turned_to([0.0, 2.0, 0.0]);
        let mut points = Points::new();
        points.count = 2;
        for (i, position) in [[3.0, 2.5, 1.0], [1.5, -1.0, 0.2]].into_iter().enumerate() {
            let position = turned_to(position);
            (0..3).for_each(|axis| points.offset[axis][i] = position[axis] as f32);
        }
        let left = irradiance_left(&carrier, light, &points);
        prop_assert_eq!(&left[..2], &[1.0, 0.0]);
    }
}

fn turned(axes: &[Vector; 3], position: Vector) -> Vector {
    crate::vector::rotate(axes, position)
}
