use super::*;
use crate::grid::{NOTHING, SIDE};
use crate::oracle::*;
use crate::place::View;
use crate::vector::{add, cross, length, sub, turned};
use proptest::prelude::*;

proptest! {
    #[test]
    fn rays_meet_a_plane_where_float64_says(block in any_block(), wall in any_wall()) {
        let (view, corner) = block;
        let Solid::Wall { normal, offset } = wall else { unreachable!() };
        let mut nearest = Nearest::new();
        wall.shape().meet(FACE, &rays_of(view, corner), &mut nearest);
        for lane in 0..LANES {
            let v = exact_ray(view, corner, lane);
            let steep = dot(normal, v) / length(v);
            let t = f64::from(nearest.t[lane]);
            if steep.abs() > 2e-6 {
                let expected = offset / dot(normal, v);
                if expected > 0.0 {
                    prop_assert!((t / expected - 1.0).abs() < 1e-6 / steep.abs(), "{t} is not {expected}");
                } else {
                    prop_assert_eq!(nearest.face[lane], NOTHING);
                }
            }
        }
    }

    #[test]
    fn points_lie_on_the_plane_and_on_their_rays(block in any_block(), wall in any_wall()) {
        let Solid::Wall { normal, .. } = wall else { unreachable!() };
        for (lanes, points, plane) in placed(&wall, block) {
            let plane = plane.unwrap();
            prop_assert!(plane.height([0.0; 3]) > 0.0);
            prop_assert!(length(cross(plane.normal, normal)) < 1e-15);
            for (i, &lane) in lanes.iter().enumerate() {
                let point = point_of(&points, i);
                let v = exact_ray(block.0, block.1, lane.into());
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
        (block, receiver) in any_block().prop_flat_map(|block| (Just(block), solid_before(block, -1.0..3.0))),
        lamp in any_direction(),
        normal in any_direction(),
        (away, aside) in (any_size(-1.5..1.5), -2.0..2.0),
    ) {
        for (_, points, _) in placed(&receiver, block) {
            let ball = points.bound();
            let lamp = add(ball.center, scale(lamp, away * ball.radius));
            let offset = dot(normal, ball.center) + aside * ball.radius;
            check_hiding(&Solid::Wall { normal, offset }, lamp, &points)?;
        }
    }

    /// However the camera turns, which rounds places differently: a lamp on the ceiling lights the room.
    #[test]
    fn a_lamp_on_a_plane_is_not_hidden_by_it(axes in any_axes(), height in -3.0..3.0_f64) {
        let ceiling = Solid::Wall { normal: turned(&axes, [0.0, 1.0, 0.0]), offset: height };
        let lamp = turned(&axes, [1.0, height, 2.0]);
        let room = Solid::Ball { center: [0.0, 0.0, 5.0], radius: 2.0 };
        let view = View { width: 16, height: 16, half_pixel: (0.01, 0.01) };
        for (_, points, _) in placed(&room, (view, (0, 0))) {
            let light = light_left(&ceiling, lamp, &points);
            prop_assert!(light[..points.count].iter().all(|&light| light == 1.0));
        }
    }
}

#[test]
fn rays_that_almost_run_along_a_plane_miss_it() {
    let view = View {
        width: SIDE,
        height: SIDE,
        half_pixel: (0.9e-6, 0.9e-6),
    };
    let mut nearest = Nearest::new();
    Plane::new([0.0, 1.0, 0.0], -1.0, 1.0).meet(FACE, &rays_of(view, (0, 0)), &mut nearest);
    for (lane, &face) in nearest.face.iter().enumerate() {
        // Row 8 is the first below the horizon, by half a pixel; row 9 is the first that is steep enough.
        assert_eq!(face != NOTHING, lane / SIDE as usize >= 9, "lane {lane}");
    }
}

#[test]
fn a_plane_through_the_eye_is_not_seen() {
    let view = View {
        width: SIDE,
        height: SIDE,
        half_pixel: (0.1, 0.1),
    };
    let mut nearest = Nearest::new();
    Plane::new([0.0, 1.0, 0.0], 0.0, 0.0).meet(FACE, &rays_of(view, (0, 0)), &mut nearest);
    assert!(nearest.face.iter().all(|&face| face == NOTHING));
}

#[test]
fn two_planes_in_the_same_place_do_not_hide_each_other() {
    let wall = Solid::Wall {
        normal: [0.0, 0.6, -0.8],
        offset: -7.0,
    };
    let turned_over = Solid::Wall {
        normal: [0.0, -0.6, 0.8],
        offset: 7.0,
    };
    let view = View {
        width: SIDE,
        height: SIDE,
        half_pixel: (0.01, 0.01),
    };
    for (_, points, _) in placed(&wall, (view, (0, 0))) {
        for lamp in [[1.0, 0.0, 0.0], [50.0, 0.0, 5.0], [0.0, -2.0, 7.0]] {
            for wall in [&wall, &turned_over] {
                let light = light_left(wall, lamp, &points);
                assert!(light[..points.count].iter().all(|&light| light == 1.0), "{lamp:?}");
            }
        }
    }
}
