//! One tile of the picture, from rays to radiance.

use crate::accel::Stack;
use crate::accel::cone::Cone;
use crate::budget::steps_of;
use crate::sampling::sample_offsets;
use crate::scene::Scene;
use crate::shading::Lighting;
use crate::shapes::points::Points;
use crate::shapes::primitive::Primitive;
use crate::tile::hits::{FACE_BITS, HitBuffer, NO_FACE};
use crate::tile::rays::Rays;
use crate::tile::{CENTRE, LANES, Lanes, Tile};
use crate::trace::depth_resolver::DepthResolver;
use crate::trace::groups::{Group, Groups};
use crate::vector::to_f32;
use crate::world::Settings;

/// The result of one tile, and working memory.
#[derive(Debug)]
pub(crate) struct TileTracer {
    /// The radiance of the last sample: red, green and blue.
    radiance: [Lanes; 3],
    /// The sum of each pixel's samples if there are several: in float64, so that it neither overflows nor loses
    /// digits of the mean.
    total: Option<Box<[[f64; LANES]; 3]>>,
    /// The number of each pixel's samples that hit something, if requested.
    hit_counts: Option<Box<[u32; LANES]>>,
    /// The offset of each sample in a pixel.
    offsets: Vec<(f64, f64)>,
    /// Whether the last rays go through the pixel centres, so that `hits`, `rays` and `surface` are ground truth.
    with_passes: bool,
    /// The hits at the pixel centres, if passes are requested.
    pub(crate) hits: HitBuffer,
    /// The rays through the pixel centres.
    pub(crate) rays: Rays,
    /// The points and normals at the pixel centres, in camera space, if requested.
    pub(crate) surface: Option<Box<Surface>>,
    /// The number of primary and shadow rays traced for the requested pixels.
    pub(crate) traced: u64,
    groups: Groups,
    resolver: DepthResolver,
    /// The rays of a group smaller than the tile, and their radiance.
    group_rays: Rays,
    group_radiance: [Lanes; 3],
    lighting: Lighting,
    /// Counts the work of the tile.
    pub(crate) stack: Stack,
}

/// The data at the pixel centres that passes need; each level includes those before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum PassRequest {
    Radiance,
    /// Faces and depths.
    Hits,
    /// Points and normals too, which take longer.
    Surface,
}

/// Ground truth at the pixel centres of a tile.
#[derive(Debug)]
pub(crate) struct Surface {
    /// Points, relative to the eye.
    pub(crate) position: [[f64; LANES]; 3],
    /// Unit normals that face the eye.
    pub(crate) normal: [Lanes; 3],
    /// 1 for the points on the squares of a checker's color, if their object has a checker.
    pub(crate) odd: [u32; LANES],
}

const ZERO: Lanes = [0.0; LANES];

impl TileTracer {
    pub(crate) fn new(request: PassRequest, with_alpha: bool) -> TileTracer {
        let with_surface = request == PassRequest::Surface;
        TileTracer {
            radiance: [ZERO; 3],
            total: None,
            hit_counts: with_alpha.then(|| Box::new([0; LANES])),
            offsets: Vec::new(),
            with_passes: request != PassRequest::Radiance,
            hits: HitBuffer::new(),
            rays: Rays::new(),
            surface: with_surface
                .then(|| Box::new(Surface { position: [[0.0; LANES]; 3], normal: [ZERO; 3], odd: [0; LANES] })),
            traced: 0,
            groups: Groups::new(),
            resolver: DepthResolver::new(),
            group_rays: Rays::new(),
            group_radiance: [ZERO; 3],
            lighting: Lighting::new(),
            stack: Stack::default(),
        }
    }

