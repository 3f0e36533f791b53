//! The samples of a template, from their draws to their pictures, labels and files: all that data sets have of one.
//!
//! | module | contents, each using only those above it |
//! |---|---|
//! | `models` | questions about values that are not plainly valid |
//! | `picture` | the picture of a sample and its passes, each traced when it is first asked for |
//! | `constraints` | the constraints that pictures decide |
//! | `labels` | what a sample is, as a line of JSON |
//! | `pass_file` | a pass as a file: levels of a PNG, or NumPy's format |
//! | `files` | the files of a sample, and archives and arrays of them |
//! | `template` | a template, and a sample of it: drawn again until it meets all constraints |
//!
//! The same sample has the same bytes on every machine.

#![forbid(unsafe_code)]

mod constraints;
mod files;
mod labels;
mod models;
mod pass_file;
mod picture;
mod template;

pub use constraints::Requirement;
pub use files::{Array, Outputs, Part};
pub use labels::Header;
pub use models::Models;
pub use picture::{Developers, Engine};
pub use template::{Failure, Made, Request, Sample, Template};
