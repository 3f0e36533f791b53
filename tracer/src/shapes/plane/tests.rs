use super::*;
use crate::apex::Apex;
use crate::oracle::*;
use crate::tile::hits::NO_FACE;
use crate::tile::{SIDE, View};
use crate::vector::normalized;
use crate::vector::{add, cross, length, rotate, sub};
use proptest::prelude::*;

proptest! {
    #[test]
    fn rays_meet_a_plane_where_float64_says(tile in any_tile(), wall in any_plane()) {
        let (view, corner) = tile;
        let OracleShape::Plane { normal, offset } = wall else { unreachable!() };
        let mut hits = HitBuffer::new();
        wall.to_kernel().get(0).intersect(FACE, &rays_of(view, corner), &mut hits);
        for lane in 0..LANES {
            let v = exact_ray(view, corner, lane).direction;
            let steep = dot(normal, v) / length(v);
            let t = f64::from(hits.t[lane]);
            if steep.abs() > 2e-6 {
                let expected = offset / dot(normal, v);
                if expected > 0.0 {
                    prop_assert!((t / expected - 1.0).abs() < 1e-6 / steep.abs(), "{t} is not {expected}");
                } else {
                    prop_assert_eq!(hits.face[lane], NO_FACE);
                }
            }
        }
    }

    #[test]
    fn parallel_rays_meet_a_plane_where_float64_says(tile in any_parallel_tile(), wall in any_plane()) {
        let (view, corner) = tile;
        let OracleShape::Plane { normal, offset } = wall else { unreachable!() };
        let mut hits = HitBuffer::new();
        wall.to_kernel().get(0).intersect(FACE, &rays_of(view, corner), &mut hits);
        let across = view.half_pixel.0 * f64::from(SIDE);
        for lane in 0..LANES {
            let Ray { origin, direction, .. } = exact_ray(view, corner, lane);
            let steep = dot(normal, direction);
            let expected = (offset - dot(normal, origin)) / steep;
            let rounding = 1e-6 * (expected.abs() + across / steep.abs());
            if steep.abs() > 2e-6 && expected.abs() > rounding {
                if expected > 0.0 {
                    prop_assert!((f64::from(hits.t[lane]) - expected).abs() < rounding, "lane {lane}: {expected}");
                } else {
                    prop_assert_eq!(hits.face[lane], NO_FACE);
                }
            }
        }
        if normal[2].abs() > 0.01 {
            check_parallel(&wall, tile)?;
        }
    }

    #[test]
    fn points_lie_on_the_plane_and_on_their_rays(tile in any_tile(), wall in any_plane()) {
        let OracleShape::Plane { normal, .. } = wall else { unreachable!() };
        for (lanes, points) in surface_points(&wall, tile) {
            let plane = points.plane.unwrap();
            prop_assert!(plane.height([0.0; 3]) > 0.0);
            prop_assert!(length(cross(plane.normal, normal)) < 1e-15);
            for (i, &lane) in lanes.iter().enumerate() {
                let point = point_of(&points, i);
                let v = exact_ray(tile.0, tile.1, lane.into()).direction;
                let steep = dot(normal, v).abs() / length(v);
                let local = length(sub(point, points.reference));
                let off = wall.distance(point);
                prop_assert!(off < 1e-6 * local + 1e-15 * length(point), "lane {}: {} off the plane", lane, off);
                let beside = length(cross(v, point)) / length(v);
                let rounding = 1e-6 * local / steep + 1e-15 * length(point);
                prop_assert!(beside < rounding, "lane {}: {} off the ray", lane, beside);
            }
        }
    }

    #[test]
    fn a_plane_hides_what_float64_says(
        (tile, receiver) in any_tile().prop_flat_map(|tile| (Just(tile), shape_before(tile, -1.0..3.0))),
        light in any_direction(),
        normal in any_direction(),
        (away, aside) in (any_size(-1.5..1.5), -2.0..2.0),
    ) {
        for (_, points) in surface_points(&receiver, tile) {
            let ball = points.bounds();
            let light = add(ball.center, scale(light, away * ball.radius));
            let offset = dot(normal, ball.center) + aside * ball.radius;
            check_occlusion(&OracleShape::Plane { normal, offset }, light, &points)?;
            let direction = normalized(sub(light, ball.center));
            check_occlusion(&OracleShape::Plane { normal, offset }, Apex::direction(direction), &points)?;
        }
    }

    /// However the camera turns, which rounds positions differently: a light on the ceiling lights the room.
    #[test]
    fn a_light_on_a_plane_is_not_hidden_by_it(axes in any_axes(), height in -3.0..3.0_f64) {
        let ceiling = OracleShape::Plane { normal: rotate(&axes, [0.0, 1.0, 0.0]), offset: height };
        let light = rotate(&axes, [1.0, height, 2.0]);
        let room = OracleShape::Sphere { center: [0.0, 0.0, 5.0], radius: 2.0 };
        let view = View::centered(16, 16, 0.01);
        for (_, points) in surface_points(&room, (view, (0, 0))) {
            let left = irradiance_left(&ceiling, light, &points);
            prop_assert!(left[..points.count].iter().all(|&left| left == 1.0));
        }
    }
}

#[test]
fn rays_that_almost_run_along_a_plane_miss_it() {
    let view = View::centered(SIDE, SIDE, 0.9e-6);
    let mut hits = HitBuffer::new();
    Plane::new([0.0, 1.0, 0.0], -1.0, 1.0).intersect(FACE, &rays_of(view, (0, 0)), &mut hits);
    for (lane, &face) in hits.face.iter().enumerate() {
        // Row 8 is the first below the horizon, by half a pixel; row 9 is the first that is steep enough.
        assert_eq!(face != NO_FACE, lane / SIDE as usize >= 9, "lane {lane}");
    }
}

#[test]
fn a_plane_through_the_eye_is_not_seen() {
    let view = View::centered(SIDE, SIDE, 0.1);
    let mut hits = HitBuffer::new();
    Plane::new([0.0, 1.0, 0.0], 0.0, 0.0).intersect(FACE, &rays_of(view, (0, 0)), &mut hits);
    assert!(hits.face.iter().all(|&face| face == NO_FACE));
}

#[test]
fn two_planes_in_the_same_place_do_not_hide_each_other() {
    let wall = OracleShape::Plane { normal: [0.0, 0.6, -0.8], offset: -7.0 };
    let turned_over = OracleShape::Plane { normal: [0.0, -0.6, 0.8], offset: 7.0 };
    let view = View::centered(SIDE, SIDE, 0.01);
    for (_, points) in surface_points(&wall, (view, (0, 0))) {
        for light in [[1.0, 0.0, 0.0], [50.0, 0.0, 5.0], [0.0, -2.0, 7.0]] {
            for wall in [&wall, &turned_over] {
                let left = irradiance_left(wall, light, &points);
                assert!(left[..points.count].iter().all(|&left| left == 1.0), "{light:?}");
            }
        }
    }
}

#[test]
fn a_normal_may_have_any_length() {
    for length in [1e-300, 1e-160, 1.0, 1e160, 1e300] {
        assert_eq!(normalized([0.0, -length, 0.0]), [0.0, -1.0, 0.0]);
    }
}
