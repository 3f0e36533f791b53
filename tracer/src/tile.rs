//! The tiles of a picture, and the pixels of a window in them.

use crate::camera::{Camera, Projection, Window};

pub(crate) mod hits;
pub(crate) mod rays;

/// Rows and columns of a tile.
pub const SIDE: u32 = 16;

/// Rays of a tile.
pub(crate) const LANES: usize = (SIDE * SIDE) as usize;

/// Rays are padded to multiples of this, so that loops over them have no remainder.
pub(crate) const STEP: usize = 16;

/// The offset of a pixel's centre, where ground truth is taken.
pub(crate) const CENTRE: (f64, f64) = (0.5, 0.5);

/// A number for each ray of a tile, row by row.
pub(crate) type Lanes = [f32; LANES];

/// The size of the whole picture, in pixels and on the image plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) projection: Projection,
    /// Half the width and half the height of a pixel on the image plane at distance 1, or in units of camera space
    /// of an orthographic one.
    pub(crate) half_pixel: (f64, f64),
    /// The middle of the picture on the image plane.
    pub(crate) center: (f64, f64),
}

impl View {
    /// half_pixel = half_height / height, times the pixel aspect across (document, section 2.1)
    ///
    /// `unit` is the number of units of camera space per unit of the world.
    pub(crate) fn new(camera: &Camera, unit: f64) -> View {
        let half_pixel = half_height(camera, unit) / f64::from(camera.height);
        View {
            width: camera.width,
            height: camera.height,
            projection: camera.projection,
            half_pixel: (half_pixel * camera.pixel_aspect, half_pixel),
            center: camera.center,
        }
    }

    /// The same rectangle of the image plane as a square grid of pixels.
    pub(crate) fn in_grid(camera: &Camera, unit: f64, side: u32) -> View {
        let half_pixel = half_height(camera, unit) / f64::from(side);
        let aspect = camera.pixel_aspect * f64::from(camera.width) / f64::from(camera.height);
        View {
            width: side,
            height: side,
            projection: camera.projection,
            half_pixel: (half_pixel * aspect, half_pixel),
            center: camera.center,
        }
    }
}

/// Half the height of the picture on the image plane.
fn half_height(camera: &Camera, unit: f64) -> f64 {
    match camera.projection {
        Projection::Perspective => camera.half_height,
        Projection::Orthographic => camera.half_height * unit,
    }
}

/// A tile of the picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tile {
    pub(crate) view: View,
    /// Its first column and row: multiples of `SIDE`.
    pub(crate) corner: (u32, u32),
    /// The requested pixels of this tile and others.
    pub(crate) window: Window,
}

/// Requested pixels of one row of a tile.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Span {
    /// The index of the first pixel in the window.
    pub(crate) pixel: usize,
    /// The lane of the first pixel in the tile.
    pub(crate) lane: usize,
    pub(crate) count: usize,
}

impl Tile {
    /// The tiles that a window overlaps, row by row.
    pub(crate) fn all(view: View, window: Window) -> impl Iterator<Item = Tile> {
        let first = |start: u32| start - start % SIDE;
        let rows = (first(window.y)..window.y + window.height).step_by(SIDE as usize);
        rows.flat_map(move |row| {
            let columns = (first(window.x)..window.x + window.width).step_by(SIDE as usize);
            columns.map(move |column| Tile { view, corner: (column, row), window })
        })
    }

    /// Whether all pixels of the tile are requested.
    #[inline(always)]
    pub(crate) fn is_whole(&self) -> bool {
        self.wants(0) && self.wants(LANES - 1)
    }

    /// Whether the pixel of a lane is requested.
    #[inline(always)]
    pub(crate) fn wants(&self, lane: usize) -> bool {
        let x = self.corner.0 + lane as u32 % SIDE;
        let y = self.corner.1 + lane as u32 / SIDE;
        let window = &self.window;
        // A pixel left of or above the window wraps around to something large.
        x.wrapping_sub(window.x) < window.width && y.wrapping_sub(window.y) < window.height
    }

    /// Copy the requested pixels of a tile into an array of the window.
    #[inline(always)]
    pub(crate) fn put<T: Copy>(&self, array: &mut [T], tile: &[T; LANES]) {
        for Span { pixel, lane, count } in self.spans() {
            let to = &mut array[pixel..pixel + count];
            let from = &tile[lane..lane + count];
            // Most rows are whole, and need no call to `memcpy`.
            match (<&mut [T; STEP]>::try_from(&mut *to), <&[T; STEP]>::try_from(from)) {
                (Ok(to), Ok(from)) => *to = *from,
                _ => to.copy_from_slice(from),
            }
        }
    }

    /// The requested pixels, row by row.
    pub(crate) fn spans(&self) -> impl Iterator<Item = Span> + use<> {
        let Tile { corner, window, .. } = *self;
        let left = corner.0.max(window.x);
        let right = (corner.0 + SIDE).min(window.x + window.width);
        let top = corner.1.max(window.y);
        let bottom = (corner.1 + SIDE).min(window.y + window.height);
        (top..bottom).map(move |y| Span {
            pixel: (y - window.y) as usize * window.width as usize + (left - window.x) as usize,
            lane: ((y - corner.1) * SIDE + left - corner.0) as usize,
            count: (right - left) as usize,
        })
    }
}

#[cfg(test)]
mod tests;
