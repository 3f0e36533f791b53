//! What the rays of a tile see.

pub(crate) mod coverage;
pub(crate) mod depth_resolver;
pub(crate) mod groups;
pub(crate) mod tile_tracer;
