//! The arrays of a rendered picture, and how a tile fills its part of them. To add a pass: add it to `Pass` and
//! `PASSES`, and compute it in `FilmSink::take`.

use crate::names::UnknownName;
use crate::scene::Scene;
use crate::tile::Tile;
use crate::tile::hits::{FACE_BITS, NO_FACE};
use crate::tile::{LANES, Lanes};
use crate::trace::tile_tracer::{PassRequest, TileTracer};
use crate::vector::{add, dot, rotate, scale, to_f32};
use crate::world::{Camera, Vector, Window};
use std::str::FromStr;

/// A value that a film records of each pixel. Passes other than radiance and alpha are taken at pixel centres,
/// whatever the number of samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pass {
    /// Linear RGB: the mean of the pixel's samples.
    Radiance,
    /// The share of the pixel's samples that hit something.
    Alpha,
    /// The distance along the viewing axis; +inf where nothing is hit.
    Depth,
    /// The distance to the eye; +inf where nothing is hit.
    Distance,
    /// World space, unit, facing the viewer; 0 where nothing is hit.
    Normal,
    /// World space; 0 where nothing is hit.
    Position,
    /// Linear RGB; 0 where nothing is hit.
    Albedo,
    /// 0 where nothing is hit, i + 1 for object i.
    ObjectId,
}

/// A pass: its name, its channels and the type of their values, and the data that tracing has to provide.
struct PassSpec {
    pass: Pass,
    name: &'static str,
    channels: usize,
    value_type: ValueType,
    request: PassRequest,
}

const fn spec(
    pass: Pass,
    name: &'static str,
    channels: usize,
    value_type: ValueType,
    request: PassRequest,
) -> PassSpec {
    PassSpec { pass, name, channels, value_type, request }
}

/// The type of the values of a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ValueType {
    /// f32.
    Float,
    /// u32.
    Integer,
}

const PASSES: [PassSpec; 8] = [
    spec(Pass::Radiance, "radiance", 3, ValueType::Float, PassRequest::Radiance),
    spec(Pass::Alpha, "alpha", 1, ValueType::Float, PassRequest::Radiance),
    spec(Pass::Depth, "depth", 1, ValueType::Float, PassRequest::Hits),
    spec(Pass::Distance, "distance", 1, ValueType::Float, PassRequest::Hits),
    spec(Pass::Normal, "normal", 3, ValueType::Float, PassRequest::Surface),
    spec(Pass::Position, "position", 3, ValueType::Float, PassRequest::Surface),
    spec(Pass::Albedo, "albedo", 3, ValueType::Float, PassRequest::Hits),
    spec(Pass::ObjectId, "object_id", 1, ValueType::Integer, PassRequest::Hits),
];

impl FromStr for Pass {
    type Err = UnknownName;

    fn from_str(name: &str) -> Result<Pass, UnknownName> {
        PASSES.iter().find(|spec| spec.name == name).map(|spec| spec.pass).ok_or(UnknownName)
    }
}

impl Pass {
    /// Its name.
    pub fn name(self) -> &'static str {
        PASSES[self as usize].name
    }

    /// The values of a pixel.
    pub fn channels(self) -> usize {
        PASSES[self as usize].channels
    }

    /// The type of its values.
    pub fn value_type(self) -> ValueType {
        PASSES[self as usize].value_type
    }
}

/// The values of a pass, row by row.
#[derive(Debug)]
pub enum Values<'a> {
    /// f32.
    Floats(&'a mut [f32]),
    /// u32.
    Integers(&'a mut [u32]),
}

impl<'a> Values<'a> {
    fn len(&self) -> usize {
        match self {
            Values::Floats(values) => values.len(),
            Values::Integers(values) => values.len(),
        }
    }

    /// The values of a pass of floats; `Film::holds` checks its type.
    fn floats(&mut self) -> &mut [f32] {
        match self {
            Values::Floats(values) => values,
            Values::Integers(_) => &mut [],
        }
    }

    /// The values of a pass of integers; `Film::holds` checks its type.
    fn integers(&mut self) -> &mut [u32] {
        match self {
            Values::Floats(_) => &mut [],
            Values::Integers(values) => values,
        }
    }

    fn split_off(&mut self, count: usize) -> Option<Values<'a>> {
        Some(match self {
            Values::Floats(values) => Values::Floats(values.split_off_mut(..count)?),
            Values::Integers(values) => Values::Integers(values.split_off_mut(..count)?),
        })
    }
}

