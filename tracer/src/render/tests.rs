use super::*;
use crate::WorkBudget;
use crate::oracle::any_world;
use crate::output::develop::{BitDepth, ToneCurve};
use crate::output::film::{Pass, Values};
use crate::output::png::Compression;
use crate::world::{
    Camera, CuboidDesc, LightDesc, LightSource, Object, PlaneDesc, Projection, ShapeDesc, SphereDesc,
};
use proptest::prelude::*;
use std::f64::consts::PI;
use std::sync::Arc;

/// All arrays of a film, and the number of rays.
#[derive(Clone, Debug, PartialEq)]
struct Arrays {
    radiance: Vec<f32>,
    depth: Vec<f32>,
    distance: Vec<f32>,
    normal: Vec<f32>,
    position: Vec<f32>,
    albedo: Vec<f32>,
    object_id: Vec<u32>,
    rays: u64,
}

impl Arrays {
    fn floats(&self) -> [(&[f32], usize); 6] {
        [
            (&self.radiance, 3),
            (&self.depth, 1),
            (&self.distance, 1),
            (&self.normal, 3),
            (&self.position, 3),
            (&self.albedo, 3),
        ]
    }

    /// Everything of some pixels, to the last bit.
    fn bits(&self, pixels: impl Iterator<Item = usize>) -> Vec<u32> {
        let mut bits = Vec::new();
        for pixel in pixels {
            for (array, size) in self.floats() {
                bits.extend(array[size * pixel..size * (pixel + 1)].iter().map(|x| x.to_bits()));
            }
            bits.push(self.object_id[pixel]);
        }
        bits
    }

    fn all_bits(&self) -> Vec<u32> {
        self.bits(0..self.object_id.len())
    }
}

fn whole(world: &World) -> Window {
    Window { x: 0, y: 0, width: world.camera.width, height: world.camera.height }
}

fn filmed(tracer: &Tracer, window: Window) -> Arrays {
    let pixels = window.width as usize * window.height as usize;
    let mut arrays = Arrays {
        radiance: vec![-1.0; 3 * pixels],
        depth: vec![-1.0; pixels],
        distance: vec![-1.0; pixels],
        normal: vec![-1.0; 3 * pixels],
        position: vec![-1.0; 3 * pixels],
        albedo: vec![-1.0; 3 * pixels],
        object_id: vec![u32::MAX; pixels],
        rays: 0,
    };
    let film = Film::of_radiance(&mut arrays.radiance)
        .with(Pass::Depth, Values::Floats(&mut arrays.depth))
        .with(Pass::Distance, Values::Floats(&mut arrays.distance))
        .with(Pass::Normal, Values::Floats(&mut arrays.normal))
        .with(Pass::Position, Values::Floats(&mut arrays.position))
        .with(Pass::Albedo, Values::Floats(&mut arrays.albedo))
        .with(Pass::ObjectId, Values::Integers(&mut arrays.object_id));
    let rays = tracer.film(window, film, &Monitor::default()).unwrap();
    Arrays { rays, ..arrays }
}

fn best(world: &World) -> Tracer {
    Tracer::new(world.clone(), Level::best()).unwrap()
}

fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work)
}

