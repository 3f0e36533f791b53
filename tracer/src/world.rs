//! The tracer's input: a scene as plain numbers, in the order of the file.

pub use crate::camera::{Camera, Projection, Window};
pub use crate::shapes::descriptions::*;
pub use crate::shapes::{Kind, ShapeDesc};
pub use crate::vector::Vector;

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
    pub const KINDS: &[Kind<LightSource>] = &[
        Kind {
            name: "point",
            parameters: 4,
            describe: |p| LightSource::Point { position: [p[0], p[1], p[2]], radius: p[3] },
        },
        Kind {
            name: "sun",
            parameters: 4,
            describe: |p| LightSource::Sun { direction: [p[0], p[1], p[2]], angle: p[3] },
        },
    ];

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
pub struct World {
    /// The camera.
    pub camera: Camera,
    /// Objects, in the order of the file.
    pub objects: Vec<Object>,
    /// Checkers, at most one for each object.
    pub checkers: Vec<CheckerDesc>,
    /// Lights, in the order of the file, those of objects last.
    pub lights: Vec<LightDesc>,
    /// How light is computed.
    pub settings: Settings,
}