/// Where to put the passes of a window.
#[derive(Debug, Default)]
pub struct Film<'a> {
    values: [Option<Values<'a>>; PASSES.len()],
}

impl<'a> Film<'a> {
    /// Return a film that records radiance, into 3 values a pixel.
    pub fn of_radiance(radiance: &'a mut [f32]) -> Film<'a> {
        Film::default().with(Pass::Radiance, Values::Floats(radiance))
    }

    /// Return the film with another pass to record.
    pub fn with(mut self, pass: Pass, values: Values<'a>) -> Film<'a> {
        self.values[pass as usize] = Some(values);
        self
    }

    /// The pixels' data that the passes of a scene need.
    pub(crate) fn request(&self, scene: &Scene) -> PassRequest {
        let recorded = PASSES.iter().filter(|spec| self.values[spec.pass as usize].is_some());
        let request = |spec: &PassSpec| match spec.pass {
            Pass::Albedo if !scene.checkers.is_empty() => PassRequest::Surface,
            _ => spec.request,
        };
        recorded.map(request).max().unwrap_or(PassRequest::Radiance)
    }

    /// Whether alpha is recorded.
    pub(crate) fn records_alpha(&self) -> bool {
        self.values[Pass::Alpha as usize].is_some()
    }

    /// Whether anything is recorded of the pixels' samples, and not only of their centres.
    pub(crate) fn records_samples(&self) -> bool {
        self.values[Pass::Radiance as usize].is_some() || self.records_alpha()
    }

    /// Whether each array has the type and the length that the pixels of a window need.
    pub fn holds(&self, window: Window) -> bool {
        let fits = |spec: &PassSpec| {
            self.values[spec.pass as usize].as_ref().is_none_or(|values| {
                values.len() == spec.channels * window.pixels()
                    && matches!(values, Values::Integers(_)) == (spec.value_type == ValueType::Integer)
            })
        };
        PASSES.iter().all(fits)
    }

    /// Take the first pixels out of the film.
    pub(crate) fn split_off(&mut self, pixels: usize) -> Film<'a> {
        let mut first = Film::default();
        for ((part, values), spec) in first.values.iter_mut().zip(&mut self.values).zip(&PASSES) {
            *part = values.as_mut().and_then(|values| values.split_off(spec.channels * pixels));
        }
        first
    }
}

/// Records the requested pixels of tiles of the film's window.
pub(crate) struct FilmSink<'a> {
    pub(crate) film: Film<'a>,
    pub(crate) to_world: CameraToWorld<'a>,
}

impl FilmSink<'_> {
    #[inline(always)]
    pub(crate) fn take(&mut self, traced: &TileTracer, tile: Tile) {
        let FilmSink { film, to_world } = self;
        let (t, faces) = (&traced.hits.t, &traced.hits.face);
        for spec in &PASSES {
            let Some(values) = &mut film.values[spec.pass as usize] else { continue };
            match spec.pass {
                Pass::Radiance => {
                    for span in tile.spans() {
                        let pixels = 3 * span.pixel..3 * (span.pixel + span.count);
                        traced.mean_radiance(span.lane, &mut values.floats()[pixels]);
                    }
                }
                Pass::Alpha => {
                    let Some(alpha) = traced.alpha() else { continue };
                    tile.put(values.floats(), &alpha);
                }
                Pass::Depth => tile.put(values.floats(), &to_world.lengths(t, faces)),
                Pass::Distance => {
                    tile.put(values.floats(), &to_world.lengths(&distances(t, &traced.rays.vv), faces));
                }
                Pass::Normal => {
                    let Some(surface) = &traced.surface else { continue };
                    tile.put(values.floats().as_chunks_mut().0, &to_world.normals(&surface.normal, faces));
                }
                Pass::Position => {
                    let Some(surface) = &traced.surface else { continue };
                    tile.put(values.floats().as_chunks_mut().0, &to_world.positions(&surface.position, faces));
                }
                Pass::Albedo => {
                    let mut albedos = to_world.albedos(faces);
                    if let Some(surface) = traced.surface.as_ref().filter(|_| !to_world.scene.checkers.is_empty())
                    {
                        to_world.put_checkers(faces, &surface.odd, &mut albedos);
                    }
                    tile.put(values.floats().as_chunks_mut().0, &albedos);
                }
                Pass::ObjectId => tile.put(values.integers(), &to_world.object_ids(faces)),
            }
        }
    }
}

