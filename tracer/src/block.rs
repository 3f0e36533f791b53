//! One block of the picture: what is seen in it, and the light that comes from there.

use crate::budget::{WorkMeter, steps_of};
use crate::bvh::{Cone, Stack};
use crate::grid::{FACE_BITS, LANES, Lanes, NOTHING, Nearest, Rays};
use crate::groups::{Group, Groups};
use crate::lighting::Lighting;
use crate::place::Place;
use crate::plane::Plane;
use crate::points::Points;
use crate::sampling::sample_offsets;
use crate::scene::Scene;
use crate::settle::Settler;
use crate::vector::single;
use crate::world::Settings;

/// The result of one block, and the room to work in.
#[derive(Debug)]
pub(crate) struct Block {
    /// Linear radiance of red, green and blue, row by row, of the last sample.
    radiance: [Lanes; 3],
    /// The sum of each pixel's samples if there are several: in float64, where it loses nothing that the mean shows
    /// and does not overflow.
    total: Option<Box<[[f64; LANES]; 3]>>,
    /// Where in each pixel they go.
    offsets: Vec<(f64, f64)>,
    /// Whether the last rays go through the pixel centres, so that `nearest`, `rays` and `surface` are ground truth.
    with_truth: bool,
    /// What is met at the pixel centres, with ground truth.
    pub(crate) nearest: Nearest,
    /// The rays through the pixel centres.
    pub(crate) rays: Rays,
    /// Where the rays through the pixel centres end and with which normal, in the camera's space; only if wanted.
    pub(crate) surface: Option<Box<Surface>>,
    /// How many rays were traced for the wanted pixels, primary and shadow rays.
    pub(crate) traced: u64,
    groups: Groups,
    /// To tell faces apart that are close to each other.
    settler: Settler,
    /// Of a group that is not the whole block: its rays, and their radiance.
    some_rays: Rays,
    some_radiance: [Lanes; 3],
    lighting: Lighting,
    stack: Stack,
}

/// What is wanted of a block beside radiance, at the pixel centres.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Truth {
    Unwanted,
    /// What is met, and how far away.
    Hits,
    /// Points and normals too, which take time to find.
    AndSurface,
}

/// The place in a pixel where ground truth is taken.
const CENTRE: (f64, f64) = (0.5, 0.5);

/// Ground truth at the pixel centres of a block.
#[derive(Debug)]
pub(crate) struct Surface {
    /// Points, relative to the eye.
    pub(crate) position: [[f64; LANES]; 3],
    /// Unit normals that face the eye.
    pub(crate) normal: [Lanes; 3],
}

const ZERO: Lanes = [0.0; LANES];

impl Block {
    pub(crate) fn new(truth: Truth) -> Block {
        let with_surface = truth == Truth::AndSurface;
        Block {
            radiance: [ZERO; 3],
            total: None,
            offsets: Vec::new(),
            with_truth: truth != Truth::Unwanted,
            nearest: Nearest::new(),
            rays: Rays::new(),
            surface: with_surface.then(|| {
                Box::new(Surface {
                    position: [[0.0; LANES]; 3],
                    normal: [ZERO; 3],
                })
            }),
            traced: 0,
            groups: Groups::new(),
            settler: Settler::new(),
            some_rays: Rays::new(),
            some_radiance: [ZERO; 3],
            lighting: Lighting::new(),
            stack: Stack::default(),
        }
    }

    /// Trace all samples of the block, unless `cancelled` says that nobody waits any more, or the meter runs out.
    #[inline(always)]
    pub(crate) fn trace(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        place: Place,
        meter: &mut WorkMeter,
        cancelled: impl Fn() -> bool,
    ) {
        self.stack.meter = *meter;
        self.trace_samples(scene, settings, place, cancelled);
        *meter = self.stack.meter;
    }

