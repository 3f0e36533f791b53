use super::*;
use crate::grid::NOTHING;
use crate::oracle::*;
use crate::place::View;
use crate::vector::add;
use proptest::prelude::*;

fn ball(center: Vector, radius: f64) -> Solid {
    Solid::Ball { center, radius }
}

/// A block and a sphere whose outline it is likely to see; or the eye is inside.
fn block_and_ball(distances: std::ops::Range<f64>) -> impl Strategy<Value = ((View, (u32, u32)), Vector, f64)> {
    any_block().prop_flat_map(move |block| {
        solid_before(block, distances.clone()).prop_map(move |solid| (block, solid.center(), solid.size()))
    })
}

/// The block in the middle of a picture whose middle ray runs along z.
fn straight(half_pixel: f64) -> (View, (u32, u32)) {
    let view = View {
        width: 16,
        height: 16,
        half_pixel: (half_pixel, half_pixel),
    };
    (view, (0, 0))
}

fn meet(solid: &Solid, block: (View, (u32, u32))) -> Nearest {
    let mut nearest = Nearest::new();
    solid.shape().meet(FACE, &rays_of(block.0, block.1), &mut nearest);
    nearest
}

proptest! {
    #[test]
    fn rays_meet_a_sphere_where_float64_says(
        (block, center, radius) in block_and_ball(-4.0..5.0)
    ) {
        let (view, _) = block;
        let across = length(center) * view.half_pixel.0 * f64::from(SIDE);
        check_meeting(&ball(center, radius), block, 1e-6 * (radius + across))?;
    }

    #[test]
    fn points_lie_on_the_sphere_and_on_their_rays((block, center, radius) in block_and_ball(-4.0..5.0)) {
        for (lanes, points, plane) in placed(&ball(center, radius), block) {
            prop_assert!(plane.is_none());
            for (i, &lane) in lanes.iter().enumerate() {
                let point = point_of(&points, i);
                let v = exact_ray(block.0, block.1, lane.into());
                let v = scale(v, 1.0 / length(v));
                // From inside points are as exact as the radius, from outside also as their distance.
                let near = if length(center) > radius { radius.min(length(point)) } else { radius };
                let off = ball(center, radius).distance(point);
                prop_assert!(off < 1e-6 * near + 1e-15 * length(center), "lane {}: {} off the sphere", lane, off);
                let beside = length(cross(v, point));
                let across = length(center) * block.0.half_pixel.0 * f64::from(SIDE);
                // Rays that touch the sphere may just miss it.
                prop_assert!(beside < 1e-6 * (radius + across), "lane {}: {} off the ray", lane, beside);
            }
        }
    }

    #[test]
    fn normals_are_those_of_the_points_and_face_the_eye((block, center, radius) in block_and_ball(-4.0..5.0)) {
        let turn = if length(center) > radius { 1.0 } else { -1.0 };
        for (lanes, points, _) in placed(&ball(center, radius), block) {
            for i in 0..lanes.len() {
                let normal = points.normal.each_ref().map(|axis| f64::from(axis[i]));
                let outward = sub(point_of(&points, i), center);
                let expected = scale(outward, turn / length(outward));
                prop_assert!(length(sub(normal, expected)) < 3e-6, "{normal:?} is not {expected:?}");
                prop_assert!((length(normal) - 1.0).abs() < 1e-6, "{}", length(normal));
                let v = exact_ray(block.0, block.1, lanes[i].into());
                prop_assert!(dot(normal, v) < 1e-3 * length(v), "{}", dot(normal, v));
            }
        }
    }

    #[test]
    fn a_sphere_hides_what_float64_says(
        (block, receiver, lamp, center) in any_block().prop_flat_map(|block| {
            (Just(block), solid_before(block, -2.0..3.0), any_direction(), any_direction())
        }),
        distances in (any_size(-1.5..1.5), any_size(-1.5..1.5), any_size(-2.0..1.0)),
        lamp_inside in prop::bool::weighted(0.1),
    ) {
        for (_, points, _) in placed(&receiver, block) {
            // In the size of what the block sees.
            let size = points.bound().radius;
            let radius = distances.2 * size;
            let middle = points.bound().center;
            let place = add(middle, scale(center, distances.0 * size));
            let toward = if lamp_inside { add(place, scale(lamp, radius / 2.0)) } else {
                add(place, scale(sub(add(place, scale(lamp, radius)), middle), distances.1))
            };
            check_hiding(&ball(place, radius), toward, &points)?;
        }
    }
}

#[test]
fn the_middle_ray_meets_a_sphere_ahead_at_its_distance_less_the_radius() {
    let nearest = meet(&ball([0.0, 0.0, 7.0], 2.0), straight(1e-9));
    assert!(nearest.t.iter().all(|&t| t == 5.0));
    assert!(nearest.face.iter().all(|&face| face == FACE));
}

#[test]
fn from_inside_the_far_root_counts() {
    let nearest = meet(&ball([0.0, 0.0, 0.5], 2.0), straight(1e-9));
    assert!(nearest.t.iter().all(|&t| t == 2.5));
}

