//! Whole pictures, on all cores: into arrays, or to a file while they are traced.

use crate::memory::{OutOfMemory, collect, filled, resize, spare};
use crate::monitor::{Monitor, Stopped};
use crate::output::develop::Developer;
use crate::output::film::{CameraToWorld, Film, FilmSink, Pass, Values};
use crate::output::meter::{MeterReading, meter};
use crate::output::png::{Color, Compression, Header, PngWriter};
use crate::output::rle::{self, Mask};
use crate::scene::Scene;
use crate::simd::{Kernel, Level};
use crate::tile::{LANES, SIDE, Tile, View};
use crate::trace::coverage::{AmodalMask, Coverage};
use crate::trace::tile_tracer::{PassRequest, TileTracer};
use crate::world::{Camera, Objects, Settings, Window, World};
use rayon::prelude::*;
use std::io;
use std::mem::swap;
use std::time::{Duration, Instant};

/// The rays of a picture, and the times of all threads together.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RenderStats {
    /// Primary and shadow rays.
    pub rays: u64,
    /// Time for tracing.
    pub trace: Duration,
    /// Time for exposure, tone curve and sRGB.
    pub develop: Duration,
    /// Time for encoding and writing.
    pub write: Duration,
}

/// The most bytes of developed pixels waiting to be written.
const MOST_WAITING: usize = 64 << 20;

/// Objects whose coverage one thread counts at a time.
const OBJECTS: usize = 16;

/// The most steps to find the coverage for metadata and labels, about a second on two cores; 100,000 spheres apart from
/// each other take a sixth of them.
pub const COVERAGE_STEPS: u64 = 120_000_000;

/// Named in the error if memory runs out.
const BANDS: &str = "the bands of the picture";
const COVERAGE: &str = "counting what objects cover";

/// Bytes of a pixel of three 16-bit values.
const MOST_BYTES: usize = 6;

/// A world ready for tracing.
#[derive(Debug)]
pub struct Tracer {
    camera: Camera,
    settings: Settings,
    scene: Scene,
    level: Level,
}

impl Tracer {
    /// Transform a world to camera space, and build a tree over its objects.
    ///
    /// # Errors
    ///
    /// If memory runs out.
    pub fn new(world: World<impl Objects>, level: Level) -> Result<Tracer, OutOfMemory> {
        spare()?;
        Ok(Tracer { scene: Scene::new(&world)?, camera: world.camera, settings: world.settings, level })
    }

    /// Trace the pixels of a window with the threads of the current rayon pool; return the number of rays.
    ///
    /// # Errors
    ///
    /// If the work is cancelled, exceeds its budget, or runs out of memory.
    ///
    /// # Panics
    ///
    /// If the arrays of the film do not fit the window, or the window is not inside the picture.
    pub fn film(&self, window: Window, film: Film<'_>, monitor: &Monitor) -> Result<u64, Stopped> {
        assert!(film.holds(window), "the film does not fit the window");
        Ok(self.film_of(self.job(monitor), window, film)?.rays)
    }

    /// Meter the whole picture at `grid` x `grid` points; return the reading and the number of rays.
    ///
    /// # Errors
    ///
    /// If the work is cancelled, exceeds its budget, or runs out of memory.
    pub fn exposure(&self, grid: u32, monitor: &Monitor) -> Result<(MeterReading, u64), Stopped> {
        let mut radiance = filled(3 * grid as usize * grid as usize, 0.0, "the exposure meter")?;
        let film = Film::of_radiance(&mut radiance);
        let settings = Settings { samples: 1, ..self.settings.clone() };
        let window = Window { x: 0, y: 0, width: grid, height: grid };
        let job = TileJob {
            view: View::in_grid(&self.camera, self.scene.unit, grid),
            settings: &settings,
            monitor: &monitor.aside(),
        };
        let stats = self.film_of(job, window, film)?;
        Ok((meter(&radiance)?, stats.rays))
    }

