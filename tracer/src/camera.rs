//! The camera, and rectangles of its picture.

use crate::vector::Vector;

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