fn written(tracer: &Tracer, window: Window, bits: BitDepth) -> Vec<u8> {
    let mut file = Vec::new();
    let developer = Developer::new(0.0, ToneCurve::Clip, bits);
    tracer.write_png(window, &developer, &[], Compression::Fast, &mut file, &Monitor::default()).unwrap();
    file
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn every_simd_level_gives_the_same_bits(world in any_world()) {
        let window = whole(&world);
        let baseline = Tracer::new(world.clone(), Level::Baseline).unwrap();
        let arrays = filmed(&baseline, window);
        for level in Level::available() {
            let tracer = Tracer::new(world.clone(), level).unwrap();
            let others = filmed(&tracer, window);
            prop_assert_eq!(others.all_bits(), arrays.all_bits(), "{}", level.name());
            prop_assert_eq!(others.rays, arrays.rays, "{}", level.name());
            for bits in [BitDepth::Eight, BitDepth::Sixteen] {
                let expected = written(&baseline, window, bits);
                prop_assert_eq!(written(&tracer, window, bits), expected, "{}", level.name());
            }
        }
    }

    #[test]
    fn passes_do_not_need_radiance(world in any_world()) {
        let (window, tracer) = (whole(&world), best(&world));
        let (mut depth, mut normal) = (vec![-1.0; window.pixels()], vec![-1.0; 3 * window.pixels()]);
        let film = Film::default()
            .with(Pass::Depth, Values::Floats(&mut depth))
            .with(Pass::Normal, Values::Floats(&mut normal));
        let rays = tracer.film(window, film, &Monitor::default()).unwrap();
        let whole = filmed(&tracer, window);
        let bits = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        prop_assert_eq!(bits(&depth), bits(&whole.depth));
        prop_assert_eq!(bits(&normal), bits(&whole.normal));
        prop_assert_eq!(rays, 0);
    }

    #[test]
    fn a_crop_is_that_part_of_the_whole(
        world in any_world(), x in 0.0..1.0_f64, y in 0.0..1.0_f64, width in 0.0..1.0_f64, height in 0.0..1.0_f64
    ) {
        let window = whole(&world);
        let part = |share: f64, of: u32| (share * f64::from(of)) as u32;
        let (x, y) = (part(x, window.width), part(y, window.height));
        let crop = Window {
            x,
            y,
            width: 1 + part(width, window.width - x - 1),
            height: 1 + part(height, window.height - y - 1),
        };
        let tracer = best(&world);
        let pixel = |i: u32| ((y + i / crop.width) * window.width + x + i % crop.width) as usize;
        let expected = filmed(&tracer, window).bits((0..crop.width * crop.height).map(pixel));
        prop_assert_eq!(filmed(&tracer, crop).all_bits(), expected);
    }

    #[test]
    fn the_rays_of_a_picture_are_those_of_its_parts(world in any_world(), cut in 0.0..1.0_f64) {
        let window = whole(&world);
        let left = (cut * f64::from(window.width)) as u32;
        prop_assume!(left > 0);
        let tracer = best(&world);
        let parts = [
            Window { width: left, ..window },
            Window { x: left, width: window.width - left, ..window },
        ];
        let rays: u64 = parts.into_iter().map(|part| filmed(&tracer, part).rays).sum();
        prop_assert_eq!(rays, filmed(&tracer, window).rays);
    }

    #[test]
    fn arrays_hold_what_they_promise(world in any_world()) {
        let arrays = filmed(&best(&world), whole(&world));
        prop_assert!(arrays.radiance.iter().all(|x| x.is_finite() && *x >= 0.0));
        for (pixel, &id) in arrays.object_id.iter().enumerate() {
            let triple = |array: &[f32]| -> [f32; 3] { std::array::from_fn(|i| array[3 * pixel + i]) };
            let (depth, distance) = (arrays.depth[pixel], arrays.distance[pixel]);
            if id == 0 {
                prop_assert_eq!((depth, distance), (f32::INFINITY, f32::INFINITY));
                prop_assert_eq!(triple(&arrays.normal), [0.0; 3]);
                prop_assert_eq!(triple(&arrays.position), [0.0; 3]);
                prop_assert_eq!(triple(&arrays.albedo), [0.0; 3]);
                continue;
            }
            prop_assert!(0.0 < depth && depth <= distance && distance.is_finite());
            let object = id as usize - 1;
            let checkers = world.checkers.iter().filter(|checker| checker.object == object);
            let mut colors = checkers.map(|checker| checker.color).chain([world.objects[object].color]);
            let albedo = triple(&arrays.albedo);
            prop_assert!(colors.any(|color| color.map(|c| c as f32) == albedo), "{albedo:?}");
            let toward = crate::vector::sub(triple(&arrays.position).map(f64::from), world.camera.position);
            let along = crate::vector::dot(world.camera.forward, toward);
            let (way, toward) = match world.camera.projection {
                Projection::Perspective => (crate::vector::length(toward), toward),
                Projection::Orthographic => (along, crate::vector::scale(world.camera.forward, along)),
            };
            let off = way / f64::from(distance) - 1.0;
            // The depth of a plane near its horizon is as uncertain as the angle between them is small.
            prop_assert!(off.abs() < 1e-4 + 1e-5 / f64::from(distance), "{off}");
            let normal = triple(&arrays.normal).map(f64::from);
            prop_assert!((crate::vector::length(normal) - 1.0).abs() < 1e-6);
            prop_assert!(crate::vector::dot(normal, toward) < 1e-3 * f64::from(distance));
        }
    }

    #[test]
    fn the_meter_sees_points_of_the_same_view_with_one_sample(
        world in any_world(), grid in 1_u32..9, shape in 0..3_usize
    ) {
        // In a picture three times as wide, or as high, as a square each third pixel is such a point.
        let (across, down) = [(1, 1), (3, 1), (1, 3)][shape];
        let large = World {
            camera: Camera { width: across * grid, height: down * grid, ..world.camera.clone() },
            settings: Settings { samples: 1, ..world.settings.clone() },
            ..world.clone()
        };
        let radiance = filmed(&best(&large), whole(&large)).radiance;
        let point = |i: u32| {
            let (x, y) = (across * (i % grid) + across / 2, down * (i / grid) + down / 2);
            (y * large.camera.width + x) as usize
        };
        let points: Vec<f32> = (0..grid * grid).flat_map(|i| radiance[3 * point(i)..][..3].to_vec()).collect();
        let many = World { settings: Settings { samples: 5, ..world.settings.clone() }, ..large };
        let monitor = Monitor::default();
        let (metered, rays) = best(&many).exposure(grid, &monitor).unwrap();
        let expected = meter(&points).unwrap();
        prop_assert_eq!(metered.percentile.is_some(), expected.percentile.is_some());
        prop_assert!((metered.stops - expected.stops).abs() < 1e-3, "{metered:?} is not {expected:?}");
        prop_assert!(rays >= u64::from(grid * grid));
        prop_assert_eq!(monitor.done(), 0);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20))]

    #[test]
    fn any_number_of_threads_gives_the_same_bits(world in any_world()) {
        let tracer = best(&world);
        let window = whole(&world);
        let arrays = on_threads(1, || filmed(&tracer, window));
        let file = on_threads(1, || written(&tracer, window, BitDepth::Eight));
        for threads in [2, 3, 7] {
            let others = on_threads(threads, || filmed(&tracer, window));
            prop_assert_eq!(others.all_bits(), arrays.all_bits(), "{} threads", threads);
            prop_assert_eq!(others.rays, arrays.rays);
            prop_assert_eq!(&on_threads(threads, || written(&tracer, window, BitDepth::Eight)), &file);
        }
    }

    #[test]
    fn the_file_holds_the_developed_film(world in any_world()) {
        let window = whole(&world);
        let tracer = best(&world);
        let radiance = filmed(&tracer, window).radiance;
        for bits in [BitDepth::Eight, BitDepth::Sixteen] {
            let mut expected = vec![0; radiance.len() / 3 * bits.bytes_per_pixel()];
            Developer::new(0.0, ToneCurve::Clip, bits).develop(&radiance, &mut expected);
            let file = written(&tracer, window, bits);
            let mut reader = png::Decoder::new(io::Cursor::new(file)).read_info().unwrap();
            let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut pixels).unwrap();
            prop_assert_eq!(pixels, expected);
        }
    }
}

