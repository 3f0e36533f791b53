//! From traced tiles to arrays and files.

pub mod develop;
pub mod film;
pub mod meter;
pub mod pass_picture;
pub mod png;
pub mod rle;
