//! Valid scene files, from their bytes to numbers in one pass, without a tree of values between.
//!
//! [`read`] takes what is plainly valid: JSON, and YAML without anchors, tags, escapes, or scalars of several lines. It
//! gives up on everything else without a reason; the readers and models in Python then answer. What it takes, they
//! take too, with the same numbers bit for bit.
//!
//! | module | contents, each using only those above it |
//! |---|---|
//! | `number` | decimal numbers as float64 |
//! | `schema`, `table` | what a mapping may hold; generated from the models in Python |
//! | `source`: `json`, `yaml` | a text as mappings, lists and scalars, one after the other |
//! | `row` | one mapping, as the numbers of its keys |
//! | `scene` | a whole file |
//! | `spans` | where its values stand |
//! | [`json`], [`written`] | numbers and texts as Python writes them, and objects as scenes are written |

pub mod json;
mod number;
mod row;
pub mod scene;
pub mod schema;
mod source;
pub mod spans;
#[rustfmt::skip]
mod table;
pub mod written;

pub use scene::{Checkers, Edit, Format, Lights, Objects, Scene, Section, read, read_object};
pub use source::{Span, text_of};
pub use spans::Spans;
