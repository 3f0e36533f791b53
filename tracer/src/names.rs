//! Names that stand for values, such as those of tone curves in scene files.

use std::error::Error;
use std::fmt;

/// A name that stands for no value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnknownName;

impl fmt::Display for UnknownName {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("unknown name")
    }
}

impl Error for UnknownName {}
