//! The native tracer of rtcli: spheres, planes, boxes and point lights, in float32 SIMD on all cores.
//!
//! Every ray passes through one of a few points, the eye or a light. What depends on that point alone is computed
//! once in float64, and what is left for float32 is small: see `grid` for the rays of a tile, `sphere`, `plane`
//! and `cuboid` for what they meet.
//!
//! | module | what it does |
//! |---|---|
//! | [`world`] | what the tracer is given |
//! | `scene` | the world as the eye has it, and a tree over it (`bvh`) |
//! | `place`, `grid` | the tiles of a picture, and their rays |
//! | `resolve` | which of two faces is nearer that float32 cannot tell apart |
//! | `groups`, `points` | the rays of a tile, sorted by what they meet, and where |
//! | `sphere`, `plane`, `cuboid` | where rays meet a shape, and which points it shadows |
//! | `tile`, `lighting`, `shadow` | the light that comes from a tile |
//! | `contact` | places that lie on a surface |
//! | [`render`] | whole pictures, on all cores |
//! | `coverage` | how many pixels each object would cover if it were alone |
//! | `budget` | a bound for work that nobody should have to wait for |
//! | [`develop`], [`meter`], [`png`] | from radiance to a file |
//! | [`memory`] | what there is no room for is an error |
//! | [`simd`] | which instructions the machine has |

#![deny(unsafe_code, missing_docs)]
// Loops over lanes index several arrays at once, which is what the compiler turns into vectors.
#![allow(clippy::needless_range_loop)]

mod budget;
mod bvh;
mod contact;
mod coverage;
mod cuboid;
pub mod develop;
mod film;
mod grid;
mod groups;
mod lighting;
pub mod memory;
pub mod meter;
#[cfg(test)]
mod oracle;
mod plane;
pub mod png;
mod points;
pub mod render;
mod resolve;
mod sampling;
mod scene;
mod shadow;
pub mod simd;
mod sphere;
mod tile;
mod tile_tracer;
mod vector;
pub mod world;

pub use budget::WorkBudget;
pub use film::Film;
pub use render::{Monitor, Stopped, Tracer};
pub use sampling::sample_offsets;
pub use simd::Level;
pub use tile::focal_length;
