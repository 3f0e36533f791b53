//! The light that objects send to the eye.

pub(crate) mod lighting;
pub(crate) mod shadows;
