use super::*;
use crate::budget::WorkBudget;
use crate::oracle::any_world;
use crate::render::Tracer;
use crate::scene::Scene;
use crate::simd::Level;
use crate::vector::Vector;
use crate::world::{
    Camera, CapsuleDesc, ConeDesc, CuboidDesc, CylinderDesc, Object, PlaneDesc, Settings, ShapeDesc, SphereDesc,
    World,
};
use proptest::prelude::*;
use std::sync::Arc;

fn whole(world: &World) -> Window {
    Window { x: 0, y: 0, width: world.camera.width, height: world.camera.height }
}

/// The pixels of each object, by testing all rays, and by the search; and the steps of that. It marks the same pixels.
fn both_ways(world: &World, window: Window) -> (Vec<u64>, Vec<u64>, u64) {
    let scene = Scene::new(world).unwrap();
    let mut mask = vec![0; window.pixels()];
    let view = View::new(&world.camera, scene.unit);
    let mut search = Search { view, window, rays: Rays::new(), hits: HitBuffer::new(), mask: &mut mask };
    let tiles: Vec<Tile> = Tile::all(search.view, window).collect();
    let budget = WorkBudget::default();
    let mut work = budget.counter();
    let (mut all, mut found) = (Vec::new(), Vec::new());
    for number in 0..world.objects.len() as u32 {
        let index = scene.numbers.iter().position(|&other| other == number).unwrap();
        let shape = scene.shapes.get(index as u32);
        search.mask.fill(0);
        all.push(tiles.iter().map(|tile| search.count_tile(shape, tile.corner)).sum());
        let expected = search.mask.to_vec();
        search.mask.fill(0);
        found.push(search.count(shape, &mut work, || false));
        assert!(search.mask == expected);
        assert_eq!(expected.iter().map(|&pixel| u64::from(pixel)).sum::<u64>(), all[number as usize]);
    }
    budget.spend(work);
    (all, found, budget.spent())
}

/// What a camera at the origin with a picture of 1000 x 800 pixels sees along -z.
fn world_of(shapes: &[(Vector, ShapeDesc)]) -> World {
    World {
        camera: Camera::along_z(1000, 800, 60.0),
        checkers: vec![],
        objects: shapes.iter().map(|&(position, shape)| Object { position, color: [0.5; 3], shape }).collect(),
        lights: Vec::new(),
        settings: Settings {
            samples: 1,
            background: [0.0; 3],
            ambient: [0.0; 3],
            direct_light: true,
            shadow_samples: 16,
            eye_falloff: false,
        },
    }
}

fn boxed(x: f64, y: f64, z: f64, rotation: f64) -> ShapeDesc {
    ShapeDesc::Cuboid(CuboidDesc { size: [x, y, z], rotation: [0.0, rotation, 0.0] })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn the_search_finds_what_all_rays_tell(world in any_world(), width in 1..400_u32, height in 1..400_u32) {
        let world = World { camera: Camera { width, height, ..world.camera.clone() }, ..world };
        let (all, found, _) = both_ways(&world, whole(&world));
        prop_assert_eq!(all, found);
    }

    #[test]
    fn the_search_finds_what_all_rays_of_a_crop_tell(
        world in any_world(), x in 0..200_u32, y in 0..200_u32, width in 1..150_u32, height in 1..150_u32
    ) {
        let world = World { camera: Camera { width: 350, height: 350, ..world.camera.clone() }, ..world };
        let (all, found, _) = both_ways(&world, Window { x, y, width, height });
        prop_assert_eq!(all, found);
    }
}

#[test]
fn the_search_finds_all_of_long_flat_and_large_shapes() {
    let world = world_of(&[
        ([0.0, 0.0, -10.0], boxed(30.0, 0.01, 0.01, 30.0)),
        ([1.0, 0.5, -10.0], boxed(8.0, 5.0, 0.001, 70.0)),
        ([0.0, -1.0, -5.0], boxed(100.0, 0.1, 100.0, 45.0)), // the camera is above it
        ([2.0, 3.0, 1.0], boxed(3.0, 3.0, 30.0, 10.0)),      // partly behind the camera
        ([0.0, 0.0, 0.0], boxed(2.0, 2.0, 2.0, 20.0)),       // around the camera
        ([0.0, 0.0, -1.0], boxed(2.0, 2.0, 2.0, 0.0)),       // with the camera on a face
        ([0.0, 0.0, 0.0], ShapeDesc::Sphere(SphereDesc { radius: 3.0 })),
        ([0.0, 0.0, -3.0], ShapeDesc::Sphere(SphereDesc { radius: 3.0 })), // with the camera on it
        ([0.0, 2.0, -3.0], ShapeDesc::Sphere(SphereDesc { radius: 2.9 })),
        ([0.0, 0.0, 9.0], ShapeDesc::Sphere(SphereDesc { radius: 3.0 })),
        ([0.0, -1.0, 0.0], ShapeDesc::Plane(PlaneDesc { normal: [0.1, 1.0, 0.0] })),
        ([0.0, 0.0, 0.0], ShapeDesc::Plane(PlaneDesc { normal: [0.1, 1.0, 0.0] })), // through the camera
        ([0.0, 0.0, 5.0], ShapeDesc::Plane(PlaneDesc { normal: [0.0, 0.0, 1.0] })),
        ([0.0, 0.0, -5.0], ShapeDesc::Plane(PlaneDesc { normal: [0.0, 0.0, 1.0] })),
    ]);
    let (all, found, _) = both_ways(&world, whole(&world));
    assert_eq!(all, found);
    assert_eq!([found[4], found[6], found[13]], [800_000; 3]);
}

