//! JSON (RFC 8259), without escapes.

use crate::number::{Notation, Number, number};
use crate::source::{Source, Span};

/// A text in JSON.
pub struct Json<'a> {
    text: &'a [u8],
    at: usize,
    last: Span,
}

/// A mapping or list.
pub struct Container {
    is_empty: bool,
}

impl<'a> Json<'a> {
    /// Starts to read a text.
    pub fn new(text: &'a str) -> Self {
        Json { text: text.as_bytes(), at: 0, last: Span::default() }
    }

    fn peek(&mut self) -> Option<u8> {
        while let Some(b' ' | b'\n' | b'\t' | b'\r') = self.text.get(self.at) {
            self.at += 1;
        }
        self.text.get(self.at).copied()
    }

    /// Keeps the span of a token that ends here.
    fn keep(&mut self, start: usize) {
        self.last = Span::new(start, self.at);
    }

    fn take(&mut self, token: u8) -> Option<()> {
        (self.peek()? == token).then(|| self.at += 1)
    }

    /// Skips the comma before the next value of a container and returns true, or its end and returns false.
    fn next(&mut self, container: &mut Container, end: u8) -> Option<bool> {
        if self.peek()? == end {
            self.at += 1;
            self.keep(self.at - 1);
            return Some(false);
        }
        if !container.is_empty {
            self.take(b',')?;
        }
        container.is_empty = false;
        Some(true)
    }
}

impl<'a> Source<'a> for Json<'a> {
    type Container = Container;

    fn open_mapping(&mut self) -> Option<Container> {
        self.take(b'{')?;
        self.keep(self.at - 1);
        Some(Container { is_empty: true })
    }

    fn open_list(&mut self) -> Option<Container> {
        self.take(b'[')?;
        self.keep(self.at - 1);
        Some(Container { is_empty: true })
    }

    fn key(&mut self, mapping: &mut Container) -> Option<Option<&'a [u8]>> {
        if !self.next(mapping, b'}')? {
            return Some(None);
        }
        let key = self.text()?;
        self.take(b':')?;
        Some(Some(key))
    }

    fn item(&mut self, list: &mut Container) -> Option<bool> {
        self.next(list, b']')
    }

    fn number(&mut self) -> Option<Number> {
        self.peek()?;
        let (number, length) = number(&self.text[self.at..], Notation::Json)?;
        self.at += length;
        self.keep(self.at - length);
        Some(number)
    }

    fn text(&mut self) -> Option<&'a [u8]> {
        self.take(b'"')?;
        let start = self.at;
        let rest = &self.text[start..];
        let end = rest.iter().position(|&byte| byte == b'"' || byte == b'\\' || byte < b' ')?;
        self.at = start + end + 1;
        self.keep(start - 1);
        (rest[end] == b'"').then_some(&rest[..end])
    }

    fn boolean(&mut self) -> Option<bool> {
        self.peek()?;
        let (value, word) = [(true, "true"), (false, "false")]
            .into_iter()
            .find(|(_, word)| self.text[self.at..].starts_with(word.as_bytes()))?;
        self.at += word.len();
        self.keep(self.at - word.len());
        Some(value)
    }

    fn has_list(&mut self) -> Option<bool> {
        Some(self.peek()? == b'[')
    }

    fn has_number(&mut self) -> Option<bool> {
        Some(self.peek()? != b'"')
    }

    fn at_end(&mut self) -> bool {
        self.peek().is_none()
    }

    fn last(&self) -> Option<Span> {
        Some(self.last)
    }
}
