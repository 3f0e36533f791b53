use super::*;
use crate::accel::cone::Cone;
use crate::accel::pyramid::{Footprint, Pyramid};
use crate::apex::Apex;
use crate::oracle::*;
use crate::shapes::primitive::Primitive;
use crate::tile::LANES;
use crate::vector::{Vector, add, dot, length, normalized, scale, sub};
use proptest::prelude::*;

/// Objects of any size around the middle ray of a tile, or all around the eye.
fn any_scene() -> impl Strategy<Value = ((crate::tile::View, (u32, u32)), Vec<OracleShape>)> {
    any_tile().prop_flat_map(|tile| {
        let scattered = prop::collection::vec(shape_before(tile, -2.0..4.0), 0..60);
        let wide = (any_direction(), any_size(-2.0..2.0), any_size(-3.0..0.0));
        let around = prop::collection::vec(wide, 0..300).prop_map(|positions| {
            let ball = |(direction, distance, size)| OracleShape::Sphere {
                center: scale(direction, distance),
                radius: size,
            };
            positions.into_iter().map(ball).collect::<Vec<_>>()
        });
        (Just(tile), (scattered, around).prop_map(|(a, b)| [a, b].concat()))
    })
}

fn tree_of(shapes: &[OracleShape]) -> Bvh {
    let (mut tree, order) = Bvh::new(shapes.par_iter().map(|shape| shape.to_kernel().get(0).bounds())).unwrap();
    tree.renumber(&order);
    tree
}

/// What a walk finds, in order, with the same limit all the way.
fn found(tree: &Bvh, volume: &impl Volume, limit: f32) -> Vec<u32> {
    let mut stack = Stack::default();
    let mut traversal = tree.traverse(volume, &mut stack);
    std::iter::from_fn(|| traversal.next(limit)).collect()
}

fn assert_once_each(found: &[u32], count: usize) {
    let mut sorted = found.to_vec();
    sorted.sort_unstable();
    assert_eq!(sorted, (0..count as u32).collect::<Vec<_>>());
}

/// A cone that holds everything.
fn everywhere() -> Cone {
    let ball = BoundingSphere { center: [0.0; 3], radius: 1e30 };
    Cone::from_apex(Apex::point([0.0; 3]), 0.0, ball, 0.0)
}

/// The place of an emitter in a direction from its middle, at its rim.
fn place_of(middle: Apex, size: f64, aside: Vector) -> Apex {
    if !middle.is_direction() {
        return Apex::point(add(middle.at, scale(aside, size)));
    }
    let across = sub(aside, scale(middle.at, dot(middle.at, aside)));
    Apex::direction(add(scale(middle.at, (1.0 - size * size).sqrt()), scale(normalized(across), size)))
}