#[test]
fn round_shapes_are_found_by_their_outlines_for_parallel_rays_too() {
    let round = [
        ShapeDesc::Cylinder(CylinderDesc { radius: 1.0, height: 3.0, axis: [1.0, 2.0, 3.0] }),
        ShapeDesc::Cylinder(CylinderDesc { radius: 0.5, height: 1.0, axis: [0.0, 0.0, 1.0] }),
        ShapeDesc::Capsule(CapsuleDesc { radius: 0.7, height: 2.0, axis: [1.0, 0.2, 0.0] }),
        ShapeDesc::Cone(ConeDesc { radius: 1.0, top_radius: 0.3, height: 2.0, axis: [0.0, 1.0, -0.5] }),
    ];
    for shape in round {
        let mut world = world_of(&[([0.5, -0.7, -100.0], shape)]);
        world.camera = Camera { projection: Projection::Orthographic, half_height: 8.0, ..world.camera };
        let (all, found, steps) = both_ways(&world, whole(&world));
        assert_eq!(all, found);
        assert!(found[0] > 0);
        // The picture has 3,150 tiles.
        assert!(steps < 150 * TILE_STEPS, "{shape:?}: {found:?} pixels, {steps} steps");
    }
}

#[test]
fn what_fills_the_picture_takes_a_step_and_what_is_outside_few() {
    let around = world_of(&[([0.0; 3], ShapeDesc::Sphere(SphereDesc { radius: 3.0 }))]);
    assert_eq!(both_ways(&around, whole(&around)).2, 1);
    let behind = world_of(&[([0.0, 0.0, 9.0], boxed(1.0, 1.0, 1.0, 30.0))]);
    assert!(both_ways(&behind, whole(&behind)).2 < 10);
}

#[test]
fn the_work_grows_with_the_outline_and_not_with_the_area() {
    let ball = |radius| world_of(&[([0.0, 0.0, -100.0], ShapeDesc::Sphere(SphereDesc { radius }))]);
    let steps = |radius| {
        let world = ball(radius);
        both_ways(&world, whole(&world)).2 as f64
    };
    assert!(steps(40.0) / steps(10.0) < 6.0, "{} {}", steps(40.0), steps(10.0));
}

fn crowd() -> World {
    let balls: Vec<(Vector, ShapeDesc)> = (0..200)
        .map(|i| {
            let angle = f64::from(i);
            let tile = [2.0 * angle.sin(), 2.0 * (1.7 * angle).cos(), -20.0 - angle.cos()];
            (tile, ShapeDesc::Sphere(SphereDesc { radius: 4.0 }))
        })
        .collect();
    world_of(&balls)
}

/// What a budget of some steps gives, and the steps that were spent.
fn covered(
    world: &World,
    level: Level,
    threads: usize,
    steps: u64,
) -> (Result<Vec<u64>, crate::monitor::Stopped>, u64) {
    let budget = Arc::new(WorkBudget::new(steps));
    let monitor = Monitor::within(Arc::clone(&budget));
    let tracer = Tracer::new(world.clone(), level).unwrap();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let result = pool.install(|| tracer.coverage(whole(world), &monitor));
    (result, budget.spent())
}

#[test]
fn whether_coverage_exceeds_a_budget_depends_on_nothing_but_the_world() {
    let world = crowd();
    let (expected, steps) = covered(&world, Level::best(), 1, u64::MAX);
    let expected = expected.unwrap();
    for level in Level::available() {
        for threads in [1, 2, 5] {
            let (result, spent) = covered(&world, level, threads, steps);
            assert_eq!((result.unwrap(), spent), (expected.clone(), steps));
            let (result, spent) = covered(&world, level, threads, steps - 1);
            assert!(matches!(result, Err(crate::monitor::Stopped::BudgetExceeded)));
            assert!(spent >= steps);
        }
    }
}

#[test]
fn coverage_ends_soon_after_its_budget() {
    let (result, spent) = covered(&crowd(), Level::best(), 2, 1000);
    assert!(matches!(result, Err(crate::monitor::Stopped::BudgetExceeded)));
    assert!(spent < 10_000, "{spent}");
}
