//! The tracer's input: a scene as plain numbers, in the order of the file.

pub use crate::camera::{Camera, Projection, Window};
pub use crate::shapes::descriptions::*;
pub use crate::shapes::{Kind, ShapeDesc};
pub use crate::vector::Vector;
use std::borrow::Cow;

/// An object of the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// The centre, or a point of a plane, world space.
    pub position: Vector,
    /// Albedo, linear RGB, 0..1.
    pub color: Vector,
    /// The shape and its parameters.
    pub shape: ShapeDesc,
}

/// The objects of a scene, in the order of the file, each by its number.
pub trait Objects: Sync {
    /// The number of objects.
    fn count(&self) -> usize;

    /// The centre of an object, or a point of a plane, world space.
    fn position(&self, number: usize) -> Vector;

    /// The albedo of an object, linear RGB, 0..1.
    fn color(&self, number: usize) -> Vector;

    /// The index of an object's kind in `ShapeDesc::KINDS`.
    fn kind(&self, number: usize) -> usize;

    /// The shape of an object and its parameters.
    fn shape(&self, number: usize) -> ShapeDesc;
}

impl Objects for Vec<Object> {
    fn count(&self) -> usize {
        self.len()
    }

    fn position(&self, number: usize) -> Vector {
        self[number].position
    }

    fn color(&self, number: usize) -> Vector {
        self[number].color
    }

    fn kind(&self, number: usize) -> usize {
        self[number].shape.kind()
    }

    fn shape(&self, number: usize) -> ShapeDesc {
        self[number].shape
    }
}

/// Objects in packed columns.
#[derive(Clone, Debug)]
pub struct Columns<'a> {
    /// The index of each object's kind in `ShapeDesc::KINDS`.
    pub kinds: &'a [u8],
    /// The centre of each object, or a point of a plane, world space.
    pub positions: Cow<'a, [Vector]>,
    /// The parameters of the first object, then those of the second, and so on.
    pub parameters: Cow<'a, [f64]>,
    /// The index of each object's first parameter; empty if all objects are of one kind.
    pub starts: Vec<u32>,
    /// The albedo of each object, linear RGB, 0..1.
    pub colors: Cow<'a, [Vector]>,
}

impl Objects for Columns<'_> {
    fn count(&self) -> usize {
        self.kinds.len()
    }

    #[inline(always)]
    fn position(&self, number: usize) -> Vector {
        self.positions[number]
    }

    #[inline(always)]
    fn color(&self, number: usize) -> Vector {
        self.colors[number]
    }

    #[inline(always)]
    fn kind(&self, number: usize) -> usize {
        usize::from(self.kinds[number])
    }

    #[inline(always)]
    fn shape(&self, number: usize) -> ShapeDesc {
        let kind = self.kind(number);
        let in_step = || number * ShapeDesc::KINDS[kind].parameters;
        let start = self.starts.get(number).map_or_else(in_step, |&start| start as usize);
        ShapeDesc::new(kind, &self.parameters[start..])
    }
}

/// Squares in two colors on the flat faces of an object.
#[derive(Clone, Debug, PartialEq)]
pub struct CheckerDesc {
    /// The index of the object, a plane or a box.
    pub object: usize,
    /// The side of a square.
    pub size: f64,
    /// The albedo of every other square, linear RGB, 0..1.
    pub color: Vector,
}

/// The source of a light and its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightSource {
    /// A point or a ball that emits equally in all directions.
    Point {
        /// World space.
        position: Vector,
        /// World space, 0 for a point.
        radius: f64,
    },
    /// A sun, whose rays are parallel.
    Sun {
        /// The direction in which its light travels, of any length but 0.
        direction: Vector,
        /// The angular diameter in degrees, from 0 to less than 90.
        angle: f64,
    },
}

impl LightSource {
    /// The kinds, in the order of their tags.
    pub const KINDS: &[Kind] = &[Kind { name: "point", parameters: 4 }, Kind { name: "sun", parameters: 4 }];

    /// Make the light of a kind, by its index in `KINDS`, from its parameters.
    ///
    /// # Panics
    ///
    /// If there is no such kind, or the number of parameters is another.
    pub fn new(kind: usize, parameters: &[f64]) -> LightSource {
        let &[x, y, z, size] = parameters else { unreachable!("there are four parameters") };
        match kind {
            0 => LightSource::Point { position: [x, y, z], radius: size },
            1 => LightSource::Sun { direction: [x, y, z], angle: size },
            _ => unreachable!("there is no light of kind {kind}"),
        }
    }

    /// The point that all its light comes from, world space; None if it is infinitely far away.
    pub fn position(&self) -> Option<Vector> {
        match *self {
            LightSource::Point { position, .. } => Some(position),
            LightSource::Sun { .. } => None,
        }
    }
}

/// A light.
#[derive(Clone, Debug, PartialEq)]
pub struct LightDesc {
    /// The source and its parameters.
    pub source: LightSource,
    /// Linear RGB, each 0 or more.
    pub color: Vector,
    /// Emitted power: L_i = intensity * color / (4 pi r^2); of a sun, its irradiance: L_i = intensity * color.
    pub intensity: f64,
    /// The index of the object that carries it, if any.
    pub carrier: Option<usize>,
}

/// How light is computed: `render` of the scene file.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Rays per pixel, 1 or more.
    pub samples: u32,
    /// Linear RGB radiance of rays that hit nothing.
    pub background: Vector,
    /// Linear RGB of the light that reaches every surface unhindered; it reflects albedo * ambient.
    pub ambient: Vector,
    /// Whether lights illuminate objects (`max_depth` of 1 or more); otherwise only objects that carry a light are
    /// seen.
    pub direct_light: bool,
    /// The number of places of each light that has a size, 1 or more.
    pub shadow_samples: u32,
    /// Whether radiance is also divided by 4 pi t^2, t from the surface to the eye.
    pub eye_falloff: bool,
}

/// The whole input.
#[derive(Clone, Debug, PartialEq)]
pub struct World<O = Vec<Object>> {
    /// The camera.
    pub camera: Camera,
    /// Objects, in the order of the file.
    pub objects: O,
    /// Checkers, at most one for each object.
    pub checkers: Vec<CheckerDesc>,
    /// Lights, in the order of the file, those of objects last.
    pub lights: Vec<LightDesc>,
    /// How light is computed.
    pub settings: Settings,
}