// --- Pictures whose answer is known -----------------------------------------------------------------------

/// A world seen along -z from the origin.
fn world(width: u32, height: u32, objects: Vec<Object>, lights: Vec<LightDesc>) -> World {
    World {
        camera: Camera::along_z(width, height, 50.0),
        checkers: vec![],
        objects,
        lights,
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

fn grey(position: [f64; 3], shape: ShapeDesc) -> Object {
    Object { position, color: [0.8, 0.5, 0.2], shape }
}

fn light(position: [f64; 3], intensity: f64) -> LightDesc {
    LightDesc { source: LightSource::Point { position, radius: 0.0 }, color: [1.0; 3], intensity, carrier: None }
}

/// The point on the image plane at distance 1, of a pixel of a picture.
fn on_image_plane(world: &World, pixel: usize) -> [f64; 3] {
    let camera = &world.camera;
    let (x, y) = (pixel as u32 % camera.width, pixel as u32 / camera.width);
    let half = camera.half_height / f64::from(camera.height);
    [
        (2.0 * f64::from(x) + 1.0 - f64::from(camera.width)) * half,
        (f64::from(camera.height) - 2.0 * f64::from(y) - 1.0) * half,
        -1.0,
    ]
}

/// radiance = albedo / pi * intensity / (4 pi r^2) * cos(theta)
fn assert_lit(world: &World, point_and_normal: impl Fn([f64; 3]) -> Option<([f64; 3], [f64; 3])>) {
    let arrays = filmed(&best(world), whole(world));
    let light = &world.lights[0];
    let mut seen = 0;
    for pixel in 0..arrays.object_id.len() {
        let Some((point, normal)) = point_and_normal(on_image_plane(world, pixel)) else {
            continue;
        };
        seen += 1;
        let way = crate::vector::sub(light.source.position().unwrap(), point);
        let r = crate::vector::length(way);
        let cosine = crate::vector::dot(normal, way) / r;
        for channel in 0..3 {
            let albedo = world.objects[0].color[channel];
            let expected = albedo / PI * light.intensity / (4.0 * PI * r * r) * cosine.max(0.0);
            let found = f64::from(arrays.radiance[3 * pixel + channel]);
            assert!((found - expected).abs() <= 1e-5 * expected, "pixel {pixel}: {found}, not {expected}");
        }
    }
    assert!(seen > 100);
}

#[test]
fn a_plane_under_a_light_has_the_radiance_of_the_formula() {
    for distance in [1.0, 1e-4, 1e5] {
        let ground = grey([5.0, -distance, 3.0], ShapeDesc::Plane(PlaneDesc { normal: [0.0, 7.0, 0.0] }));
        let above = light([0.3 * distance, 2.0 * distance, -4.0 * distance], 100.0);
        assert_lit(&world(61, 43, vec![ground], vec![above]), |v| {
            let t = -distance / v[1];
            let point = [t * v[0], -distance, t * v[2]];
            (v[1] < 0.0).then_some((point, [0.0, 1.0, 0.0]))
        });
    }
}

/// However far the sun: the light of a light of constant brightness.
#[test]
fn a_light_as_far_as_the_sun_lights_a_scene_of_millimetres() {
    for distance in [1e3, 1e11, 1.5e14] {
        let ground = grey([0.0, -1.0, 0.0], ShapeDesc::Plane(PlaneDesc { normal: [0.0, 1.0, 0.0] }));
        let sun = light([0.0, distance, 0.0], distance * distance);
        assert_lit(&world(61, 43, vec![ground], vec![sun]), |v| {
            let point = [-v[0] / v[1], -1.0, 1.0 / v[1]];
            (v[1] < 0.0).then_some((point, [0.0, 1.0, 0.0]))
        });
    }
}

#[test]
fn a_sphere_lit_from_the_eye_has_the_radiance_of_the_formula() {
    for (distance, radius) in [(3.0, 1.0), (3.0, 2.9999), (1e5, 4e4), (3e-6, 1e-6)] {
        let ball = grey([0.0, 0.0, -distance], ShapeDesc::Sphere(SphereDesc { radius }));
        assert_lit(&world(61, 43, vec![ball], vec![light([0.0; 3], 1.0)]), |v| {
            let vv = crate::vector::dot(v, v);
            // Not where it is just grazed.
            let discriminant = distance * distance - vv * (distance * distance - radius * radius);
            let steep = discriminant > 1e-2 * vv * radius * radius;
            let t = (distance - discriminant.max(0.0).sqrt()) / vv;
            let point = v.map(|x| t * x);
            let normal = [point[0] / radius, point[1] / radius, (point[2] + distance) / radius];
            steep.then_some((point, normal))
        });
    }
}

#[test]
fn nothing_gives_the_background() {
    let mut empty = world(20, 20, vec![], vec![light([0.0; 3], 1.0)]);
    empty.settings.background = [0.1, 0.2, 0.3];
    empty.settings.samples = 3;
    let arrays = filmed(&best(&empty), whole(&empty));
    for pixel in arrays.radiance.chunks_exact(3) {
        assert!(pixel.iter().zip([0.1, 0.2, 0.3]).all(|(x, y)| (x - y).abs() < 1e-7), "{pixel:?}");
    }
    assert_eq!(arrays.rays, 1200);
}

#[test]
fn no_number_is_too_large_or_too_small() {
    let sizes = [1e-300, 1e-160, 1e-40, 1.0, 1e40, 1e160, 1e300];
    for (a, b) in sizes.into_iter().flat_map(|a| sizes.map(|b| (a, b))) {
        let objects = vec![
            grey([0.0, -a, 0.0], ShapeDesc::Plane(PlaneDesc { normal: [a, b, 0.0] })),
            grey([b, 0.0, -3.0 * a], ShapeDesc::Sphere(SphereDesc { radius: a })),
            grey([0.0, b, -3.0 * b], ShapeDesc::Cuboid(CuboidDesc { size: [b, a, b], rotation: [0.0, a, 0.0] })),
            grey([0.0, 0.0, -a], ShapeDesc::Sphere(SphereDesc { radius: b })),
        ];
        let lights = vec![light([a, b, 0.0], a), light([0.0; 3], b)];
        let mut scene = world(20, 20, objects, lights);
        scene.settings.eye_falloff = a > b;
        let arrays = filmed(&best(&scene), whole(&scene));
        for (name, (array, _)) in
            ["radiance", "depth", "distance", "normal", "position"].iter().zip(arrays.floats())
        {
            assert!(array.iter().all(|x| !x.is_nan()), "{name} of {a:e} and {b:e}");
        }
        assert!(arrays.radiance.iter().all(|x| x.is_finite()), "{a:e} and {b:e}");
    }
}

// --- Progress, and giving up ------------------------------------------------------------------------------

fn large_scene() -> World {
    let balls = (0..200).map(|i| {
        let (x, y) = (f64::from(i % 20) - 10.0, f64::from(i / 20) - 5.0);
        grey([x, y, -12.0], ShapeDesc::Sphere(SphereDesc { radius: 0.4 }))
    });
    let mut scene = world(4000, 4000, balls.collect(), vec![light([0.0, 5.0, 0.0], 500.0); 20]);
    scene.settings.samples = 16;
    scene
}

/// A sink that counts what it gets, and looks at the work each time.
struct Watcher<'a, F: FnMut() + Send> {
    look: &'a mut F,
}

impl<F: FnMut() + Send> io::Write for Watcher<'_, F> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        (self.look)();
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn in_the_end_all_pixels_are_done_and_never_more() {
    let scene =
        world(333, 777, vec![grey([0.0, 0.0, -3.0], ShapeDesc::Sphere(SphereDesc { radius: 1.0 }))], vec![]);
    let window = Window { x: 5, y: 9, width: 300, height: 700 };
    let monitor = Monitor::default();
    let mut last = 0;
    let mut look = || {
        let done = monitor.done();
        assert!(last <= done && done <= 210_000);
        last = done;
    };
    let developer = Developer::new(0.0, ToneCurve::Clip, BitDepth::Eight);
    best(&scene)
        .write_png(window, &developer, &[], Compression::Fast, Watcher { look: &mut look }, &monitor)
        .unwrap();
    assert_eq!(monitor.done(), 210_000);
    let monitor = Monitor::default();
    let mut radiance = vec![0.0; 630_000];
    let film = Film::of_radiance(&mut radiance);
    best(&scene).film(window, film, &monitor).unwrap();
    assert_eq!(monitor.done(), 210_000);
}

#[test]
fn what_is_cancelled_before_it_begins_is_not_done() {
    let scene = large_scene();
    let monitor = Monitor::default();
    monitor.cancel();
    let developer = Developer::new(0.0, ToneCurve::Clip, BitDepth::Eight);
    let result = best(&scene).write_png(whole(&scene), &developer, &[], Compression::Fast, io::sink(), &monitor);
    assert!(matches!(result, Err(Stopped::Cancelled)));
    let small = Window { x: 0, y: 0, width: 50, height: 50 };
    let mut radiance = vec![0.0; 7500];
    let film = Film::of_radiance(&mut radiance);
    assert!(matches!(best(&scene).film(small, film, &monitor), Err(Stopped::Cancelled)));
    assert!(matches!(best(&scene).exposure(4, &monitor), Err(Stopped::Cancelled)));
    assert_eq!(monitor.done(), 0);
}

#[test]
fn what_is_cancelled_while_it_is_done_ends_soon() {
    let scene = large_scene();
    let tracer = best(&scene);
    let monitor = Monitor::default();
    let developer = Developer::new(0.0, ToneCurve::Clip, BitDepth::Eight);
    std::thread::scope(|threads| {
        let work = threads
            .spawn(|| tracer.write_png(whole(&scene), &developer, &[], Compression::Fast, io::sink(), &monitor));
        while monitor.done() == 0 {
            std::thread::yield_now();
        }
        monitor.cancel();
        let start = Instant::now();
        assert!(matches!(work.join().unwrap(), Err(Stopped::Cancelled)));
        assert!(start.elapsed() < Duration::from_secs(2), "{:?}", start.elapsed());
    });
    assert!(monitor.done() < 16_000_000);
}

#[test]
fn a_sink_that_fails_is_an_error() {
    struct Full;
    impl io::Write for Full {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            Err(io::ErrorKind::StorageFull.into())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }
    let scene = world(100, 100, vec![], vec![]);
    let developer = Developer::new(0.0, ToneCurve::Clip, BitDepth::Eight);
    let result =
        best(&scene).write_png(whole(&scene), &developer, &[], Compression::Fast, Full, &Monitor::default());
    let Err(Stopped::Io(error)) = result else { panic!("{result:?}") };
    assert_eq!(error.kind(), io::ErrorKind::StorageFull);
}

#[test]
#[should_panic(expected = "the film does not fit the window")]
fn a_film_of_another_size_is_refused() {
    let scene = world(10, 10, vec![], vec![]);
    let mut radiance = [0.0; 3];
    let film = Film::of_radiance(&mut radiance);
    let _ = best(&scene).film(whole(&scene), film, &Monitor::default());
}

/// The levels of a picture and the steps it took, or why it was given up.
fn within(world: &World, level: Level, threads: usize, steps: u64) -> (Result<Vec<f32>, Stopped>, u64) {
    let budget = Arc::new(WorkBudget::new(steps));
    let monitor = Monitor::within(Arc::clone(&budget));
    let window = whole(world);
    let mut radiance = vec![0.0; 3 * window.width as usize * window.height as usize];
    let film = Film::of_radiance(&mut radiance);
    let tracer = Tracer::new(world.clone(), level).unwrap();
    let result = on_threads(threads, || tracer.film(window, film, &monitor));
    (result.map(|_| radiance), budget.spent())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(50))]

    #[test]
    fn whether_a_picture_exceeds_a_budget_depends_on_nothing_but_the_world(world in any_world()) {
        let (expected, steps) = within(&world, Level::best(), 1, u64::MAX);
        let expected = expected.unwrap();
        prop_assert!(steps > 0);
        for level in Level::available() {
            for threads in [1, 2, 5] {
                let (result, spent) = within(&world, level, threads, steps);
                prop_assert_eq!((result.unwrap(), spent), (expected.clone(), steps));
                let (result, spent) = within(&world, level, threads, steps - 1);
                prop_assert!(matches!(result, Err(Stopped::BudgetExceeded)));
                prop_assert!(spent >= steps);
            }
        }
    }
}

