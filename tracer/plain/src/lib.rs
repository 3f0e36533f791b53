//! Plainly valid scenes, from their bytes to the file of a picture: what `rtcli/rendering` does for all others.
//!
//! | module | contents, each using only those above it |
//! |---|---|
//! | `vector` | vectors, computed as in `rtcli.scene.vectors` |
//! | `scene` | a scene file as a world, with what its metadata needs |
//! | `matrices` | the matrices of a camera |
//! | `metadata` | the fingerprint of a scene, and the texts of its pictures |
//! | `file` | a file that is complete or absent, and its hash |
//! | `picture` | a scene file as the file of a picture |

#![forbid(unsafe_code)]

mod file;
mod matrices;
mod metadata;
mod picture;
mod scene;
mod vector;

pub use matrices::{camera_matrices, intrinsics};
pub use picture::{FileError, Picture, PictureFile, Seconds};
pub use scene::{Lens, PlainScene, camera};
