//! The arrays of a rendered picture, and how a tile fills its part of them.

use crate::scene::Scene;
use crate::tile::Tile;
use crate::tile::hits::{FACE_BITS, NO_FACE};
use crate::tile::{LANES, Lanes};
use crate::trace::tile_tracer::{PassRequest, TileTracer};
use crate::vector::{add, dot, rotate, scale, to_f32};
use crate::world::{Camera, Vector, Window};

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
    pub(crate) fn request(&self) -> PassRequest {
        if self.normal.is_some() || self.position.is_some() {
            PassRequest::Surface
        } else if self.has_passes() {
            PassRequest::Hits
        } else {
            PassRequest::Radiance
        }
    }

    /// Whether each array has the length that the pixels of a window need.
    pub fn holds(&self, window: Window) -> bool {
        let pixels = window.width as usize * window.height as usize;
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

    /// Take the wanted pixels of a tile. The film is that of the place's window.
    #[inline(always)]
    pub(crate) fn take(&mut self, traced: &TileTracer, tile: Tile, to_world: CameraToWorld<'_>) {
        for span in tile.spans() {
            let radiance = &mut self.radiance[3 * span.pixel..3 * (span.pixel + span.count)];
            traced.mean_radiance(span.lane, radiance);
        }
        let (t, faces) = (&traced.hits.t, &traced.hits.face);
        if let Some(depth) = &mut self.depth {
            tile.put(depth, &to_world.depths(t, faces));
        }
        if let Some(distance) = &mut self.distance {
            tile.put(distance, &to_world.distances(t, &traced.rays.vv, faces));
        }
        if let Some(albedo) = &mut self.albedo {
            tile.put(albedo.as_chunks_mut().0, &to_world.albedos(faces));
        }
        if let Some(object_id) = &mut self.object_id {
            tile.put(object_id, &object_ids(faces));
        }
        if let Some(surface) = &traced.surface {
            if let Some(position) = &mut self.position {
                tile.put(
                    position.as_chunks_mut().0,
                    &to_world.positions(&surface.position, faces),
                );
            }
            if let Some(normal) = &mut self.normal {
                tile.put(normal.as_chunks_mut().0, &to_world.normals(&surface.normal, faces));
            }
        }
    }

    fn has_passes(&self) -> bool {
        let floats = [&self.depth, &self.distance, &self.normal, &self.position, &self.albedo];
        floats.into_iter().any(Option::is_some) || self.object_id.is_some()
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

/// Three numbers for each ray of a tile.
type Triples = [[f32; 3]; LANES];

/// The number of each object plus 1; 0 where nothing is met.
#[inline(always)]
fn object_ids(faces: &[u32; LANES]) -> [u32; LANES] {
    let mut ids = [0; LANES];
    for lane in 0..LANES {
        let face = faces[lane];
        ids[lane] = if face == NO_FACE { 0 } else { (face >> FACE_BITS) + 1 };
    }
    ids
}

/// In float32; what is finite stays finite.
#[inline(always)]
fn bounded(value: f64) -> f32 {
    let largest = f64::from(f32::MAX);
    value.clamp(-largest, largest) as f32
}

/// A length in the world, which stays finite if it is.
#[inline(always)]
fn length(length: f32, unit: f64) -> f32 {
    let in_world = bounded(f64::from(length) * unit);
    if length < f32::INFINITY { in_world } else { length }
}

/// The way back from the camera's space to the world, for whole tiles: loops that are compiled for vectors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CameraToWorld<'a> {
    scene: &'a Scene,
    /// What one of the camera's units is in the world: a power of two.
    unit: f64,
    eye: Vector,
    /// The rotation to the world's axes, row by row.
    rows: [Vector; 3],
}

impl<'a> CameraToWorld<'a> {
    pub(crate) fn new(scene: &'a Scene, camera: &Camera) -> CameraToWorld<'a> {
        let Camera { right, up, forward, .. } = camera;
        CameraToWorld {
            scene,
            unit: 1.0 / scene.unit,
            eye: camera.position,
            rows: std::array::from_fn(|axis| [right[axis], up[axis], forward[axis]]),
        }
    }

    /// depth = t
    #[inline(always)]
    fn depths(&self, t: &Lanes, faces: &[u32; LANES]) -> Lanes {
        let units = self.units(faces);
        let mut depths = [0.0; LANES];
        for lane in 0..LANES {
            depths[lane] = length(t[lane], units[lane]);
        }
        depths
    }

    /// distance = t |v|
    #[inline(always)]
    fn distances(&self, t: &Lanes, vv: &Lanes, faces: &[u32; LANES]) -> Lanes {
        let units = self.units(faces);
        let mut distances = [0.0; LANES];
        for lane in 0..LANES {
            distances[lane] = length(t[lane] * vv[lane].sqrt(), units[lane]);
        }
        distances
    }

    /// Places, from what they are relative to the eye; 0 where nothing is met.
    #[inline(always)]
    fn positions(&self, [x, y, z]: &[[f64; LANES]; 3], faces: &[u32; LANES]) -> Triples {
        let units = self.units(faces);
        let mut positions = [[0.0; 3]; LANES];
        for lane in 0..LANES {
            let relative = rotate(&self.rows, [x[lane], y[lane], z[lane]]);
            let position = add(self.eye, scale(relative, units[lane])).map(bounded);
            positions[lane] = if faces[lane] == NO_FACE { [0.0; 3] } else { position };
        }
        positions
    }

    /// What one of the camera's units is in the world, ray by ray: more where a body was moved nearer.
    #[inline(always)]
    fn units(&self, faces: &[u32; LANES]) -> [f64; LANES] {
        let mut units = [self.unit; LANES];
        if self.scene.has_moved_bodies {
            for (unit, &face) in units.iter_mut().zip(faces) {
                let material = self.scene.materials.get((face >> FACE_BITS) as usize);
                *unit /= material.map_or(1.0, |material| material.nearer);
            }
        }
        units
    }

    /// Unit vectors, whose length is known to float32 only, with that of float64; 0 where nothing is met.
    ///
    /// 1 / |n| = (3 - n.n) / 2, up to the square of how far n.n is from 1
    #[inline(always)]
    fn normals(&self, [x, y, z]: &[Lanes; 3], faces: &[u32; LANES]) -> Triples {
        let mut normals = [[0.0; 3]; LANES];
        for lane in 0..LANES {
            let n = [x[lane], y[lane], z[lane]].map(f64::from);
            let normal = to_f32(scale(rotate(&self.rows, n), (3.0 - dot(n, n)) / 2.0));
            normals[lane] = if faces[lane] == NO_FACE { [0.0; 3] } else { normal };
        }
        normals
    }

    /// The colors of what is met; 0 where it is nothing.
    #[inline(always)]
    fn albedos(&self, faces: &[u32; LANES]) -> Triples {
        let mut albedos = [[0.0; 3]; LANES];
        let (mut last, mut color) = (NO_FACE, [0.0; 3]);
        for (albedo, &face) in albedos.iter_mut().zip(faces) {
            if face != last {
                last = face;
                // Of nothing there is no look.
                let material = self.scene.materials.get((face >> FACE_BITS) as usize);
                color = material.map_or([0.0; 3], |look| to_f32(look.albedo));
            }
            *albedo = color;
        }
        albedos
    }
}
