//! How long the kernel takes: tracing, developing, building the tree. One thread, the scenes of
//! `benchmarks/scenes.py`.
//!
//! A measurement is of the whole picture, 1920x1080; throughput is in pixels.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use rtcli_tracer::develop::{BitDepth, Developer, ToneCurve};
use rtcli_tracer::png::Compression;
use rtcli_tracer::world::{
    Camera, CapsuleDesc, ConeDesc, CuboidDesc, CylinderDesc, LightDesc, LightSource, Object, PlaneDesc,
    Projection, Settings, ShapeDesc, SphereDesc, Vector, Window, World,
};
use rtcli_tracer::{Film, Level, Monitor, Tracer};
use std::time::Duration;

const WIDTH: u32 = 1920;
const HEIGHT: u32 = 1080;
const PIXELS: usize = WIDTH as usize * HEIGHT as usize;

/// The box of a crowd, from low to high, and the share of it that the spheres fill.
const CROWD_BOX: [(f64, f64); 3] = [(-16.0, 16.0), (-9.0, 9.0), (-49.0, -31.0)];
const CROWD_SHARE_OF_VOLUME: f64 = 0.05;
const CROWD_SIZES: [usize; 3] = [100, 10_000, 100_000];

criterion_group! {
    name = kernel;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(2));
    targets = still_life_by_level, crowds, kinds, emitters, trees, developing, streaming
}
criterion_main!(kernel);

/// Tracing two spheres and a box on a plane, with the instructions of each level.
fn still_life_by_level(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("trace/still life");
    group.throughput(Throughput::Elements(PIXELS as u64));
    for level in Level::available() {
        let tracer = Tracer::new(still_life(), level).expect("there is memory");
        let mut radiance = vec![0.0; 3 * PIXELS];
        group.bench_function(level.name(), |bencher| bencher.iter(|| trace(&tracer, &mut radiance)));
    }
}

/// Tracing more and more spheres of the same total volume.
fn crowds(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("trace/crowd");
    group.throughput(Throughput::Elements(PIXELS as u64));
    for count in CROWD_SIZES {
        let tracer = Tracer::new(crowd(count), Level::best()).expect("there is memory");
        let mut radiance = vec![0.0; 3 * PIXELS];
        group.bench_function(BenchmarkId::from_parameter(count), |bencher| {
            bencher.iter(|| trace(&tracer, &mut radiance));
        });
    }
}

/// Tracing shapes of each kind, which fill about the same share of the picture.
fn kinds(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("trace/crowd of");
    group.throughput(Throughput::Elements(PIXELS as u64));
    for (name, make) in KINDS {
        let tracer = Tracer::new(crowd_of(1_000, make), Level::best()).expect("there is memory");
        let mut radiance = vec![0.0; 3 * PIXELS];
        group.bench_function(name, |bencher| bencher.iter(|| trace(&tracer, &mut radiance)));
    }
}

/// Tracing spheres under a lamp without a size, and under spherical ones of 64 places, from afar and from nearby.
fn emitters(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("trace/lamp");
    group.throughput(Throughput::Elements(PIXELS as u64));
    for (count, (position, radius)) in
        [3_000, 30_000].into_iter().flat_map(|count| LAMPS.map(|lamp| (count, lamp)))
    {
        let mut world = crowd(count);
        world.lights[0].source = LightSource::Point { position, radius };
        let tracer = Tracer::new(world, Level::best()).expect("there is memory");
        let mut radiance = vec![0.0; 3 * PIXELS];
        let name = format!("of radius {radius} at height {}, {count} spheres", position[1]);
        group.bench_function(name, |bencher| bencher.iter(|| trace(&tracer, &mut radiance)));
    }
}

/// Positions and radii of lamps.
const LAMPS: [(Vector, f64); 5] = [
    ([-20.0, 20.0, 0.0], 0.0),
    ([-20.0, 20.0, 0.0], 0.5),
    ([-20.0, 20.0, 0.0], 2.0),
    ([0.0, 14.0, -40.0], 0.0),
    ([0.0, 14.0, -40.0], 2.0),
];

/// Returns a shape about as large as a sphere of a radius, with an axis in any direction.
type Make = fn(f64, Vector) -> ShapeDesc;

const KINDS: [(&str, Make); 5] = [
    ("spheres", |radius, _| ShapeDesc::Sphere(SphereDesc { radius })),
    ("boxes", |radius, [x, y, z]| {
        let rotation = [90.0 * x, 90.0 * y, 90.0 * z];
        ShapeDesc::Cuboid(CuboidDesc { size: [1.6 * radius; 3], rotation })
    }),
    ("cylinders", |radius, axis| {
        ShapeDesc::Cylinder(CylinderDesc { radius: 0.87 * radius, height: 1.75 * radius, axis })
    }),
    ("capsules", |radius, axis| ShapeDesc::Capsule(CapsuleDesc { radius: 0.75 * radius, height: radius, axis })),
    ("cones", |radius, axis| {
        let (radius, height) = (1.2 * radius, 2.4 * radius);
        ShapeDesc::Cone(ConeDesc { radius, top_radius: 0.0, height, axis })
    }),
];

/// Making a world ready: moving it to the eye, and building the tree.
fn trees(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("prepare/crowd");
    for count in CROWD_SIZES {
        let world = crowd(count);
        group.throughput(Throughput::Elements(count as u64));
        group.bench_function(BenchmarkId::from_parameter(count), |bencher| {
            bencher.iter_with_large_drop(|| {
                on_one_thread(|| Tracer::new(world.clone(), Level::best()).expect("there is memory"))
            });
        });
    }
}

