//! Where the values of a valid scene file stand.

use crate::number::Number;
use crate::scene::{Format, read_from};
use crate::source::json::Json;
use crate::source::yaml::Yaml;
use crate::source::{Source, Span, text_of};

/// A value of a file, in the order of the file; those in it follow it.
#[derive(Clone, Copy, Debug)]
struct Node {
    span: Span,
    /// Its key, in a mapping.
    key: Option<Span>,
    is_container: bool,
    /// The index of the first node after it and all in it.
    next: u32,
}

/// The places of all values and keys in the text of a valid scene file, as offsets of bytes.
#[derive(Clone, Debug, Default)]
pub struct Spans {
    nodes: Vec<Node>,
}

impl Spans {
    /// Returns the spans of a file, after its byte order mark if it has one; None if it is not plainly valid.
    pub fn of(bytes: &[u8], format: Format) -> Option<Spans> {
        let text = str::from_utf8(text_of(bytes)).ok()?;
        match format {
            Format::Json => Tracked::read(Json::new(text)),
            Format::Yaml => Tracked::read(Yaml::new(text)?),
        }
    }

    /// Returns the span of a value, by its index; the whole file has 0.
    pub fn value(&self, index: usize) -> Span {
        self.nodes[index].span
    }

    /// Returns the span of the key of a value, with its quotes, if it is in a mapping.
    pub fn key(&self, index: usize) -> Option<Span> {
        self.nodes[index].key
    }

    /// Whether a value is a list or mapping.
    pub fn is_container(&self, index: usize) -> bool {
        self.nodes[index].is_container
    }

    /// Returns the indices of the values in a list or mapping, in order.
    pub fn children(&self, index: usize) -> impl Iterator<Item = usize> {
        let end = self.nodes[index].next as usize;
        let next = move |&child: &usize| Some(self.nodes[child].next as usize).filter(|&child| child < end);
        std::iter::successors(Some(index + 1).filter(|&child| child < end), next)
    }
}

/// A source that keeps where each value stands.
struct Tracked<S> {
    source: S,
    spans: Spans,
    /// The key of the next value.
    key: Option<Span>,
    /// The open collections, outermost first.
    open: Vec<usize>,
}

impl<'a, S: Source<'a>> Tracked<S> {
    fn read(source: S) -> Option<Spans> {
        let mut tracked = Tracked { source, spans: Spans::default(), key: None, open: Vec::new() };
        read_from(&mut tracked)?;
        Some(tracked.spans)
    }

    /// Adds the value that starts with the last token.
    fn add(&mut self, is_container: bool) -> Option<usize> {
        let nodes = &mut self.spans.nodes;
        let (index, next) = (nodes.len(), u32::try_from(nodes.len() + 1).ok()?);
        let span = self.source.last()?;
        nodes.try_reserve(1).ok()?;
        nodes.push(Node { span, key: self.key.take(), is_container, next });
        if is_container {
            self.open.push(index);
        } else {
            self.extend(index);
        }
        Some(index)
    }

    /// Ends the innermost open collection: with its bracket, or in block style with its last value.
    fn close(&mut self) -> Option<()> {
        let index = self.open.pop()?;
        let next = u32::try_from(self.spans.nodes.len()).ok()?;
        let node = &mut self.spans.nodes[index];
        node.next = next;
        if let Some(bracket) = self.source.last() {
            node.span.end = bracket.end;
        } else if node.span.end == node.span.start {
            node.span.end += 1; // the hyphen of a list that has aliases only
        }
        self.extend(index);
        Some(())
    }

    /// Extends the collection around a value to its end. An alias, whose value stands before it, counts by its key.
    fn extend(&mut self, index: usize) {
        let Node { span, key, .. } = self.spans.nodes[index];
        if let Some(&around) = self.open.last() {
            let end = &mut self.spans.nodes[around].span.end;
            *end = (*end).max(key.map_or(0, |key| key.end));
            if span.start >= *end {
                *end = span.end;
            }
        }
    }
}

impl<'a, S: Source<'a>> Source<'a> for Tracked<S> {
    type Container = S::Container;

    fn open_mapping(&mut self) -> Option<S::Container> {
        let container = self.source.open_mapping()?;
        self.add(true)?;
        Some(container)
    }

    fn open_list(&mut self) -> Option<S::Container> {
        let container = self.source.open_list()?;
        self.add(true)?;
        Some(container)
    }

    fn key(&mut self, mapping: &mut S::Container) -> Option<Option<&'a [u8]>> {
        let key = self.source.key(mapping)?;
        if key.is_some() {
            self.key = self.source.last();
        } else {
            self.close()?;
        }
        Some(key)
    }

    fn item(&mut self, list: &mut S::Container) -> Option<bool> {
        let has_item = self.source.item(list)?;
        if !has_item {
            self.close()?;
        }
        Some(has_item)
    }

    fn number(&mut self) -> Option<Number> {
        let number = self.source.number()?;
        self.add(false)?;
        Some(number)
    }

    fn text(&mut self) -> Option<&'a [u8]> {
        let text = self.source.text()?;
        self.add(false)?;
        Some(text)
    }

    fn boolean(&mut self) -> Option<bool> {
        let boolean = self.source.boolean()?;
        self.add(false)?;
        Some(boolean)
    }

    fn has_list(&mut self) -> Option<bool> {
        self.source.has_list()
    }

    fn has_number(&mut self) -> Option<bool> {
        self.source.has_number()
    }

    fn at_end(&mut self) -> bool {
        self.source.at_end()
    }

    fn last(&self) -> Option<Span> {
        self.source.last()
    }
}
