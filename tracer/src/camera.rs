//! The camera, and rectangles of its picture.

use crate::names::UnknownName;
use crate::vector::Vector;
use std::f64::consts::PI;
use std::str::FromStr;

/// How the rays of a camera run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Projection {
    /// Through one point, the eye.
    #[default]
    Perspective,
    /// In parallel along the view, from the plane through the eye: the apex of their pencil is at infinity.
    Orthographic,
}

impl FromStr for Projection {
    type Err = UnknownName;

    fn from_str(name: &str) -> Result<Projection, UnknownName> {
        match name {
            "perspective" => Ok(Projection::Perspective),
            "orthographic" => Ok(Projection::Orthographic),
            _ => Err(UnknownName),
        }
    }
}

/// A camera without a lens.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Width of the whole picture, pixels.
    pub width: u32,
    /// Height of the whole picture, pixels.
    pub height: u32,
    /// How its rays run.
    pub projection: Projection,
    /// Half the height of the picture: on the image plane at distance 1, or of an orthographic one in the world.
    pub half_height: f64,
    /// The width of a pixel over its height.
    pub pixel_aspect: f64,
    /// The middle of the picture on the image plane at distance 1: (0, 0) unless the principal point is elsewhere.
    pub center: (f64, f64),
    /// The eye, world space; of an orthographic camera the middle of the plane on which its rays start.
    pub position: Vector,
    /// The image plane's x axis, a unit vector in world space.
    pub right: Vector,
    /// The image plane's y axis, a unit vector in world space.
    pub up: Vector,
    /// The view, a unit vector in world space.
    pub forward: Vector,
}

/// Return tan(angle / 2) of an angle in degrees; the tangent of the platform's library differs in its last bits.
pub fn half_tangent(degrees: f64) -> f64 {
    libm::tan(degrees * (PI / 180.0) / 2.0)
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

impl Window {
    /// Return the number of its pixels.
    pub fn pixels(self) -> usize {
        self.width as usize * self.height as usize
    }
}
