//! One block of the picture: what is seen in it, and the light that comes from there.

use crate::bvh::{Cone, Stack};
use crate::grid::{FACE_BITS, Grid, LANES, Lanes, NOTHING, Nearest};
use crate::plane::Plane;
use crate::groups::{Group, Groups};
use crate::points::Points;
use crate::sampling::sample_offset;
use crate::scene::{Scene, Shape};
use crate::shadow::{Shadow, arriving};
use crate::vector::{single, sub};
use crate::place::Place;
use crate::world::Settings;
use std::f64::consts::PI;

/// The result of one block, and the room to work in.
#[derive(Debug)]
pub(crate) struct Block {
    /// Linear radiance of red, green and blue, row by row: the mean of each pixel's samples.
    pub(crate) radiance: [Lanes; 3],
    /// What is met at the pixel centres.
    pub(crate) nearest: Nearest,
    /// The rays through the pixel centres.
    pub(crate) grid: Grid,
    /// Where the rays through the pixel centres end and with which normal, in the camera's space; only if wanted.
    pub(crate) surface: Option<Box<Surface>>,
    /// How many rays were traced for the wanted pixels, primary and shadow rays.
    pub(crate) rays: u64,
    points: Points,
    groups: Groups,
    squared: Lanes,
    light: Lanes,
    stack: Stack,
}

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
    pub(crate) fn new(with_surface: bool) -> Block {
        Block {
            radiance: [ZERO; 3],
            nearest: Nearest::new(),
            grid: Grid::empty(),
            surface: with_surface.then(|| {
                Box::new(Surface {
                    position: [[0.0; LANES]; 3],
                    normal: [ZERO; 3],
                })
            }),
            rays: 0,
            points: Points::new(),
            groups: Groups::new(),
            squared: ZERO,
            light: ZERO,
            stack: Stack::default(),
        }
    }

    /// Trace all samples of the block, unless `cancelled` says that nobody waits any more.
    #[inline(always)]
    pub(crate) fn trace(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        place: Place,
        cancelled: impl Fn() -> bool,
    ) {
        self.radiance = [ZERO; 3];
        self.rays = 0;
        // Backwards, so that what the pixel centres meet is what remains.
        for sample in (0..settings.samples).rev() {
            if cancelled() {
                return;
            }
            self.grid = Grid::new(
                place.view,
                place.corner,
                sample_offset(sample),
            );
            nearest_hits(scene, &self.grid, &mut self.nearest, &mut self.stack);
            self.groups.collect(&self.nearest, place);
            for i in 0..self.groups.list.len() {
                self.shade(scene, settings, i, sample == 0);
            }
        }
        self.average(settings.samples);
    }

    #[inline(always)]
    fn average(&mut self, samples: u32) {
        let samples = samples as f32;
        for channel in &mut self.radiance {
            for value in channel {
                let mean = *value / samples;
                // NaN, of 0 * inf, counts as 0.
                let mean = if mean > 0.0 { mean } else { 0.0 };
                *value = if mean < f32::MAX { mean } else { f32::MAX };
            }
        }
    }

    /// Add the radiance of one group of rays, all of which met the same face.
    #[inline(always)]
    fn shade(&mut self, scene: &Scene, settings: &Settings, group: usize, centres: bool) {
        let Group { face, t, .. } = self.groups.list[group];
        let lanes = self.groups.lanes(group);
        self.rays += lanes.len() as u64;
        if lanes.is_empty() {
            return;
        }
        if face == NOTHING {
            fill(&mut self.radiance, lanes, single(settings.background));
            return;
        }
        let object = face >> FACE_BITS;
        let shape = &scene.shapes[object as usize];
        let look = &scene.looks[object as usize];
        let lit = settings.lit && look.shining.is_none();
        let with_surface = centres && self.surface.is_some();
        if lit || with_surface {
            self.points.gather(&self.grid, lanes);
            let flat = self.points.place(shape, face, f64::from(t));
            if with_surface && let Some(surface) = &mut self.surface {
                surface.take(&self.points, flat.as_ref());
            }
            if lit {
                self.light_up(scene, settings, object, flat.as_ref());
            }
        }
        if let Some(radiance) = look.shining {
            fill(&mut self.radiance, self.groups.lanes(group), radiance);
        }
    }

    /// Add what the points send back of the light that reaches them.
    ///
    /// radiance = sum over lamps of albedo / pi L_i cos(theta), L_i = power / r^2 (document, sections 2.3.1, 2.3.2)
    ///
    /// A surface is lit from the eye's side only. All shapes are convex, so where eye and lamp are on the same side
    /// of an object and cos(theta) > 0, the object cannot stand in its own light: it is left out, and no epsilon is
    /// needed.
    #[inline(always)]
    fn light_up(&mut self, scene: &Scene, settings: &Settings, object: u32, flat: Option<&Plane>) {
        let points = &self.points;
        let count = points.padded();
        let shape = &scene.shapes[object as usize];
        let albedo = scene.looks[object as usize].albedo;
        let ball = points.bound();
        let mut sum = [ZERO; 3];
        for lamp in &scene.lamps {
            let height = flat.map(|plane| plane.height(lamp.position));
            if height.is_some_and(|height| height <= 0.0) || !shape.sees(lamp.position) {
                continue;
            }
            let to_lamp = single(sub(lamp.position, points.reference));
            let height = height.map(|height| height as f32);
            arriving(points, height, to_lamp, &mut self.squared, &mut self.light);
            let facing = facing(&self.light[..points.count]);
            if facing == 0 {
                continue;
            }
            self.rays += facing;
            let mut shadow = Shadow {
                points,
                lamp: lamp.position,
                to_lamp,
                squared: &self.squared,
                light: &mut self.light,
                ball,
            };
            shadow.cast(scene, object, lamp.body, &mut self.stack);
            let share: [f32; 3] =
                std::array::from_fn(|i| bounded(lamp.power[i] * (albedo[i] / PI)));
            for channel in 0..3 {
                for lane in 0..count {
                    sum[channel][lane] += share[channel] * self.light[lane];
                }
            }
        }
        if settings.eye_falloff {
            weaken(&mut sum, points, scene.unit);
        }
        scatter(&mut self.radiance, points, &sum);
    }
}