    #[inline(always)]
    fn trace_samples(&mut self, scene: &Scene, settings: &Settings, place: Place, cancelled: impl Fn() -> bool) {
        self.traced = 0;
        if self.offsets.len() != settings.samples as usize {
            self.offsets = sample_offsets(settings.samples);
            self.total = (settings.samples > 1).then(|| Box::new([[0.0; LANES]; 3]));
        }
        if let Some(total) = &mut self.total {
            **total = [[0.0; LANES]; 3];
        }
        for sample in 0..self.offsets.len() {
            if cancelled() {
                return;
            }
            self.radiance = [ZERO; 3];
            self.look(scene, place, self.offsets[sample]);
            for group in 0..self.groups.list.len() {
                self.shade(scene, settings, group);
                if self.stack.meter.ran_out() {
                    return;
                }
            }
            if let Some(total) = &mut self.total {
                add(total, &self.radiance);
            }
        }
        // A single sample goes through the centre: what it met is the ground truth.
        if self.with_truth && self.offsets.len() > 1 {
            self.look(scene, place, CENTRE);
            for group in 0..self.groups.list.len() {
                self.survey(scene, group);
            }
        }
    }

    /// Find what the rays through a place `within` each pixel meet first, and group them by it.
    #[inline(always)]
    fn look(&mut self, scene: &Scene, place: Place, within: (f64, f64)) {
        self.rays.aim(place.view, place.corner, within);
        self.stack.steps_per_object = steps_of(LANES);
        // Planes are in no tree: all of them are tested.
        if !self.stack.meter.take((1 + scene.planes.len() as u64) * steps_of(LANES)) {
            self.groups.list.clear();
            return;
        }
        nearest_hits(scene, &self.rays, &mut self.nearest, &mut self.stack);
        if self.nearest.close > 0 {
            self.settler
                .settle(scene, &self.rays, &mut self.nearest, &mut self.stack);
        }
        self.groups.collect(&self.nearest, place);
    }

    /// Write the mean radiance of each pixel's samples as RGB triples, from the pixel of `lane` on.
    #[inline(always)]
    pub(crate) fn mean(&self, lane: usize, rgb: &mut [f32]) {
        let count = rgb.len() / 3;
        assert!(lane + count <= LANES);
        for i in 0..count {
            for channel in 0..3 {
                rgb[3 * i + channel] = match &self.total {
                    None => shown(self.radiance[channel][lane + i]),
                    Some(total) => (total[channel][lane + i] / self.offsets.len() as f64) as f32,
                };
            }
        }
    }

    /// Keep where a group of rays through the pixel centres ends, if that is wanted.
    #[inline(always)]
    fn survey(&mut self, scene: &Scene, group: usize) {
        let Group { face, t, .. } = self.groups.list[group];
        let lanes = self.groups.lanes(group);
        let Some(surface) = self.surface.as_mut().filter(|_| face != NOTHING && !lanes.is_empty()) else {
            return;
        };
        self.some_rays.pick(&self.rays, lanes);
        let shape = &scene.shapes[(face >> FACE_BITS) as usize];
        let depth = (f64::from(t), || self.rays.exact(self.nearest.lane(face, t)));
        let flat = self.lighting.points.place(&self.some_rays, shape, face, depth);
        surface.take(lanes, &self.lighting.points, flat.as_ref());
    }

