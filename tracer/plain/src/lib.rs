//! Plainly valid scenes, from their bytes to the file of a picture: what `rtcli/rendering` does for all others.
//!
//! | module | contents, each using only those above it |
//! |---|---|
//! | `decode` | how to get the values of a pass from a picture, in JSON |
//! | `vector` | vectors, computed as in `rtcli.scene.vectors` |
//! | `scene` | a scene file as a world, with what its metadata needs |
//! | `matrices` | the matrices of a camera |
//! | `metadata` | the fingerprint of a scene, and the texts of its pictures |
//! | `file` | a file that is complete or absent, and its hash |
//! | `picture` | a scene file as the file of a picture |

#![forbid(unsafe_code)]

mod decode;
mod file;
mod matrices;
mod metadata;
mod picture;
mod scene;
mod vector;

pub use decode::decode_json;
pub use matrices::{camera_matrices, intrinsics};
pub use picture::{FileError, Picture, PictureFile, Seconds};
pub use scene::{Lens, PlainScene, camera};