    /// Count the pixel centres of a window that each object would cover if it were alone, with the threads of the
    /// current rayon pool.
    ///
    /// # Errors
    ///
    /// If the work is cancelled, exceeds its budget, or runs out of memory.
    pub fn coverage(&self, window: Window, monitor: &Monitor) -> Result<Vec<u64>, Stopped> {
        let view = View::new(&self.camera, self.scene.unit);
        let mut covered = filled(self.scene.shapes.len(), 0, COVERAGE)?;
        spare()?;
        covered.par_chunks_mut(OBJECTS).enumerate().for_each(|(i, covered)| {
            let first = (i * OBJECTS) as u32;
            self.level.run(Coverage { shapes: &self.scene.shapes, first, view, window, monitor, covered });
        });
        monitor.check()?;
        let mut in_order = filled(covered.len(), 0, COVERAGE)?;
        for (&number, covered) in self.scene.numbers.iter().zip(covered) {
            in_order[number as usize] = covered;
        }
        Ok(in_order)
    }

    /// Return the mask of each of some objects, as if it were alone in the picture.
    ///
    /// # Errors
    ///
    /// If the work is cancelled, exceeds its budget, or runs out of memory.
    ///
    /// # Panics
    ///
    /// If there is no such object.
    pub fn amodal_masks(&self, window: Window, objects: &[u32], monitor: &Monitor) -> Result<Vec<Mask>, Stopped> {
        let view = View::new(&self.camera, self.scene.unit);
        let mut mask = filled(window.pixels(), 0, "a mask")?;
        let mut masks = Vec::new();
        for &object in objects {
            let index = self.scene.numbers.iter().position(|&number| number == object).expect("an object");
            let shape = self.scene.shapes.get(index as u32);
            mask.fill(0);
            self.level.run(AmodalMask { shape, view, window, monitor, mask: &mut mask });
            monitor.check()?;
            masks.push(rle::mask(&mask, window.width as usize));
        }
        Ok(masks)
    }

    /// The job of the whole picture.
    fn job<'a>(&'a self, monitor: &'a Monitor) -> TileJob<'a> {
        TileJob { view: View::new(&self.camera, self.scene.unit), settings: &self.settings, monitor }
    }

    fn film_of(&self, job: TileJob<'_>, window: Window, mut film: Film<'_>) -> Result<RenderStats, Stopped> {
        let request = film.request(&self.scene);
        let with_alpha = film.records_alpha();
        let centres_only = Settings { samples: 0, ..job.settings.clone() };
        let job = if film.records_samples() { job } else { TileJob { settings: &centres_only, ..job } };
        let new_tracer = || TileTracer::new(request, with_alpha);
        let with_film = |band: Window| (band, film.split_off(band.pixels()));
        let bands = collect(bands_of(window).map(with_film), BANDS)?;
        spare()?;
        let to_world = CameraToWorld::new(&self.scene, &self.camera);
        let RenderStats { rays, trace, develop, .. } = bands
            .into_par_iter()
            .map_init(new_tracer, |tracer, (window, film)| {
                self.trace(job, window, tracer, TileSink::Film(FilmSink { film, to_world }))
            })
            .reduce(RenderStats::default, RenderStats::plus);
        job.monitor.check()?;
        // A film takes values as they are.
        Ok(RenderStats { rays, trace: trace + develop, ..RenderStats::default() })
    }

    /// Trace the tiles of a band, for one thread.
    fn trace(&self, job: TileJob<'_>, window: Window, tracer: &mut TileTracer, sink: TileSink<'_>) -> RenderStats {
        let mut stats = RenderStats::default();
        self.level.run(Band { scene: &self.scene, job, window, tracer, stats: &mut stats, sink });
        stats
    }