    /// Add the radiance of one group of rays, all of which met the same face.
    #[inline(always)]
    fn shade(&mut self, scene: &Scene, settings: &Settings, group: usize) {
        let Group { face, t, .. } = self.groups.list[group];
        let lanes = self.groups.lanes(group);
        self.traced += lanes.len() as u64;
        if face == NOTHING {
            fill(&mut self.radiance, lanes, single(settings.background));
            return;
        }
        let object = face >> FACE_BITS;
        let look = &scene.looks[object as usize];
        if let Some(radiance) = look.shining {
            fill(&mut self.radiance, lanes, radiance);
        }
        let lit = settings.lit && look.shining.is_none();
        let surface = self.surface.as_mut().filter(|_| self.offsets.len() == 1);
        if lanes.is_empty() || !(lit || surface.is_some()) {
            return;
        }
        // For each lamp the points are looked at, and all planes; the walks through the tree count themselves.
        let steps = steps_of(lanes.len());
        let per_lamp = steps * (1 + scene.planes.len() as u64);
        if lit && !self.stack.meter.take(per_lamp.saturating_mul(scene.lamps.len() as u64)) {
            return;
        }
        self.stack.steps_per_object = steps;
        let whole = lanes.len() == LANES;
        if !whole {
            self.some_rays.pick(&self.rays, lanes);
        }
        let rays = if whole { &self.rays } else { &self.some_rays };
        let shape = &scene.shapes[object as usize];
        let depth = (f64::from(t), || self.rays.exact(self.nearest.lane(face, t)));
        let flat = self.lighting.points.place(rays, shape, face, depth);
        if let Some(surface) = surface {
            surface.take(lanes, &self.lighting.points, flat.as_ref());
        }
        if !lit {
            return;
        }
        // The lighting walks the tree with the same stack, which holds the meter. It is lent as a part of the lighting:
        // with a reference of its own to write to, the compiler makes no vectors of the loops, at five times the time.
        std::mem::swap(&mut self.stack, &mut self.lighting.stack);
        if whole {
            self.traced += self
                .lighting
                .add(scene, settings, face, flat.as_ref(), &mut self.radiance);
        } else {
            gather(&self.radiance, lanes, &mut self.some_radiance);
            self.traced += self
                .lighting
                .add(scene, settings, face, flat.as_ref(), &mut self.some_radiance);
            for (to, from) in self.radiance.iter_mut().zip(&self.some_radiance) {
                put(to, lanes, |i| from[i]);
            }
        }
        std::mem::swap(&mut self.stack, &mut self.lighting.stack);
    }
}

impl Surface {
    /// Keep the points of a group, which lie on a plane if they are on something flat.
    #[inline(always)]
    fn take(&mut self, lanes: &[u8], points: &Points, flat: Option<&Plane>) {
        for axis in 0..3 {
            let (reference, offset) = (points.reference[axis], &points.offset[axis]);
            put(&mut self.position[axis], lanes, |i| reference + f64::from(offset[i]));
            match flat {
                Some(plane) => put(&mut self.normal[axis], lanes, |_| plane.normal[axis] as f32),
                None => put(&mut self.normal[axis], lanes, |i| points.normal[axis][i]),
            }
        }
    }
}

/// Write what belongs to the lanes of a group.
#[inline(always)]
fn put<T>(to: &mut [T; LANES], lanes: &[u8], value: impl Fn(usize) -> T) {
    if lanes.len() == LANES {
        // All lanes in turn: a loop for vectors.
        for (i, to) in to.iter_mut().enumerate() {
            *to = value(i);
        }
    } else {
        for (i, &lane) in lanes.iter().enumerate() {
            to[usize::from(lane)] = value(i);
        }
    }
}

/// What the rays of a block meet first.
#[inline(always)]
fn nearest_hits(scene: &Scene, rays: &Rays, nearest: &mut Nearest, stack: &mut Stack) {
    nearest.clear(rays);
    let cone = Cone::of_block(rays);
    let mut walk = scene.bvh.walk(&cone, stack);
    let mut limit = f32::INFINITY;
    while let Some(object) = walk.next(limit) {
        scene.shapes[object as usize].meet(object << FACE_BITS, rays, nearest);
        limit = cone.along_axis(rays, nearest.farthest());
    }
    for &object in &scene.planes {
        scene.shapes[object as usize].meet(object << FACE_BITS, rays, nearest);
    }
}

/// What a picture can show of radiance: NaN, of 0 * inf, counts as 0, and infinity as the most that there is.
#[inline(always)]
fn shown(radiance: f32) -> f32 {
    let radiance = if radiance > 0.0 { radiance } else { 0.0 };
    if radiance < f32::MAX { radiance } else { f32::MAX }
}

/// Add the radiance of a sample.
#[inline(always)]
fn add(total: &mut [[f64; LANES]; 3], radiance: &[Lanes; 3]) {
    for (total, radiance) in total.iter_mut().zip(radiance) {
        for (total, &radiance) in total.iter_mut().zip(radiance) {
            *total += f64::from(shown(radiance));
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
