//! The pixels that an object would cover if it were alone, and their number.
//!
//! The search subdivides the picture into squares of tiles and tests only the tiles on an object's outline ray by
//! ray: the work grows with the length of the outline, not with the area.

use crate::budget::{WorkCounter, steps_of};
use crate::camera::Projection;
use crate::monitor::Monitor;
use crate::shapes::outline::{Overlap, Rectangle};
use crate::shapes::primitive::Primitive;
use crate::shapes::{Shape, Shapes};
use crate::simd::Kernel;
use crate::tile::hits::{HitBuffer, NO_FACE};
use crate::tile::rays::{Ray, Rays};
use crate::tile::{CENTRE, LANES, SIDE, Tile, View};
use crate::vector::Vector;
use crate::world::Window;

/// The steps of testing one tile: generating the rays, testing and counting.
const TILE_STEPS: u64 = 2 * steps_of(LANES);

/// Counts the pixels that some shapes cover.
pub(crate) struct Coverage<'a> {
    pub(crate) shapes: &'a Shapes,
    /// The index of the first shape.
    pub(crate) first: u32,
    pub(crate) view: View,
    pub(crate) window: Window,
    pub(crate) monitor: &'a Monitor,
    /// The result for each shape.
    pub(crate) covered: &'a mut [u64],
}

impl Kernel for Coverage<'_> {
    #[inline(always)]
    fn run(self) {
        let mut search = Search {
            view: self.view,
            window: self.window,
            rays: Rays::new(),
            hits: HitBuffer::new(),
            mask: &mut [],
        };
        for (index, covered) in (self.first..).zip(self.covered) {
            if self.monitor.check().is_err() {
                return;
            }
            let mut work = self.monitor.budget.counter();
            *covered = search.count(self.shapes.get(index), &mut work, || self.monitor.cancelled());
            self.monitor.budget.spend(work);
        }
    }
}

/// Marks the pixels that a shape covers.
pub(crate) struct AmodalMask<'a> {
    pub(crate) shape: Shape<'a>,
    pub(crate) view: View,
    pub(crate) window: Window,
    pub(crate) monitor: &'a Monitor,
    /// A byte for each pixel, row by row: 1 for those that the shape covers, the others stay as they are.
    pub(crate) mask: &'a mut [u8],
}

impl Kernel for AmodalMask<'_> {
    #[inline(always)]
    fn run(self) {
        let AmodalMask { shape, view, window, monitor, mask } = self;
        let mut work = monitor.budget.counter();
        let mut search = Search { view, window, rays: Rays::new(), hits: HitBuffer::new(), mask };
        search.count(shape, &mut work, || monitor.cancelled());
        monitor.budget.spend(work);
    }
}

/// A search through the tiles of a window.
struct Search<'a> {
    view: View,
    window: Window,
    rays: Rays,
    hits: HitBuffer,
    /// Where to mark the pixels found; empty if only their number matters.
    mask: &'a mut [u8],
}

/// A square of tiles, a power of two in each row.
#[derive(Clone, Copy)]
struct Square {
    /// Its first column and row, pixels.
    corner: (u32, u32),
    /// Its width and height, pixels.
    side: u32,
}

impl Search<'_> {
    /// Count the pixels of a shape.
    #[inline(always)]
    fn count(&mut self, shape: Shape<'_>, work: &mut WorkCounter, cancelled: impl Fn() -> bool) -> u64 {
        let outline = shape.outline(self.view.projection);
        let mut covered = 0;
        let mut waiting = vec![self.all()];
        while let Some(square) = waiting.pop() {
            if !work.take(1) || cancelled() {
                return 0;
            }
            let Some(part) = self.clip(square) else { continue };
            let projection = self.view.projection;
            let is_met = |[x, y, z]: Vector| {
                let (origin, direction) = match projection {
                    Projection::Perspective => ([0.0; 3], [x, y, z]),
                    Projection::Orthographic => ([x, y, 0.0], [0.0, 0.0, z]),
                };
                shape.depth(Ray { origin, direction, start: 0.0 }).0.is_finite()
            };
            match outline.in_rectangle(&self.rectangle(part), is_met) {
                Overlap::None => {}
                Overlap::Full => {
                    covered += part.pixels() as u64;
                    self.mark(part);
                }
                Overlap::Partial if square.side == SIDE => {
                    if !work.take(TILE_STEPS) {
                        return 0;
                    }
                    covered += self.count_tile(shape, square.corner);
                }
                Overlap::Partial => {
                    let (x, y) = square.corner;
                    let side = square.side / 2;
                    for corner in [(x, y), (x + side, y), (x, y + side), (x + side, y + side)] {
                        waiting.push(Square { corner, side });
                    }
                }
            }
        }
        covered
    }

    /// Mark all pixels of a part of the window.
    fn mark(&mut self, part: Window) {
        let width = self.window.width as usize;
        let left = (part.x - self.window.x) as usize;
        let rows = self.mask.chunks_mut(width).skip((part.y - self.window.y) as usize);
        for row in rows.take(part.height as usize) {
            row[left..left + part.width as usize].fill(1);
        }
    }

    /// The smallest square around the window.
    fn all(&self) -> Square {
        let Window { x, y, width, height } = self.window;
        let corner = (x - x % SIDE, y - y % SIDE);
        let longest = (x + width - corner.0).max(y + height - corner.1);
        let side = SIDE * longest.div_ceil(SIDE).next_power_of_two();
        Square { corner, side }
    }

    /// The part of a square that is in the window.
    fn clip(&self, square: Square) -> Option<Window> {
        let Window { x, y, width, height } = self.window;
        let (left, top) = (square.corner.0.max(x), square.corner.1.max(y));
        let right = (square.corner.0 + square.side).min(x + width);
        let bottom = (square.corner.1 + square.side).min(y + height);
        (left < right && top < bottom).then(|| Window {
            x: left,
            y: top,
            width: right - left,
            height: bottom - top,
        })
    }

    /// The rectangle of some pixels on the image plane (document, section 2.1).
    fn rectangle(&self, part: Window) -> Rectangle {
        let (half_width, half_height) = self.view.half_pixel;
        let (width, height) = (f64::from(self.view.width), f64::from(self.view.height));
        let (center_x, center_y) = self.view.center;
        let x = |column: u32| (2.0 * f64::from(column) - width) * half_width + center_x;
        let y = |row: u32| (height - 2.0 * f64::from(row)) * half_height + center_y;
        Rectangle {
            low: [x(part.x), y(part.y + part.height)],
            high: [x(part.x + part.width), y(part.y)],
            half_pixel: [half_width, half_height],
        }
    }

    /// Test the rays of a tile.
    #[inline(always)]
    fn count_tile(&mut self, shape: Shape<'_>, corner: (u32, u32)) -> u64 {
        let tile = Tile { view: self.view, corner, window: self.window };
        self.rays.generate(self.view, corner, CENTRE);
        self.hits.clear(&self.rays);
        shape.intersect(0, &self.rays, &mut self.hits);
        let mut met = 0;
        for span in tile.spans() {
            let faces = &self.hits.face[span.lane..span.lane + span.count];
            for face in faces {
                met += u64::from(*face != NO_FACE);
            }
            for (pixel, face) in self.mask.iter_mut().skip(span.pixel).zip(faces) {
                *pixel |= u8::from(*face != NO_FACE);
            }
        }
        met
    }
}

#[cfg(test)]
mod tests;