/// Three numbers for each ray of a tile.
type Triples = [[f32; 3]; LANES];

/// Round to float32; finite values stay finite.
#[inline(always)]
fn bounded(value: f64) -> f32 {
    let largest = f64::from(f32::MAX);
    value.clamp(-largest, largest) as f32
}

/// distance = t |v|
#[inline(always)]
fn distances(t: &Lanes, vv: &Lanes) -> Lanes {
    let mut distances = [0.0; LANES];
    for lane in 0..LANES {
        distances[lane] = t[lane] * vv[lane].sqrt();
    }
    distances
}

/// The transformation from camera space to the world, for whole tiles: loops that vectorize.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CameraToWorld<'a> {
    scene: &'a Scene,
    /// The size of the unit of camera space in the world: a power of two.
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

    /// Lengths in the world, which stay finite if they are.
    #[inline(always)]
    fn lengths(&self, lengths: &Lanes, faces: &[u32; LANES]) -> Lanes {
        let units = self.units(faces);
        let mut in_world = [0.0; LANES];
        for lane in 0..LANES {
            let scaled = bounded(f64::from(lengths[lane]) * units[lane]);
            in_world[lane] = if lengths[lane] < f32::INFINITY { scaled } else { lengths[lane] };
        }
        in_world
    }

    /// Positions, from those relative to the eye; 0 where rays miss.
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

    /// The size of the unit of camera space in the world, ray by ray; larger for objects with a range scale.
    #[inline(always)]
    fn units(&self, faces: &[u32; LANES]) -> [f64; LANES] {
        let mut units = [self.unit; LANES];
        if !self.scene.range_scales.is_empty() {
            for (unit, &face) in units.iter_mut().zip(faces) {
                *unit /= self.scene.range_scale(face >> FACE_BITS);
            }
        }
        units
    }

    /// Unit vectors, normalized in float64, whose length was exact to float32 only; 0 where rays miss.
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

    /// The number of each ray's object in the world plus 1; 0 where the ray misses.
    #[inline(always)]
    fn object_ids(&self, faces: &[u32; LANES]) -> [u32; LANES] {
        let number = |face: u32| self.scene.numbers.get((face >> FACE_BITS) as usize);
        faces.map(|face| number(face).map_or(0, |number| number + 1))
    }

    /// The albedo of each ray's object; 0 where the ray misses.
    #[inline(always)]
    fn albedos(&self, faces: &[u32; LANES]) -> Triples {
        let mut albedos = [[0.0; 3]; LANES];
        let (mut last, mut color) = (NO_FACE, [0.0; 3]);
        for (albedo, &face) in albedos.iter_mut().zip(faces) {
            if face != last {
                last = face;
                // A miss has none.
                color = self
                    .scene
                    .albedos
                    .get((face >> FACE_BITS) as usize)
                    .map_or([0.0; 3], |&albedo| to_f32(albedo));
            }
            *albedo = color;
        }
        albedos
    }

    /// Replace the albedo of each ray that hits an odd square of a checker.
    fn put_checkers(&self, faces: &[u32; LANES], odd: &[u32; LANES], albedos: &mut Triples) {
        for ((albedo, &face), &odd) in albedos.iter_mut().zip(faces).zip(odd) {
            if let Some(checker) = self.scene.checker(face >> FACE_BITS).filter(|_| odd != 0) {
                *albedo = to_f32(checker.albedo);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_in_the_order_of_the_passes() {
        for (index, spec) in PASSES.iter().enumerate() {
            assert_eq!(spec.pass as usize, index);
        }
    }
}
