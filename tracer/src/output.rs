//! From traced tiles to arrays and files.

pub mod develop;
pub mod film;
pub mod meter;
pub mod png;
pub mod rle;