proptest! {
    #[test]
    fn no_object_that_a_ray_of_the_block_meets_is_left_out((tile, shapes) in any_scene()) {
        let cone = Cone::of_tile(&rays_of(tile.0, tile.1));
        let found = found(&tree_of(&shapes), &cone, f32::INFINITY);
        for (i, shape) in shapes.iter().enumerate() {
            let met = (0..LANES).any(|lane| shape.depth(exact_ray(tile.0, tile.1, lane)).is_some());
            prop_assert!(!met || found.contains(&(i as u32)), "{shape:?} is left out");
        }
    }

    #[test]
    fn no_object_that_is_met_within_a_depth_is_left_out((tile, shapes) in any_scene(), share in 0.0..1.0_f64) {
        let rays = rays_of(tile.0, tile.1);
        let cone = Cone::of_tile(&rays);
        let depths = |shape: &OracleShape| {
            let depths = (0..LANES).filter_map(|lane| shape.depth(exact_ray(tile.0, tile.1, lane)));
            depths.fold(f64::INFINITY, f64::min)
        };
        let mut all: Vec<f64> = shapes.iter().map(depths).filter(|t| t.is_finite()).collect();
        all.sort_unstable_by(f64::total_cmp);
        if let Some(&limit) = all.get((share * all.len() as f64) as usize) {
            let found = found(&tree_of(&shapes), &cone, cone.along_axis(&rays, limit as f32));
            for (i, shape) in shapes.iter().enumerate() {
                prop_assert!(depths(shape) > limit || found.contains(&(i as u32)), "{shape:?} is left out");
            }
        }
    }

    #[test]
    fn no_object_between_a_light_and_a_ball_of_points_is_left_out(
        (_, shapes) in any_scene(),
        (toward, away, size) in (any_direction(), any_size(-2.0..2.0), any_size(-6.0..1.0)),
        (light, infinite) in ([-1.0..1.0, -1.0..1.0, -1.0..1.0], any::<bool>()),
        emitter in prop_oneof![Just(0.0), 0.0..0.9, 0.9..10.0],
        points in prop::collection::vec((any_direction(), 0.0..1.0_f64, any_direction()), 50),
    ) {
        let ball = BoundingSphere { center: add(light, scale(toward, away)), radius: size };
        let light = if infinite { Apex::direction(toward) } else { Apex::point(light) };
        let emitter = if infinite { 0.07 * emitter } else { emitter * away };
        let cone = Cone::from_apex(light, emitter, ball, 0.0);
        let found = found(&tree_of(&shapes), &cone, f32::INFINITY);
        for (direction, share, aside) in points {
            let point = add(ball.center, scale(direction, size * share.cbrt()));
            let place = place_of(light, emitter, aside);
            for (i, shape) in shapes.iter().enumerate() {
                let between = shape.stands_between(place, point);
                prop_assert!(!between || found.contains(&(i as u32)), "{shape:?} is left out");
            }
        }
    }

    #[test]
    fn no_object_between_a_light_and_the_points_of_a_flat_face_is_left_out(
        tile in any_tile(),
        wall in any_plane(),
        (toward, distance, infinite) in (any_direction(), any_size(-6.0..6.0), any::<bool>()),
        emitter in prop_oneof![Just(0.0), 0.0..0.99],
        spots in prop::collection::vec((0..LANES, 0.0..1.0, any_size(-6.0..0.0), any_direction(), 0.0..1.2), 1..60),
    ) {
        let Some((_, points)) = surface_points(&wall, tile).pop() else { return Ok(()) };
        let plane = points.plane.unwrap();
        let light = add(points.reference, scale(toward, distance));
        // On the eye's side.
        let light = sub(light, scale(plane.normal, (2.0 * plane.height(light)).min(0.0)));
        let shape = |&(lane, share, size, aside, beside): &(usize, f64, f64, Vector, f64)| {
            let way = sub(point_of(&points, lane % points.count), light);
            let radius = size * length(way);
            let center = add(add(light, scale(way, share)), scale(aside, beside * radius));
            OracleShape::Sphere { center, radius }
        };
        let shapes: Vec<_> = spots.iter().map(shape).collect();
        // Infinitely far away, in the direction from one of the points.
        let direction = || normalized(sub(light, point_of(&points, spots[0].0 % points.count)));
        let light = if infinite { Apex::direction(direction()) } else { Apex::point(light) };
        // Wholly above the face.
        let emitter = emitter * plane.height_of_apex(light).max(0.0);
        let pyramid = Pyramid::new(light, emitter, &Footprint::new(plane, &points));
        let found = found(&tree_of(&shapes), &pyramid, f32::INFINITY);
        for (i, shape) in shapes.iter().enumerate() {
            let place = place_of(light, emitter, spots[i].3);
            let between = (0..points.count).any(|lane| shape.stands_between(place, point_of(&points, lane)));
            prop_assert!(!between || found.contains(&(i as u32)), "{shape:?} is left out");
        }
    }

    #[test]
    fn every_object_is_in_the_tree_once((_, shapes) in any_scene()) {
        assert_once_each(&found(&tree_of(&shapes), &everywhere(), f32::INFINITY), shapes.len());
    }
}

#[test]
fn an_empty_tree_holds_nothing() {
    assert!(found(&tree_of(&[]), &everywhere(), f32::INFINITY).is_empty());
}