#[test]
fn a_sphere_behind_the_eye_is_not_seen() {
    let nearest = meet(&ball([0.0, 0.0, -7.0], 2.0), straight(1e-3));
    assert_eq!(nearest.farthest(), f32::INFINITY);
    assert!(nearest.face.iter().all(|&face| face == NOTHING));
}

/// The ground of a planet as somebody sees it who stands on it: a little below the horizon its roots are close to each
/// other.
#[test]
fn the_ground_of_a_planet_is_as_far_as_it_should_be() {
    for height in [1e-2, 1e-4, 1e-6, 1e-7] {
        let planet = ball([0.0, -(1.0 + height), 0.0], 1.0);
        let dip = f64::sqrt(2.0 * height);
        let view = View {
            width: 16,
            height: 1600,
            half_pixel: (1e-3, 1e-3),
        };
        let row = (((3.0 * dip) / 2e-3) as u32 + 800).next_multiple_of(SIDE);
        let nearest = meet(&planet, (view, (0, row)));
        for lane in 0..LANES {
            let t = planet.depth(exact_ray(view, (0, row), lane)).unwrap();
            let off = (f64::from(nearest.t[lane]) / t - 1.0).abs();
            assert!(off < 1e-5, "at the height {height}, lane {lane}: {off}");
        }
    }
}

#[test]
fn far_away_and_through_a_telescope_a_sphere_is_as_round_as_nearby() {
    let telescope = straight(1.2e-5 / 16.0);
    let seen = |solid: &Solid| {
        let mut nearest = Nearest::new();
        solid
            .shape()
            .meet(FACE, &rays_of(telescope.0, telescope.1), &mut nearest);
        nearest.face
    };
    let sphere = ball([0.0, 0.0, 1e5], 1.0);
    for (lane, &face) in seen(&sphere).iter().enumerate() {
        let expected = sphere.depth(exact_ray(telescope.0, telescope.1, lane)).is_some();
        assert_eq!(face != NOTHING, expected, "lane {lane}");
    }
}

/// Points on the ground, which is a sphere of radius 1 around the origin, seen from above.
fn points_on_the_ground() -> Points {
    let (_, points, _) = placed(&ball([0.0, 0.0, 3.0], 1.0), straight(0.01)).pop().unwrap();
    points
}

fn assert_light(occluder: &Solid, lamp: Vector, expected: f32) {
    assert_all_lit(occluder, lamp, &points_on_the_ground(), expected);
}

#[test]
fn a_sphere_between_a_lamp_and_the_points_hides_it() {
    assert_light(&ball([0.0, 0.0, 1.0], 0.5), [0.0, 0.0, -2.0], 0.0);
}

#[test]
fn a_sphere_behind_the_lamp_or_behind_the_points_hides_nothing() {
    assert_light(&ball([0.0, 0.0, -3.0], 0.5), [0.0, 0.0, -2.0], 1.0);
    assert_light(&ball([0.0, 0.0, 3.0], 0.5), [0.0, 0.0, -2.0], 1.0);
}

#[test]
fn a_lamp_in_a_sphere_is_hidden_from_all_outside() {
    assert_light(&ball([0.0, 0.0, -2.0], 0.5), [0.0, 0.2, -2.1], 0.0);
    assert_light(&ball([0.0, 0.0, 0.0], 50.0), [0.0, 0.2, -2.1], 1.0);
}

#[test]
fn points_in_a_sphere_are_hidden_from_a_lamp_outside() {
    assert_light(&ball([0.0, 0.0, 3.0], 1.5), [0.0, 0.0, -2.0], 0.0);
}

#[test]
fn a_second_sphere_in_the_same_place_hides_nothing() {
    assert_light(&ball([0.0, 0.0, 3.0], 1.0), [0.0, 0.0, -2.0], 1.0);
}

proptest! {
    /// The ground of a planet is not in the sky above somebody who stands on it.
    #[test]
    fn the_sphere_under_the_eye_is_not_seen_above(down in any_direction(), height in any_size(-12.0..-1.0)) {
        let down = [down[0], down[1], -down[2].abs() - 0.1];
        let down = scale(down, 1.0 / length(down));
        let nearest = meet(&ball(scale(down, 1.0 + height), 1.0), straight(0.001));
        prop_assert_eq!(nearest.closest(), f32::INFINITY);
    }

    /// However the camera turns, which rounds places differently.
    #[test]
    fn a_lamp_on_a_sphere_lights_what_is_above_it_and_not_what_is_below(axes in any_axes()) {
        let turned_to = |place| turned_place(&axes, place);
        let carrier = ball(turned_to([0.0, 1.0, 0.0]), 1.0);
        let lamp = turned_to([0.0, 2.0, 0.0]);
        let mut points = Points::new();
        points.count = 2;
        for (i, place) in [[3.0, 2.5, 1.0], [1.5, -1.0, 0.2]].into_iter().enumerate() {
            let place = turned_to(place);
            (0..3).for_each(|axis| points.offset[axis][i] = place[axis] as f32);
        }
        let light = light_left(&carrier, lamp, &points);
        prop_assert_eq!(&light[..2], &[1.0, 0.0]);
    }
}

fn turned_place(axes: &[Vector; 3], place: Vector) -> Vector {
    crate::vector::turned(axes, place)
}