impl Surface {
    #[inline(always)]
    fn take(&mut self, points: &Points, flat: Option<&Plane>) {
        for i in 0..points.count {
            let lane = usize::from(points.lane[i]);
            for axis in 0..3 {
                self.position[axis][lane] =
                    points.reference[axis] + f64::from(points.offset[axis][i]);
                self.normal[axis][lane] = match flat {
                    Some(plane) => plane.normal[axis] as f32,
                    None => points.normal[axis][i],
                };
            }
        }
    }
}

/// What the rays of a block meet first.
#[inline(always)]
fn nearest_hits(scene: &Scene, grid: &Grid, nearest: &mut Nearest, stack: &mut Stack) {
    nearest.clear();
    let cone = Cone::of_block(grid.middle, grid.reach);
    let per_depth = cone.along_axis_per_depth(grid.middle, grid.reach);
    let mut walk = scene.bvh.walk(&cone, stack);
    let mut limit = f64::INFINITY;
    while let Some(object) = walk.next(limit) {
        let face = object << FACE_BITS;
        match &scene.shapes[object as usize] {
            Shape::Sphere(sphere) => sphere.meet(face, grid, nearest),
            Shape::Cuboid(cuboid) => cuboid.meet(face, grid, nearest),
            Shape::Plane(_) => {}
        }
        limit = f64::from(nearest.farthest()) * per_depth * (1.0 + 1e-6);
    }
    for &object in &scene.planes {
        if let Shape::Plane(plane) = &scene.shapes[object as usize] {
            plane.meet(object << FACE_BITS, grid, nearest);
        }
    }
}

/// How many values are more than 0.
#[inline(always)]
fn facing(light: &[f32]) -> u64 {
    u64::from(light.iter().map(|&value| u32::from(value > 0.0)).sum::<u32>())
}

/// Add the same radiance to some lanes.
#[inline(always)]
fn fill(radiance: &mut [Lanes; 3], lanes: &[u8], value: [f32; 3]) {
    for channel in 0..3 {
        if lanes.len() == LANES {
            for lane in 0..LANES {
                radiance[channel][lane] += value[channel];
            }
        } else {
            for &lane in lanes {
                radiance[channel][usize::from(lane)] += value[channel];
            }
        }
    }
}

/// Add the radiance of points to their lanes.
#[inline(always)]
fn scatter(radiance: &mut [Lanes; 3], points: &Points, sum: &[Lanes; 3]) {
    for channel in 0..3 {
        if points.count == LANES {
            for lane in 0..LANES {
                radiance[channel][lane] += sum[channel][lane];
            }
        } else {
            for i in 0..points.count {
                radiance[channel][usize::from(points.lane[i])] += sum[channel][i];
            }
        }
    }
}

/// Divide by 4 pi t^2 (document, section 3.4), t the distance to the eye in the world's units.
#[inline(always)]
fn weaken(sum: &mut [Lanes; 3], points: &Points, unit: f64) {
    let [x, y, z] = single(points.reference);
    let (unit, per_sphere) = (bounded(unit), (0.25 / PI) as f32);
    for lane in 0..points.padded() {
        let p = [
            x + points.offset[0][lane],
            y + points.offset[1][lane],
            z + points.offset[2][lane],
        ];
        let distance = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt();
        let factor = unit / distance;
        for channel in sum.iter_mut() {
            channel[lane] = channel[lane] * factor * factor * per_sphere;
        }
    }
}

/// In float32, whose largest value stands for what is larger.
fn bounded(value: f64) -> f32 {
    value.min(f64::from(f32::MAX)) as f32
}