/// From radiance to the values of an image, as its caller gets it outside the kernel: without wide vectors.
fn developing(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("develop/still life");
    group.throughput(Throughput::Elements(PIXELS as u64));
    let mut radiance = vec![0.0; 3 * PIXELS];
    trace(&Tracer::new(still_life(), Level::best()).expect("there is memory"), &mut radiance);
    for bits in [BitDepth::Eight, BitDepth::Sixteen] {
        let developer = Developer::new(0.0, ToneCurve::Clip, bits);
        let mut pixels = vec![0; PIXELS * bits.bytes_per_pixel()];
        group.bench_function(format!("{} bits", 8 * bits.bytes_per_pixel() / 3), |bencher| {
            bencher.iter(|| developer.develop(&radiance, &mut pixels));
        });
    }
}

/// From a scene to the bytes of a file: tracing, developing and encoding.
fn streaming(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("picture/still life");
    group.throughput(Throughput::Elements(PIXELS as u64));
    let tracer = Tracer::new(still_life(), Level::best()).expect("there is memory");
    for bits in [BitDepth::Eight, BitDepth::Sixteen] {
        let developer = Developer::new(0.0, ToneCurve::Clip, bits);
        group.bench_function(format!("{} bits", 8 * bits.bytes_per_pixel() / 3), |bencher| {
            bencher.iter(|| {
                on_one_thread(|| {
                    tracer.write_png(
                        WINDOW,
                        &developer,
                        &[],
                        Compression::Fast,
                        std::io::sink(),
                        &Monitor::default(),
                    )
                })
            });
        });
    }
}

const WINDOW: Window = Window { x: 0, y: 0, width: WIDTH, height: HEIGHT };

fn trace(tracer: &Tracer, radiance: &mut [f32]) -> u64 {
    let film = Film::of_radiance(radiance);
    on_one_thread(|| tracer.film(WINDOW, film, &Monitor::default()).expect("nobody cancels"))
}

fn on_one_thread<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    pool.expect("a thread can be started").install(work)
}

fn still_life() -> World {
    World {
        camera: camera([0.0, 8.0, 26.0], [0.0, 2.5, 0.0], 30.0),
        checkers: vec![],
        objects: vec![
            object([0.0, 0.0, 0.0], [0.8, 0.75, 0.7], ShapeDesc::Plane(PlaneDesc { normal: [0.0, 1.0, 0.0] })),
            object([-4.0, 3.0, 0.0], [0.9, 0.25, 0.15], ShapeDesc::Sphere(SphereDesc { radius: 3.0 })),
            object([1.0, 1.5, 5.0], [0.2, 0.45, 0.9], ShapeDesc::Sphere(SphereDesc { radius: 1.5 })),
            object(
                [4.5, 3.0, -2.0],
                [0.3, 0.8, 0.35],
                ShapeDesc::Cuboid(CuboidDesc { size: [4.0, 6.0, 4.0], rotation: [0.0, 30.0, 0.0] }),
            ),
        ],
        lights: vec![light([-8.0, 14.0, 10.0], 12000.0)],
        settings: settings(),
    }
}

fn crowd(count: usize) -> World {
    crowd_of(count, KINDS[0].1)
}

fn crowd_of(count: usize, make: Make) -> World {
    // Volume V of N spheres: r = (3 V / (4 pi N))^(1/3)
    let volume: f64 = CROWD_SHARE_OF_VOLUME * CROWD_BOX.iter().map(|(low, high)| high - low).product::<f64>();
    let radius = (3.0 * volume / (4.0 * std::f64::consts::PI * count as f64)).cbrt();
    let mut random = Random(1);
    let objects = (0..count)
        .map(|_| {
            let position = CROWD_BOX.map(|(low, high)| random.between(low + radius, high - radius));
            let axis = position.map(|x| (97.0 * x).sin());
            object(position, [random.between(0.2, 0.9), 0.5, 0.5], make(radius, axis))
        })
        .collect();
    let fov = 2.0 * f64::atan2(CROWD_BOX[1].1, -CROWD_BOX[2].1).to_degrees();
    World {
        camera: camera([0.0; 3], [0.0, 0.0, -1.0], fov),
        checkers: vec![],
        objects,
        lights: vec![light([-20.0, 20.0, 0.0], 80000.0)],
        settings: settings(),
    }
}

fn settings() -> Settings {
    Settings {
        samples: 1,
        background: [0.0; 3],
        ambient: [0.0; 3],
        direct_light: true,
        shadow_samples: 64,
        eye_falloff: false,
    }
}

fn object(position: Vector, color: Vector, shape: ShapeDesc) -> Object {
    Object { position, color, shape }
}

fn light(position: Vector, intensity: f64) -> LightDesc {
    LightDesc { source: LightSource::Point { position, radius: 0.0 }, color: [1.0; 3], intensity, carrier: None }
}

/// A camera with y up that looks at a point straight ahead of it, above or below.
fn camera(position: Vector, look_at: Vector, fov: f64) -> Camera {
    let (y, z) = (look_at[1] - position[1], look_at[2] - position[2]);
    let distance = y.hypot(z);
    let (y, z) = (y / distance, z / distance);
    Camera {
        width: WIDTH,
        height: HEIGHT,
        projection: Projection::Perspective,
        half_height: (fov.to_radians() / 2.0).tan(),
        pixel_aspect: 1.0,
        center: (0.0, 0.0),
        position,
        right: [-z.signum(), 0.0, 0.0],
        up: [0.0, -z, y],
        forward: [0.0, y, z],
    }
}

/// Numbers without a pattern (G. Steele et al., "Fast Splittable Pseudorandom Number Generators", 2014:
/// SplitMix64).
struct Random(u64);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        low + (high - low) * ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}