/// Planes over each other and lights above them: none is in the tree.
fn many_planes(planes: u32, lights: u32) -> World {
    let mut world = large_scene();
    (world.camera.width, world.camera.height) = (16, 16);
    world.objects = (0..planes)
        .map(|i| Object {
            position: [0.0, -1.0 - f64::from(i), 0.0],
            color: [0.5; 3],
            shape: ShapeDesc::Plane(PlaneDesc { normal: [0.0, 1.0, 0.0] }),
        })
        .collect();
    world.lights = (0..lights)
        .map(|i| LightDesc {
            source: LightSource::Point { position: [f64::from(i), 5.0, -3.0], radius: 0.0 },
            color: [1.0; 3],
            intensity: 1.0,
            carrier: None,
        })
        .collect();
    world
}

#[test]
fn planes_and_lights_count_as_work_too() {
    let steps = |planes, lights| within(&many_planes(planes, lights), Level::best(), 1, u64::MAX).1;
    assert!(steps(1000, 1) > 500 * steps(1, 1));
    assert!(steps(1, 1000) > 200 * steps(1, 1));
    assert!(steps(100, 100) > 1000 * steps(1, 1));
}

#[test]
fn a_picture_ends_soon_after_its_budget() {
    let world = large_scene();
    let (result, spent) = within(&world, Level::best(), 2, 1000);
    assert!(matches!(result, Err(Stopped::BudgetExceeded)));
    assert!(spent < 2500, "{spent}");
    let budget = Arc::new(WorkBudget::new(1000));
    assert!(matches!(
        best(&world).exposure(128, &Monitor::within(Arc::clone(&budget))),
        Err(Stopped::BudgetExceeded)
    ));
    assert!(budget.is_exceeded());
}

#[test]
fn works_in_turn_share_a_budget() {
    let world = many_planes(2, 1);
    let steps = within(&world, Level::best(), 1, u64::MAX).1;
    let budget = Arc::new(WorkBudget::new(2 * steps - 1));
    let tracer = best(&world);
    let once = || {
        let mut radiance = vec![0.0; 3 * 256];
        let film = Film::of_radiance(&mut radiance);
        tracer.film(whole(&world), film, &Monitor::within(Arc::clone(&budget)))
    };
    assert!(once().is_ok());
    assert!(matches!(once(), Err(Stopped::BudgetExceeded)));
}