    /// Trace and develop the pixels of a window with the threads of the current rayon pool, and write them as a
    /// PNG file that begins with `texts`: each batch of rows is written while the next one is traced.
    ///
    /// # Errors
    ///
    /// If the work is cancelled, exceeds its budget, or runs out of memory, or if `sink` fails.
    ///
    /// # Panics
    ///
    /// If the window is not inside the picture.
    pub fn write_png(
        &self,
        window: Window,
        developer: &Developer,
        texts: &[(String, String)],
        compression: Compression,
        sink: impl io::Write + Send,
        monitor: &Monitor,
    ) -> Result<RenderStats, Stopped> {
        let header = Header {
            width: window.width,
            height: window.height,
            color: Color::Srgb,
            bits: developer.bits(),
            texts,
        };
        let mut writer = PngWriter::new(sink, header, compression)?;
        let mut stats = RenderStats::default();
        let row = window.width as usize * developer.bytes_per_pixel();
        let most = (MOST_WAITING / (row * SIDE as usize)).max(1);
        let bands = collect(bands_of(window), BANDS)?;
        // Two alternating buffers: new memory would cost a page fault for each 4 KiB.
        let (mut pixels, mut written) = (Vec::new(), Vec::new());
        for batch in bands.chunks(most.min(4 * rayon::current_num_threads())) {
            let rows: u32 = batch.iter().map(|band| band.height).sum();
            resize(&mut pixels, row * rows as usize, 0, "rows of the picture")?;
            spare()?;
            let (traced, result) = rayon::join(
                || self.develop(batch, developer, &mut pixels, monitor),
                || writer.write_rows(&written),
            );
            stats = stats.plus(traced);
            result?;
            monitor.check()?;
            swap(&mut pixels, &mut written);
        }
        writer.write_rows(&written)?;
        stats.write = writer.encoding();
        writer.finish()?;
        Ok(stats)
    }

    /// Trace and develop the pixels of a window with the threads of the current rayon pool; with alpha, each pixel has a
    /// fourth value, by which its color is not multiplied. Return them with the rays and times.
    ///
    /// # Errors
    ///
    /// If the work is cancelled, exceeds its budget, or runs out of memory.
    ///
    /// # Panics
    ///
    /// If the window is not inside the picture.
    pub fn levels(
        &self,
        window: Window,
        developer: &Developer,
        with_alpha: bool,
        monitor: &Monitor,
    ) -> Result<(Vec<u8>, RenderStats), Stopped> {
        let pixels = window.pixels();
        let mut radiance = filled(3 * pixels, 0.0, "the radiance")?;
        let mut alpha = filled(if with_alpha { pixels } else { 0 }, 0.0, "alpha")?;
        let mut film = Film::of_radiance(&mut radiance);
        if with_alpha {
            film = film.with(Pass::Alpha, Values::Floats(&mut alpha));
        }
        let stats = self.film_of(self.job(monitor), window, film)?;
        let start = Instant::now();
        let channel = developer.bits().bytes();
        let bytes = developer.bytes_per_pixel() + if with_alpha { channel } else { 0 };
        let mut levels = filled(pixels * bytes, 0, "rows of the picture")?;
        if with_alpha {
            developer.develop_straight(&mut radiance, &alpha, &mut levels);
        } else {
            developer.develop(&radiance, &mut levels);
        }
        Ok((levels, RenderStats { develop: start.elapsed(), ..stats }))
    }

    /// Trace and develop consecutive bands.
    fn develop(
        &self,
        bands: &[Window],
        developer: &Developer,
        mut pixels: &mut [u8],
        monitor: &Monitor,
    ) -> RenderStats {
        let job = self.job(monitor);
        let part = |&band: &Window| {
            let bytes = band.pixels() * developer.bytes_per_pixel();
            (band, pixels.split_off_mut(..bytes).expect("the pixels of all bands"))
        };
        let parts: Vec<_> = bands.iter().map(part).collect();
        parts
            .into_par_iter()
            .map_init(
                || TileTracer::new(PassRequest::Radiance, false),
                |tracer, (window, pixels)| {
                    self.trace(job, window, tracer, TileSink::Pixels(PixelSink { developer, pixels }))
                },
            )
            .reduce(RenderStats::default, RenderStats::plus)
    }
}

