//! A text as mappings, lists and scalars, one after the other.

use crate::number::Number;

pub mod json;
pub mod yaml;

/// A part of a text, from its first byte to the one after its last.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Span {
    /// The first byte.
    pub start: u32,
    /// The one after the last.
    pub end: u32,
}

impl Span {
    /// Returns a span of a text, whose size the limits of a file keep far below 4 GiB.
    pub fn new(start: usize, end: usize) -> Span {
        Span { start: start as u32, end: end as u32 }
    }
}

/// Returns the text of a file after its byte order mark, if it has one.
pub fn text_of(file: &[u8]) -> &[u8] {
    file.strip_prefix(b"\xef\xbb\xbf").unwrap_or(file)
}

/// A text that is read from its start to its end. Each method gives up with None, and the text is then of no use.
pub trait Source<'a> {
    /// A mapping or list that is open.
    type Container;

    /// Starts a mapping.
    fn open_mapping(&mut self) -> Option<Self::Container>;

    /// Starts a list.
    fn open_list(&mut self) -> Option<Self::Container>;

    /// Returns the next key of a mapping, whose value comes next, or Some(None) after its end.
    fn key(&mut self, mapping: &mut Self::Container) -> Option<Option<&'a [u8]>>;

    /// Returns whether a list has another item, which comes next.
    fn item(&mut self, list: &mut Self::Container) -> Option<bool>;

    /// Reads a number.
    fn number(&mut self) -> Option<Number>;

    /// Reads a text, whose bytes are UTF-8.
    fn text(&mut self) -> Option<&'a [u8]>;

    /// Reads true or false.
    fn boolean(&mut self) -> Option<bool>;

    /// Whether a list comes next, or else a scalar.
    fn has_list(&mut self) -> Option<bool>;

    /// Whether a number comes next, or else a text.
    fn has_number(&mut self) -> Option<bool>;

    /// Whether nothing comes next.
    fn at_end(&mut self) -> bool;

    /// Returns the span of the last scalar, key or bracket; of a collection in block style, the empty one where it
    /// starts, and None where it ends.
    fn last(&self) -> Option<Span>;
}
