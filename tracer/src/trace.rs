//! The tracing of a tile, from rays to hits and radiance.

pub(crate) mod coverage;
pub(crate) mod depth_resolver;
pub(crate) mod groups;
pub(crate) mod tile_tracer;
