//! What the tracer is given: a scene as plain numbers, in the order of the file.

pub use crate::vector::Vector;

/// A pinhole camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Width of the whole picture, pixels.
    pub width: u32,
    /// Height of the whole picture, pixels.
    pub height: u32,
    /// Vertical field of view, degrees, 0 < fov < 180.
    pub fov: f64,
    /// The eye, world space.
    pub position: Vector,
    /// The image plane's x axis, a unit vector in world space.
    pub right: Vector,
    /// The image plane's y axis, a unit vector in world space.
    pub up: Vector,
    /// The view, a unit vector in world space.
    pub forward: Vector,
}

#[cfg(test)]
impl Camera {
    /// Return a camera at the origin that looks along -z.
    pub(crate) fn along_z(width: u32, height: u32, fov: f64) -> Camera {
        Camera {
            width,
            height,
            fov,
            position: [0.0; 3],
            right: [1.0, 0.0, 0.0],
            up: [0.0, 1.0, 0.0],
            forward: [0.0, 0.0, -1.0],
        }
    }
}

/// What an object is, beside its place and color.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ShapeDesc {
    /// A sphere around its position.
    Sphere {
        /// Greater than 0.
        radius: f64,
    },
    /// An infinite plane through its position, two-sided.
    Plane {
        /// Any length but 0.
        normal: Vector,
    },
    /// A box around its position, turned about +y.
    Box {
        /// Width (x), height (y), depth (z).
        size: Vector,
        /// Degrees, counter-clockwise seen from above.
        rotation: f64,
    },
}

impl ShapeDesc {
    /// The name of each kind and the number of its parameters, in the order of their tags.
    pub const KINDS: [(&str, usize); 3] = [("sphere", 1), ("plane", 3), ("box", 4)];

    /// Describe a shape of the kind with a tag, unless there is none or it has another number of parameters.
    pub fn new(tag: u8, parameters: &[f64]) -> Option<ShapeDesc> {
        match (tag, parameters) {
            (0, &[radius]) => Some(ShapeDesc::Sphere { radius }),
            (1, &[x, y, z]) => Some(ShapeDesc::Plane { normal: [x, y, z] }),
            (2, &[x, y, z, rotation]) => Some(ShapeDesc::Box {
                size: [x, y, z],
                rotation,
            }),
            _ => None,
        }
    }
}

/// An object of the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// The centre, or a point of a plane, world space.
    pub position: Vector,
    /// Albedo, linear RGB, 0..1.
    pub color: Vector,
    /// What it is.
    pub shape: ShapeDesc,
}

/// How a light shines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightKind {
    /// From one point, in all directions alike.
    Point,
}

impl LightKind {
    /// The name of each kind, in the order of their tags.
    pub const ALL: [(&str, LightKind); 1] = [("point", LightKind::Point)];
}

/// A light.
#[derive(Clone, Debug, PartialEq)]
pub struct LightDesc {
    /// How it shines.
    pub kind: LightKind,
    /// Where it stands, world space.
    pub position: Vector,
    /// Linear RGB, each 0 or more.
    pub color: Vector,
    /// Emitted power: L_i = intensity * color / (4 pi r^2).
    pub intensity: f64,
    /// The object that carries it, if any: its index.
    pub carrier: Option<usize>,
}

/// How light is computed: `render` of the scene file.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Rays per pixel, 1 or more.
    pub samples: u32,
    /// Linear RGB radiance of rays that hit nothing.
    pub background: Vector,
    /// Whether objects are lit (`max_depth` of 1 or more), or only those that carry a light are seen.
    pub lit: bool,
    /// Whether radiance is also divided by 4 pi t^2, t from the surface to the eye.
    pub eye_falloff: bool,
}

/// All that the tracer needs to know.
#[derive(Clone, Debug, PartialEq)]
pub struct World {
    /// Where the picture is taken from.
    pub camera: Camera,
    /// Objects, in the order of the file.
    pub objects: Vec<Object>,
    /// Lights, in the order of the file, those of objects last.
    pub lights: Vec<LightDesc>,
    /// How light is computed.
    pub settings: Settings,
}

/// A rectangle of pixels of the whole picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// Its left column.
    pub x: u32,
    /// Its top row.
    pub y: u32,
    /// Columns, 1 or more.
    pub width: u32,
    /// Rows, 1 or more.
    pub height: u32,
}
