//! The native tracer of rtcli: spheres, planes, boxes and point lights, in float32 SIMD on all cores.
//!
//! Every ray passes through the eye or a light. All that depends on that point alone is computed once in float64,
//! so float32 only carries small differences: see `tile` for the rays and `shapes` for their hits.
//!
//! | module | contents, each using only those above it |
//! |---|---|
//! | `vector`, `bounds`, `apex`, [`memory`], [`names`], [`simd`] | arithmetic, checked allocation, names, SIMD levels |
//! | `camera`, `camera_space` | the camera, and the transformation from the world to its space |
//! | `tile`: `rays`, `hits` | 16 x 16 pixels of a picture, their rays, and the nearest hit of each |
//! | `budget`, `monitor` | bounded work, progress, cancellation |
//! | `shapes`: `sphere`, `plane`, `cuboid` | parameters, intersection, occlusion and bounds of each shape |
//! | [`world`] | the input: camera, objects, lights, settings |
//! | `accel`: `cone`, `pyramid`, `node`, `build` | the bounding volume hierarchy over the objects |
//! | `sampling` | the offsets of a pixel's samples, and the places of an emitter |
//! | `scene`: `unit`, `emitter` | the world in camera space |
//! | `shading`: `soft` | the light that objects send to the eye |
//! | `trace`: `tile_tracer`, `groups`, `depth_resolver`, `coverage` | one tile, from rays to radiance |
//! | [`output`]: `film`, `develop`, `meter`, `png`, `pass_picture`, `rle` | from tiles to arrays and files |
//! | [`render`] | whole pictures, on all cores |

// Loops over lanes index several arrays at once, which the compiler turns into vectors.
#![allow(clippy::needless_range_loop)]

mod accel;
mod apex;
mod bounds;
mod budget;
mod camera;
mod camera_space;
mod checker;
pub mod memory;
mod monitor;
pub mod names;
#[cfg(test)]
mod oracle;
pub mod output;
pub mod render;
mod sampling;
mod scene;
mod shading;
mod shapes;
pub mod simd;
mod tile;
mod trace;
mod vector;
pub mod world;

pub use budget::WorkBudget;
pub use camera::half_tangent;
pub use monitor::{Monitor, Stopped};
pub use output::film::{Film, Pass, ValueType, Values};
pub use output::{develop, meter, pass_picture, png, rle};
pub use render::Tracer;
pub use sampling::{emitter_places, sample_offsets};
pub use simd::Level;
pub use tile::SIDE as TILE_SIDE;
