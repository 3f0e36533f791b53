//! The samples of a template: its values with draws as JSON, and its objects, drawn until they meet their constraints.
//!
//! | module | contents, each using only those above it |
//! |---|---|
//! | `json` | lists, texts and mappings as JSON |
//! | `color` | hue, saturation and value as a linear color |
//! | `value` | values with draws among their parts, and the kinds of draws |
//! | `constraints` | what objects are checked against, and the kinds of constraints |
//! | `sampler` | a template: its sections, and its objects one by one |
//!
//! Templates are checked in Python, which compiles them for this crate. Functions return None for values that no
//! checked template has.

#![forbid(unsafe_code)]

mod color;
mod constraints;
mod json;
mod sampler;
mod value;

pub use constraints::{Placed, Requirement, Shape, Vector, View, negative};
pub use json::mapping;
pub use sampler::{Caller, Group, Outcome, Refusal, Rejections, Sampler, Try};
pub use value::{Context, Drawn, Value};