#[test]
fn planes_are_not_in_the_tree() {
    let wall = OracleShape::Plane { normal: [0.0, 1.0, 0.0], offset: 1.0 };
    let ball = OracleShape::Sphere { center: [0.0, 0.0, 3.0], radius: 1.0 };
    assert_eq!(found(&tree_of(&[wall, ball]), &everywhere(), f32::INFINITY), [1]);
}

#[test]
fn one_of_many_objects_may_be_far_from_the_others() {
    let ball = |i: i32| {
        let away = if i == 0 { 1e9 } else { f64::from(i) * 1e-3 };
        OracleShape::Sphere { center: [away, away.sin(), away.cos()], radius: 1e-3 }
    };
    let tree = tree_of(&(0..10_000).map(ball).collect::<Vec<_>>());
    assert_once_each(&found(&tree, &everywhere(), f32::INFINITY), 10_000);
}

/// Returns a number from 0 to 1 that differs widely from one index to the next.
fn share(index: u32, step: u32) -> f64 {
    f64::from(index.wrapping_mul(step) >> 8) / f64::from(1 << 24)
}

/// Returns a point in the unit cube.
fn scattered(index: u32) -> Vector {
    [share(index, 0x9e37_79b1), share(index, 0x85eb_ca6b), share(index, 0xc2b2_ae35)]
}

#[test]
fn the_tree_has_few_more_nodes_than_full_ones_would_be() {
    for count in [100, 1000, 10_000] {
        let ball = |i| OracleShape::Sphere { center: scattered(i), radius: 1e-3 };
        let tree = tree_of(&(0..count).map(ball).collect::<Vec<_>>());
        assert!(tree.nodes.len() as u32 * 5 < count, "{} nodes over {count} objects", tree.nodes.len());
    }
}

#[test]
fn ten_thousand_objects_may_be_in_one_place() {
    let ball = OracleShape::Sphere { center: [1.0, 2.0, 3.0], radius: 0.5 };
    let tree = tree_of(&vec![ball; 10_000]);
    assert_once_each(&found(&tree, &everywhere(), f32::INFINITY), 10_000);
}

/// Each cut takes off only the few largest: the worst that can happen to the depth of the tree.
#[test]
fn objects_may_crowd_toward_a_point() {
    let sphere = |i: i32| OracleShape::Sphere { center: [0.0, 0.0, 2_f64.powi(-i)], radius: 2_f64.powi(-i - 3) };
    let tree = tree_of(&(0..1000).map(sphere).collect::<Vec<_>>());
    assert_once_each(&found(&tree, &everywhere(), f32::INFINITY), 1000);
}

/// More than one thread sorts its objects and builds it.
#[test]
fn a_large_tree_is_the_same_on_any_number_of_threads() {
    let sphere =
        |i| OracleShape::Sphere { center: scattered(i), radius: 0.001 + 0.1 * share(i, 0x27d4_eb2f).powi(20) };
    let shapes: Vec<OracleShape> = (0..150_000).map(sphere).collect();
    let built = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| tree_of(&shapes))
    };
    let tree = built(1);
    assert_once_each(&found(&tree, &everywhere(), f32::INFINITY), shapes.len());
    for threads in [2, 3, 7] {
        assert_eq!(format!("{:?}", built(threads)), format!("{tree:?}"), "on {threads} threads");
    }
}

#[test]
fn objects_in_a_row_come_from_near_to_far_up_to_the_limit() {
    let ball = |i: i32| OracleShape::Sphere { center: [0.0, 0.0, f64::from(1 + (i * 37) % 100)], radius: 0.25 };
    let shapes: Vec<OracleShape> = (0..100).map(ball).collect();
    let view = crate::tile::View::centered(16, 16, 0.001);
    let cone = Cone::of_tile(&rays_of(view, (0, 0)));
    let starts = |limit: f32| -> Vec<f64> {
        let found = found(&tree_of(&shapes), &cone, limit);
        found.into_iter().map(|i| shapes[i as usize].center()[2]).collect()
    };
    assert_eq!(starts(f32::INFINITY), (1..=100).map(f64::from).collect::<Vec<_>>());
    assert_eq!(starts(41.9), (1..=42).map(f64::from).collect::<Vec<_>>());
}
