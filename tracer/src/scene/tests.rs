use super::*;
use crate::camera::Projection;
use crate::oracle::any_world;
use crate::world::{Camera, CapsuleDesc, ConeDesc, CuboidDesc, CylinderDesc, LightSource, ShapeDesc, SphereDesc};
use crate::world::{Object, Settings};
use proptest::prelude::*;

/// All numbers of a scene.
fn numbers_of(scene: &Scene) -> String {
    let Scene { shapes, albedos, range_scales, emitted, lights, bvh, .. } = scene;
    format!("{shapes:?} {albedos:?} {range_scales:?} {emitted:?} {lights:?} {bvh:?}")
}

/// The same world with all lengths times a factor, and as much light.
fn scaled(world: &World, factor: f64) -> World {
    let mut world = world.clone();
    let times = |v: Vector| v.map(|x| x * factor);
    world.camera.position = times(world.camera.position);
    if world.camera.projection == Projection::Orthographic {
        world.camera.half_height *= factor;
    }
    for object in &mut world.objects {
        object.position = times(object.position);
        match &mut object.shape {
            ShapeDesc::Sphere(SphereDesc { radius }) => *radius *= factor,
            ShapeDesc::Plane(_) => (),
            ShapeDesc::Cuboid(CuboidDesc { size, .. }) => *size = times(*size),
            ShapeDesc::Cylinder(CylinderDesc { radius, height, .. })
            | ShapeDesc::Capsule(CapsuleDesc { radius, height, .. }) => {
                *radius *= factor;
                *height *= factor;
            }
            ShapeDesc::Cone(ConeDesc { radius, top_radius, height, .. }) => {
                *radius *= factor;
                *top_radius *= factor;
                *height *= factor;
            }
        }
    }
    for light in &mut world.lights {
        if let LightSource::Point { position, radius } = &mut light.source {
            (*position, *radius) = (times(*position), *radius * factor);
            light.intensity *= factor * factor;
        }
    }
    world
}

proptest! {
    #[test]
    fn a_scene_is_the_same_in_any_unit_that_is_a_power_of_two(world in any_world(), exponent in -60..60_i32) {
        // Without objects there is nothing to tell its size by.
        prop_assume!(world.objects.iter().any(|object| object.position != world.camera.position));
        let factor = libm::scalbn(1.0, exponent);
        let (scene, large) = (Scene::new(&world).unwrap(), Scene::new(&scaled(&world, factor)).unwrap());
        prop_assert_eq!(large.unit * factor, scene.unit);
        prop_assert_eq!(numbers_of(&large), numbers_of(&scene));
    }

    #[test]
    fn a_scene_is_the_same_wherever_it_is_moved_exactly(
        world in any_world(), way in [-512..512_i32, -512..512, -512..512]
    ) {
        let world = rounded(world);
        let mut moved = world.clone();
        let there = |position: Vector| std::array::from_fn(|i| position[i] + f64::from(way[i]));
        moved.camera.position = there(world.camera.position);
        moved.objects.iter_mut().for_each(|object| object.position = there(object.position));
        for light in &mut moved.lights {
            if let LightSource::Point { position, .. } = &mut light.source {
                *position = there(*position);
            }
        }
        prop_assert_eq!(numbers_of(&Scene::new(&moved).unwrap()), numbers_of(&Scene::new(&world).unwrap()));
    }
}

/// The same world with positions that can be added without rounding.
fn rounded(mut world: World) -> World {
    let near = |position: &mut Vector| position.iter_mut().for_each(|x| *x = (*x * 1024.0).round() / 1024.0);
    near(&mut world.camera.position);
    world.objects.iter_mut().for_each(|object| near(&mut object.position));
    for light in &mut world.lights {
        if let LightSource::Point { position, .. } = &mut light.source {
            near(position);
        }
    }
    world
}

fn one_object(shape: ShapeDesc, position: Vector) -> World {
    World {
        camera: Camera::along_z(16, 16, 60.0),
        checkers: vec![],
        objects: vec![Object { position, color: [0.5; 3], shape }],
        lights: vec![],
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

#[test]
fn the_unit_brings_the_scene_to_about_one() {
    for size in [1e-300, 1e-30, 1e-6, 1.0, 1e6, 1e30, 1e300] {
        let scene =
            Scene::new(&one_object(ShapeDesc::Sphere(SphereDesc { radius: size / 10.0 }), [0.0, 0.0, -size]))
                .unwrap();
        let [sphere] = &scene.shapes.sphere[..] else { panic!("a sphere") };
        assert!((0.5..4.0).contains(&sphere.center[2]), "{size}: {:?}", sphere.center);
        let ratio = sphere.center[2] / sphere.radius;
        assert!((ratio - 10.0).abs() < 1e-12, "{size}: {ratio}");
    }
}

#[test]
fn along_parallel_rays_the_picture_counts_however_many_objects_are_far_away() {
    let mut world = one_object(ShapeDesc::Sphere(SphereDesc { radius: 1e58 }), [0.0, 0.0, -1e60]);
    world.camera.projection = Projection::Orthographic;
    world.camera.half_height = 1.0;
    for _ in 0..3 {
        assert!((-62..=0).contains(&libm::ilogb(unit::suitable_unit(&world))));
        world.objects.push(world.objects[0].clone());
    }
}

#[test]
fn an_object_that_carries_a_light_shines_with_the_light_that_reaches_the_eye() {
    let mut world = one_object(ShapeDesc::Sphere(SphereDesc { radius: 1.0 }), [0.0, 0.0, -5.0]);
    world.lights.push(LightDesc {
        source: LightSource::Point { position: [0.0, 3.0, -4.0], radius: 0.0 },
        color: [1.0, 0.5, 0.0],
        intensity: 100.0 * PI,
        carrier: Some(0),
    });
    let emitted = Scene::new(&world).unwrap().emitted(0);
    assert_eq!(emitted, Some([1.0, 0.5, 0.0]));
}