impl RenderStats {
    fn plus(self, other: RenderStats) -> RenderStats {
        RenderStats {
            rays: self.rays + other.rays,
            trace: self.trace + other.trace,
            develop: self.develop + other.develop,
            write: self.write + other.write,
        }
    }
}

/// The rows of tiles of a window: the unit of work of a thread.
fn bands_of(window: Window) -> impl Iterator<Item = Window> {
    let bottom = window.y + window.height;
    let first = window.y - window.y % SIDE;
    (first..bottom).step_by(SIDE as usize).map(move |top| {
        let y = top.max(window.y);
        Window { y, height: (top + SIDE).min(bottom) - y, ..window }
    })
}

/// The view, settings and monitor of all tiles of a picture.
#[derive(Clone, Copy)]
struct TileJob<'a> {
    view: View,
    settings: &'a Settings,
    monitor: &'a Monitor,
}

/// The tiles of a band, traced one after the other.
struct Band<'a> {
    scene: &'a Scene,
    job: TileJob<'a>,
    window: Window,
    tracer: &'a mut TileTracer,
    stats: &'a mut RenderStats,
    sink: TileSink<'a>,
}

/// Every eighth tile is timed: reading the clock takes a tenth of the time of a tile.
const TIMED: u32 = 8;

impl Kernel for Band<'_> {
    #[inline(always)]
    fn run(mut self) {
        let TileJob { view, settings, monitor } = self.job;
        let start = Instant::now();
        let (mut tiles, mut timed) = (0, Duration::ZERO);
        for tile in Tile::all(view, self.window) {
            if monitor.check().is_err() {
                return;
            }
            self.tracer.stack.work = monitor.budget.counter();
            self.tracer.trace(self.scene, settings, tile, || monitor.cancelled());
            monitor.budget.spend(self.tracer.stack.work);
            let traced = (tiles % TIMED == 0).then(Instant::now);
            self.sink.take(self.tracer, tile);
            timed += traced.map_or(Duration::ZERO, |traced| traced.elapsed());
            tiles += 1;
            self.stats.rays += self.tracer.traced;
            let pixels: usize = tile.spans().map(|span| span.count).sum();
            monitor.add(pixels as u64);
        }
        let elapsed = start.elapsed();
        let develop = timed.mul_f64(f64::from(tiles) / f64::from(tiles.div_ceil(TIMED).max(1)));
        self.stats.develop = develop.min(elapsed);
        self.stats.trace = elapsed - self.stats.develop;
    }
}

/// The destination of traced tiles.
#[expect(clippy::large_enum_variant, reason = "there is one for each band")]
enum TileSink<'a> {
    Film(FilmSink<'a>),
    Pixels(PixelSink<'a>),
}

impl TileSink<'_> {
    #[inline(always)]
    fn take(&mut self, traced: &TileTracer, tile: Tile) {
        match self {
            TileSink::Film(sink) => sink.take(traced, tile),
            TileSink::Pixels(sink) => sink.take(traced, tile),
        }
    }
}

/// Develops to the values of an image file.
struct PixelSink<'a> {
    developer: &'a Developer,
    pixels: &'a mut [u8],
}

impl PixelSink<'_> {
    #[inline(always)]
    fn take(&mut self, traced: &TileTracer, tile: Tile) {
        let size = self.developer.bytes_per_pixel();
        let mut rgb = [0.0; 3 * LANES];
        traced.mean_radiance(0, &mut rgb);
        let mut developed = [0; MOST_BYTES * LANES];
        let developed = &mut developed[..size * LANES];
        self.developer.develop(&rgb, developed);
        for span in tile.spans() {
            let from = &developed[span.lane * size..(span.lane + span.count) * size];
            self.pixels[span.pixel * size..(span.pixel + span.count) * size].copy_from_slice(from);
        }
    }
}

#[cfg(test)]
mod tests;
