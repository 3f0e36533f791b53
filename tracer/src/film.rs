//! The arrays of a rendered picture, and how a block fills its part of them.

use crate::block::{Block, Truth};
use crate::grid::{FACE_BITS, NOTHING};
use crate::place::Place;
use crate::scene::Scene;
use crate::vector::{add, length, scale};
use crate::world::{Camera, Vector};

/// Where to put radiance and passes of a window: arrays row by row, of width * height pixels.
///
/// Passes are taken at pixel centres, whatever the number of samples; those that nobody wants are None.
#[derive(Debug, Default)]
pub struct Film<'a> {
    /// Linear RGB, 3 values a pixel: the mean of its samples.
    pub radiance: &'a mut [f32],
    /// The distance along the viewing axis; +inf where nothing is hit.
    pub depth: Option<&'a mut [f32]>,
    /// The distance to the eye; +inf where nothing is hit.
    pub distance: Option<&'a mut [f32]>,
    /// 3 values a pixel: world space, unit, facing the viewer; 0 where nothing is hit.
    pub normal: Option<&'a mut [f32]>,
    /// 3 values a pixel: world space; 0 where nothing is hit.
    pub position: Option<&'a mut [f32]>,
    /// 3 values a pixel, linear RGB; 0 where nothing is hit.
    pub albedo: Option<&'a mut [f32]>,
    /// 0 where nothing is hit, i + 1 for object i.
    pub object_id: Option<&'a mut [u32]>,
}

impl<'a> Film<'a> {
    /// What is wanted beside radiance.
    pub(crate) fn truth(&self) -> Truth {
        if self.normal.is_some() || self.position.is_some() {
            Truth::AndSurface
        } else if self.has_passes() {
            Truth::Hits
        } else {
            Truth::Unwanted
        }
    }

    /// Whether each array has the length that so many pixels need.
    pub(crate) fn holds(&self, pixels: usize) -> bool {
        let triples = [&self.normal, &self.position, &self.albedo];
        let singles = [&self.depth, &self.distance];
        self.radiance.len() == 3 * pixels
            && triples.into_iter().flatten().all(|a| a.len() == 3 * pixels)
            && singles.into_iter().flatten().all(|a| a.len() == pixels)
            && self.object_id.as_ref().is_none_or(|a| a.len() == pixels)
    }

    /// The part of the first pixels, and the rest.
    pub(crate) fn split(self, pixels: usize) -> (Film<'a>, Film<'a>) {
        let (radiance, radiance_rest) = self.radiance.split_at_mut(3 * pixels);
        let (depth, depth_rest) = split(self.depth, pixels);
        let (distance, distance_rest) = split(self.distance, pixels);
        let (normal, normal_rest) = split(self.normal, 3 * pixels);
        let (position, position_rest) = split(self.position, 3 * pixels);
        let (albedo, albedo_rest) = split(self.albedo, 3 * pixels);
        let (object_id, object_id_rest) = split(self.object_id, pixels);
        (
            Film {
                radiance,
                depth,
                distance,
                normal,
                position,
                albedo,
                object_id,
            },
            Film {
                radiance: radiance_rest,
                depth: depth_rest,
                distance: distance_rest,
                normal: normal_rest,
                position: position_rest,
                albedo: albedo_rest,
                object_id: object_id_rest,
            },
        )
    }

    /// Take the wanted pixels of a block. The film is that of the place's window.
    #[inline(always)]
    pub(crate) fn take(&mut self, block: &Block, place: Place, home: Home<'_>) {
        let passes = self.has_passes();
        for span in place.spans() {
            let radiance = &mut self.radiance[3 * span.pixel..3 * (span.pixel + span.count)];
            block.mean(span.lane, radiance);
            for i in 0..if passes { span.count } else { 0 } {
                self.take_passes(block, span.pixel + i, span.lane + i, home);
            }
        }
    }

    fn has_passes(&self) -> bool {
        let floats = [&self.depth, &self.distance, &self.normal, &self.position, &self.albedo];
        floats.into_iter().any(Option::is_some) || self.object_id.is_some()
    }

    fn take_passes(&mut self, block: &Block, pixel: usize, lane: usize, home: Home<'_>) {
        let (t, face) = (block.nearest.t[lane], block.nearest.face[lane]);
        let hit = face != NOTHING;
        if let Some(depth) = &mut self.depth {
            depth[pixel] = home.length(t);
        }
        if let Some(distance) = &mut self.distance {
            distance[pixel] = home.length(t * block.rays.vv[lane].sqrt());
        }
        if let Some(albedo) = &mut self.albedo {
            let color = if hit {
                home.scene.looks[(face >> FACE_BITS) as usize].albedo
            } else {
                [0.0; 3]
            };
            put(albedo, pixel, color);
        }
        if let Some(object_id) = &mut self.object_id {
            object_id[pixel] = if hit { (face >> FACE_BITS) + 1 } else { 0 };
        }
        if let Some(surface) = &block.surface {
            if let Some(position) = &mut self.position {
                let point = surface.position.each_ref().map(|axis| axis[lane]);
                put(position, pixel, if hit { home.place(point) } else { [0.0; 3] });
            }
            if let Some(normal) = &mut self.normal {
                let n = surface.normal.each_ref().map(|axis| f64::from(axis[lane]));
                put(normal, pixel, if hit { home.direction(n) } else { [0.0; 3] });
            }
        }
    }
}

fn split<T>(array: Option<&mut [T]>, at: usize) -> (Option<&mut [T]>, Option<&mut [T]>) {
    match array {
        Some(array) => {
            let (first, rest) = array.split_at_mut(at);
            (Some(first), Some(rest))
        }
        None => (None, None),
    }
}

fn put(array: &mut [f32], pixel: usize, value: Vector) {
    for (to, from) in array[3 * pixel..3 * pixel + 3].iter_mut().zip(value) {
        *to = bounded(from);
    }
}

/// In float32; what is finite stays finite.
fn bounded(value: f64) -> f32 {
    let largest = f64::from(f32::MAX);
    value.clamp(-largest, largest) as f32
}

/// The way back from the camera's space to the world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Home<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) camera: &'a Camera,
}

impl Home<'_> {
    /// A length, which stays finite if it is.
    fn length(&self, length: f32) -> f32 {
        if length == f32::INFINITY {
            return length;
        }
        bounded(f64::from(length) / self.scene.unit)
    }

    fn place(&self, point: Vector) -> Vector {
        let relative = self.turn(point).map(|component| component / self.scene.unit);
        add(self.camera.position, relative)
    }

    /// A unit vector, made exactly as long as float64 can.
    fn direction(&self, direction: Vector) -> Vector {
        scale(self.turn(direction), 1.0 / length(direction))
    }

    /// From the camera's axes to the world's.
    fn turn(&self, v: Vector) -> Vector {
        let Camera { right, up, forward, .. } = self.camera;
        std::array::from_fn(|i| v[0] * right[i] + v[1] * up[i] + v[2] * forward[i])
    }
}