    /// Trace all samples of the tile, unless `cancelled` returns true or the work of `stack` exceeds its limit.
    #[inline(always)]
    pub(crate) fn trace(&mut self, scene: &Scene, settings: &Settings, tile: Tile, cancelled: impl Fn() -> bool) {
        self.traced = 0;
        if self.offsets.len() != settings.samples as usize {
            self.offsets = sample_offsets(settings.samples);
            self.total = (settings.samples > 1).then(|| Box::new([[0.0; LANES]; 3]));
        }
        if let Some(total) = &mut self.total {
            **total = [[0.0; LANES]; 3];
        }
        if let Some(counts) = &mut self.hit_counts {
            **counts = [0; LANES];
        }
        // A single sample goes through the centre: its hits are the ground truth. Several, or none, are followed by one
        // for that.
        let samples = self.offsets.len();
        for sample in 0..samples + usize::from(self.with_passes && samples != 1) {
            if cancelled() {
                return;
            }
            self.radiance = [ZERO; 3];
            self.find_hits(scene, tile, self.offsets.get(sample).copied().unwrap_or(CENTRE));
            let is_sample = sample < samples;
            if let Some(counts) = self.hit_counts.as_mut().filter(|_| is_sample) {
                for (count, &face) in counts.iter_mut().zip(&self.hits.face) {
                    *count += u32::from(face != NO_FACE);
                }
            }
            for group in 0..self.groups.list.len() {
                self.shade(scene, settings, group, (is_sample, samples == 1 || !is_sample));
                if self.stack.work.ran_out() {
                    return;
                }
            }
            if let Some(total) = self.total.as_mut().filter(|_| is_sample) {
                add(total, &self.radiance);
            }
        }
    }

    /// Find the nearest hits of the rays at an offset `within` each pixel, and group them by face.
    #[inline(always)]
    fn find_hits(&mut self, scene: &Scene, tile: Tile, within: (f64, f64)) {
        self.rays.generate(tile.view, tile.corner, within);
        self.stack.steps_per_object = steps_of(LANES);
        // Planes are in no tree: each tile tests all of them.
        if !self.stack.work.take((1 + scene.unbounded.len() as u64) * steps_of(LANES)) {
            self.groups.list.clear();
            return;
        }
        nearest_hits(scene, &self.rays, &mut self.hits, &mut self.stack);
        if self.hits.close > 0 {
            self.resolver.resolve(scene, &self.rays, &mut self.hits, &mut self.stack);
        }
        self.groups.collect(&self.hits, tile);
    }

    /// Write the mean radiance of each pixel's samples as RGB triples, from the pixel of `lane` on.
    #[inline(always)]
    pub(crate) fn mean_radiance(&self, lane: usize, rgb: &mut [f32]) {
        let count = rgb.len() / 3;
        assert!(lane + count <= LANES);
        for i in 0..count {
            for channel in 0..3 {
                rgb[3 * i + channel] = match &self.total {
                    None => clamp_to_finite(self.radiance[channel][lane + i]),
                    Some(total) => (total[channel][lane + i] / self.offsets.len() as f64) as f32,
                };
            }
        }
    }

    /// The share of each pixel's samples that hit something, if requested.
    #[inline(always)]
    pub(crate) fn alpha(&self) -> Option<Lanes> {
        let samples = self.offsets.len() as f32;
        self.hit_counts.as_ref().map(|counts| counts.map(|count| count as f32 / samples))
    }

    /// Add the radiance of one group of rays, which hit the same face, if they are a sample's; record the points and
    /// normals, if requested, if they go through the pixel centres.
    #[inline(always)]
    fn shade(&mut self, scene: &Scene, settings: &Settings, group: usize, (is_sample, is_central): (bool, bool)) {
        let Group { face, t, .. } = self.groups.list[group];
        let lanes = self.groups.lanes(group);
        if is_sample {
            self.traced += lanes.len() as u64;
        }
        if face == NO_FACE {
            fill(&mut self.radiance, lanes, to_f32(settings.background));
            return;
        }
        let object = face >> FACE_BITS;
        let emitted = scene.emitted(object);
        if let Some(radiance) = emitted {
            fill(&mut self.radiance, lanes, radiance);
        }
        let lit = is_sample && settings.direct_light && emitted.is_none();
        let surface = self.surface.as_mut().filter(|_| is_central);
        if lanes.is_empty() || !(lit || surface.is_some()) {
            return;
        }
        // Each light, or place of an emitter, visits the points and all planes; traversals of the tree count their own steps.
        let steps = steps_of(lanes.len());
        let per_light = steps * (1 + scene.unbounded.len() as u64);
        if lit && !self.stack.work.take(per_light.saturating_mul(scene.pencils)) {
            return;
        }
        self.stack.steps_per_object = steps;
        let whole = lanes.len() == LANES;
        if !whole {
            self.group_rays.pick(&self.rays, lanes);
        }
        let rays = if whole { &self.rays } else { &self.group_rays };
        let shape = scene.shapes.get(object);
        let depth = (f64::from(t), || self.rays.exact(self.hits.lane(face, t)));
        shape.compute_points(face, rays, depth, &mut self.lighting.points);
        // The eye is known to within the rounding of its coordinates, and so are points relative to it.
        self.lighting.points.error += scene.coordinate_rounding as f32;
        if let Some(checker) = scene.checker(object) {
            checker.mark(face, &mut self.lighting.points);
        }
        if let Some(surface) = surface {
            surface.record(lanes, &self.lighting.points);
        }
        if !lit {
            return;
        }
        // Swapped in rather than passed as `&mut`: a second mutable reference stops the compiler from vectorizing
        // (5x slower).
        std::mem::swap(&mut self.stack, &mut self.lighting.stack);
        if !whole {
            gather(&self.radiance, lanes, &mut self.group_radiance);
        }
        let radiance = if whole { &mut self.radiance } else { &mut self.group_radiance };
        self.traced += self.lighting.accumulate_direct(scene, settings, face, radiance);
        if !whole {
            for (to, from) in self.radiance.iter_mut().zip(&self.group_radiance) {
                scatter(to, lanes, |i| from[i]);
            }
        }
        std::mem::swap(&mut self.stack, &mut self.lighting.stack);
    }
}

impl Surface {
    /// Record the points of a group.
    #[inline(always)]
    fn record(&mut self, lanes: &[u8], points: &Points) {
        for axis in 0..3 {
            let (reference, offset) = (points.reference[axis], &points.offset[axis]);
            scatter(&mut self.position[axis], lanes, |i| reference + f64::from(offset[i]));
            match points.plane {
                Some(plane) => scatter(&mut self.normal[axis], lanes, |_| plane.normal[axis] as f32),
                None => scatter(&mut self.normal[axis], lanes, |i| points.normal[axis][i]),
            }
        }
        if points.checkered {
            scatter(&mut self.odd, lanes, |i| points.odd[i]);
        }
    }
}

/// Write one value to each lane of a group.
#[inline(always)]
fn scatter<T>(to: &mut [T; LANES], lanes: &[u8], value: impl Fn(usize) -> T) {
    if lanes.len() == LANES {
        // In order, so that the loop vectorizes.
        for (i, to) in to.iter_mut().enumerate() {
            *to = value(i);
        }
    } else {
        for (i, &lane) in lanes.iter().enumerate() {
            to[usize::from(lane)] = value(i);
        }
    }
}

/// Find the nearest hits of the rays of a tile.
#[inline(always)]
fn nearest_hits(scene: &Scene, rays: &Rays, hits: &mut HitBuffer, stack: &mut Stack) {
    hits.clear(rays);
    let cone = Cone::of_tile(rays);
    let mut traversal = scene.bvh.traverse(&cone, stack);
    let mut limit = f32::INFINITY;
    while let Some(object) = traversal.next(limit) {
        scene.shapes.get_bounded(object).intersect(object << FACE_BITS, rays, hits);
        limit = cone.along_axis(rays, hits.farthest());
    }
    for &object in &scene.unbounded {
        scene.shapes.get_unbounded(object).intersect(object << FACE_BITS, rays, hits);
    }
}

/// Clamp radiance to finite values: NaN, from 0 * inf, becomes 0, and infinity the largest float32.
#[inline(always)]
fn clamp_to_finite(radiance: f32) -> f32 {
    let radiance = if radiance > 0.0 { radiance } else { 0.0 };
    if radiance < f32::MAX { radiance } else { f32::MAX }
}

/// Add the radiance of a sample.
#[inline(always)]
fn add(total: &mut [[f64; LANES]; 3], radiance: &[Lanes; 3]) {
    for (total, radiance) in total.iter_mut().zip(radiance) {
        for (total, &radiance) in total.iter_mut().zip(radiance) {
            *total += f64::from(clamp_to_finite(radiance));
        }
    }
}

/// Add the same radiance to some lanes.
#[inline(always)]
fn fill(radiance: &mut [Lanes; 3], lanes: &[u8], value: [f32; 3]) {
    for (channel, value) in radiance.iter_mut().zip(value) {
        if lanes.len() == LANES {
            channel.iter_mut().for_each(|lane| *lane += value);
        } else {
            lanes.iter().for_each(|&lane| channel[usize::from(lane)] += value);
        }
    }
}

#[inline(always)]
fn gather(from: &[Lanes; 3], lanes: &[u8], to: &mut [Lanes; 3]) {
    for (to, from) in to.iter_mut().zip(from) {
        for (to, &lane) in to.iter_mut().zip(lanes) {
            *to = from[usize::from(lane)];
        }
    }
}
