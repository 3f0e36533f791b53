//! Plain YAML: block and flow style, comments, and scalars of one line without escapes.
//!
//! What it reads, libyaml reads too, as the same data. It gives up on tags, directives, several documents, block
//! scalars, merge keys, null, tabs, and characters that YAML does not allow; on anchors of collections in block style,
//! and names of anchors used twice; and on flow collections with a comma after the last value, keys that are not
//! words, and other YAML that scenes do without.
//!
//! An alias is read by going back to its anchor, so that its value is counted and checked wherever it stands.

use crate::number::{Notation, Number, number};
use crate::source::{Source, Span};
use crate::table::MAX_GROWTH;

/// The most anchors of a text, and the most bytes of a value with an anchor, so that looking up aliases and reading
/// their values takes little time.
const MOST_ANCHORS: usize = 100;
const LONGEST_ANCHORED: usize = 1_000;

/// A text in YAML.
pub struct Yaml<'a> {
    text: &'a [u8],
    at: usize,
    /// Where the current line starts. It counts only in block style.
    line: usize,
    /// The number of open flow collections.
    flow: usize,
    /// The column of the innermost open collection in block style, -1 outside of all.
    indent: isize,
    /// Whether nothing but a hyphen is before the next value in its line: a mapping may start in this line.
    after_hyphen: bool,
    /// The values with an anchor that are read to their ends.
    anchors: Vec<Anchor<'a>>,
    /// At least the number of values that aliases have added.
    growth: usize,
    /// The anchor of the next value, and what to go on with after it.
    next: Properties<'a>,
    /// The last scalar, key or bracket; none where a collection in block style ends.
    last: Option<Span>,
}

/// A position in a text, in the collections that are open there.
#[derive(Clone, Copy, PartialEq)]
struct Place {
    at: usize,
    line: usize,
    flow: usize,
    indent: isize,
}

/// A value with an anchor: the name, where the value starts, and its length.
struct Anchor<'a> {
    name: &'a [u8],
    start: Place,
    length: usize,
}

/// What stands before a value.
#[derive(Clone, Copy, Default)]
struct Properties<'a> {
    /// The name of its anchor, and where it starts.
    anchor: Option<(&'a [u8], Place)>,
    /// The place after the alias that stands for it.
    after_alias: Option<Place>,
}

/// A mapping or list.
pub struct Container<'a> {
    is_empty: bool,
    /// The indentation of a collection in block style, and that of the one around it.
    block: Option<(isize, isize)>,
    properties: Properties<'a>,
}

impl<'a> Yaml<'a> {
    /// Starts to read a text, or gives up at once for its characters.
    pub fn new(text: &'a str) -> Option<Self> {
        if !is_printable(text) {
            return None;
        }
        let text = text.as_bytes();
        let mut yaml = Yaml {
            text,
            at: 0,
            line: 0,
            flow: 0,
            indent: -1,
            after_hyphen: false,
            anchors: Vec::new(),
            growth: 0,
            next: Properties::default(),
            last: None,
        };
        yaml.skip_spaces();
        if yaml.at_line_end() {
            yaml.next_line();
        }
        if yaml.column() == 0 && yaml.text[yaml.at..].starts_with(b"---") {
            yaml.at += 3;
            yaml.end_line()?;
        }
        Some(yaml)
    }

    /// Keeps the span of a token that ends here.
    fn keep(&mut self, start: usize) {
        self.last = Some(Span::new(start, self.at));
    }

    fn peek(&self) -> Option<u8> {
        self.text.get(self.at).copied()
    }

    fn column(&self) -> isize {
        (self.at - self.line) as isize
    }

    fn skip_spaces(&mut self) {
        while self.peek() == Some(b' ') {
            self.at += 1;
        }
    }

    /// Whether the line ends here, or with a comment; spaces before it are skipped already.
    fn at_line_end(&self) -> bool {
        match self.peek() {
            None | Some(b'\n') => true,
            Some(b'\r') => self.text.get(self.at + 1) == Some(&b'\n'),
            Some(b'#') => self.at == 0 || matches!(self.text[self.at - 1], b' ' | b'\n'),
            _ => false,
        }
    }

    /// Moves to the first character of the next line that has one beside a comment.
    fn next_line(&mut self) {
        while self.at_line_end() && self.at < self.text.len() {
            let rest = &self.text[self.at..];
            self.at += rest.iter().position(|&byte| byte == b'\n').map_or(rest.len(), |end| end + 1);
            self.line = self.at;
            self.skip_spaces();
        }
    }

    /// Moves on after a value in block style, behind which its line must end.
    fn end_line(&mut self) -> Option<()> {
        self.skip_spaces();
        self.at_line_end().then(|| self.next_line())
    }

    /// Moves to the next token of a flow collection, which may be in another line.
    fn skip_in_flow(&mut self) {
        self.skip_spaces();
        while self.at < self.text.len() && self.at_line_end() {
            self.next_line();
        }
    }

    /// Moves to where a value starts in its line, after its anchor, or to the anchor of its alias.
    fn start(&mut self) -> Option<()> {
        if self.flow > 0 {
            self.skip_in_flow();
        } else {
            self.skip_spaces();
        }
        match self.peek() {
            Some(b'&') => {
                let name = self.take_name()?;
                let start = self.at;
                self.skip_spaces();
                if self.at == start || self.at_line_end() || matches!(self.peek(), Some(b'&' | b'*')) {
                    return None;
                }
                self.next.anchor = Some((name, self.place()));
            }
            Some(b'*') => {
                let name = self.take_name()?;
                let place = self.place();
                let anchor = self.anchors.iter().find(|anchor| anchor.name == name)?;
                let start = anchor.start;
                // A value and the comma after it take two bytes at least.
                self.growth += 2 + anchor.length / 2;
                if self.growth > MAX_GROWTH {
                    return None;
                }
                // An alias cannot stand for another one, nor have an anchor.
                self.next.after_alias = Some(place);
                self.go_to(start);
            }
            _ => {}
        }
        Some(())
    }

    /// Reads the name of an anchor or alias, after its sign.
    fn take_name(&mut self) -> Option<&'a [u8]> {
        let rest = &self.text[self.at + 1..];
        let in_name = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'_' || byte == b'-';
        let end = rest.iter().position(|&byte| !in_name(byte)).unwrap_or(rest.len());
        self.at += 1 + end;
        (end > 0).then_some(&rest[..end])
    }

    fn place(&self) -> Place {
        Place { at: self.at, line: self.line, flow: self.flow, indent: self.indent }
    }

    fn go_to(&mut self, place: Place) {
        Place { at: self.at, line: self.line, flow: self.flow, indent: self.indent } = place;
    }

    /// Moves on after a value; gives up if it goes on.
    fn end(&mut self, properties: Properties<'a>) -> Option<()> {
        let end = self.at;
        self.end_text()?;
        if let Some(anchor) = properties.anchor {
            self.add_anchor(anchor, end)?;
        }
        if let Some(place) = properties.after_alias {
            self.go_to(place);
            self.end_text()?;
        }
        Some(())
    }

    /// Keeps an anchor whose value ends at an offset.
    fn add_anchor(&mut self, (name, start): (&'a [u8], Place), end: usize) -> Option<()> {
        if let Some(known) = self.anchors.iter().find(|known| known.name == name) {
            // The same one inside of a value that is read for an alias, or else another one.
            return (known.start == start).then_some(());
        }
        let length = end - start.at;
        let is_plain = self.anchors.len() < MOST_ANCHORS && length <= LONGEST_ANCHORED;
        is_plain.then(|| self.anchors.push(Anchor { name, start, length }))
    }

    fn end_text(&mut self) -> Option<()> {
        if self.flow == 0 {
            return self.end_line();
        }
        matches!(self.peek()?, b',' | b']' | b'}' | b' ' | b'\n' | b'\r').then_some(())
    }

    /// Starts a collection: in flow style with a bracket, or in block style with its first item or key.
    fn open(&mut self, bracket: u8) -> Option<Container<'a>> {
        let after_hyphen = std::mem::take(&mut self.after_hyphen);
        self.start()?;
        let is_inline = self.flow > 0 || !self.at_line_end();
        if !is_inline {
            self.next_line();
        }
        let column = self.column();
        let properties = std::mem::take(&mut self.next);
        if self.peek() == Some(bracket) {
            // In a line of its own it must be indented.
            if !is_inline && column <= self.indent {
                return None;
            }
            self.at += 1;
            self.flow += 1;
            self.keep(self.at - 1);
            return Some(Container { is_empty: true, block: None, properties });
        }
        // The items of a list may stand below the key that leads to it.
        let is_list = bracket == b'[';
        let is_deeper = column > self.indent || (is_list && !after_hyphen && column == self.indent);
        let may_start = if is_inline { self.indent < 0 || (after_hyphen && !is_list) } else { is_deeper };
        let has_properties = properties.anchor.is_some() || properties.after_alias.is_some();
        if self.flow > 0 || !may_start || has_properties || self.at == self.text.len() {
            return None;
        }
        self.keep(self.at);
        let block = Some((column, std::mem::replace(&mut self.indent, column)));
        Some(Container { is_empty: true, block, properties })
    }

    /// Returns whether a collection in flow style has another value, and moves to it.
    fn next_in_flow(&mut self, container: &mut Container<'a>, end: u8) -> Option<bool> {
        self.skip_in_flow();
        if self.peek()? == end {
            self.at += 1;
            self.flow -= 1;
            self.keep(self.at - 1);
            self.end(container.properties)?;
            return Some(false);
        }
        if !container.is_empty {
            if self.peek()? != b',' {
                return None;
            }
            self.at += 1;
            self.skip_in_flow();
        }
        container.is_empty = false;
        Some(true)
    }

    /// Returns whether a collection in block style goes on at its indentation.
    fn goes_on(&mut self, container: &mut Container<'a>, (column, around): (isize, isize)) -> Option<bool> {
        let is_first = std::mem::take(&mut container.is_empty);
        if self.at < self.text.len() && self.column() == column {
            return Some(true);
        }
        if is_first || (self.at < self.text.len() && self.column() > column) {
            return None;
        }
        self.indent = around;
        self.last = None;
        Some(false)
    }

    /// Reads a key and its colon.
    fn take_key(&mut self) -> Option<&'a [u8]> {
        self.after_hyphen = false;
        let is_quoted = matches!(self.peek()?, b'"' | b'\'');
        let start = self.at;
        let key = if is_quoted {
            self.quoted()?
        } else {
            let rest = &self.text[self.at..];
            let end = rest.iter().position(|byte| !(byte.is_ascii_alphanumeric() || *byte == b'_'))?;
            self.at += end;
            &rest[..end]
        };
        self.keep(start);
        if self.peek()? != b':' {
            return None;
        }
        self.at += 1;
        let is_apart = matches!(self.peek(), None | Some(b' ' | b'\n' | b'\r'));
        (is_apart || (is_quoted && self.flow > 0)).then_some(key)
    }

    /// Reads a text in quotes, which holds neither escapes nor line ends.
    fn quoted(&mut self) -> Option<&'a [u8]> {
        let quote = self.peek()?;
        let rest = &self.text[self.at + 1..];
        let end = rest.iter().position(|&byte| byte == quote || byte == b'\\' || byte < b' ')?;
        self.at += end + 2;
        // Two single quotes stand for one.
        let is_plain = rest[end] == quote && (quote == b'"' || rest.get(end + 1) != Some(&quote));
        is_plain.then_some(&rest[..end])
    }

    /// Reads a text without quotes: words that start with a letter, without any character that could mean more.
    fn words(&mut self) -> Option<&'a [u8]> {
        let rest = &self.text[self.at..];
        let is_word = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'_' || !byte.is_ascii();
        let in_words = |byte: u8| is_word(byte) || b" -./()+".contains(&byte);
        let end = rest.iter().position(|&byte| !in_words(byte)).unwrap_or(rest.len());
        let words = rest[..end].trim_ascii_end();
        if words.first().is_none_or(|&first| !is_word(first) || first.is_ascii_digit()) || means_no_text(words) {
            return None;
        }
        self.at += words.len();
        Some(words)
    }
}

impl<'a> Source<'a> for Yaml<'a> {
    type Container = Container<'a>;

    fn open_mapping(&mut self) -> Option<Container<'a>> {
        self.open(b'{')
    }

    fn open_list(&mut self) -> Option<Container<'a>> {
        self.open(b'[')
    }

    fn key(&mut self, mapping: &mut Container<'a>) -> Option<Option<&'a [u8]>> {
        let has_more = match mapping.block {
            None => self.next_in_flow(mapping, b'}')?,
            Some(block) => self.goes_on(mapping, block)?,
        };
        if has_more { self.take_key().map(Some) } else { Some(None) }
    }

    fn item(&mut self, list: &mut Container<'a>) -> Option<bool> {
        let Some(block) = list.block else {
            return self.next_in_flow(list, b']');
        };
        let is_first = list.is_empty;
        if !self.goes_on(list, block)? {
            return Some(false);
        }
        let is_item =
            self.peek() == Some(b'-') && matches!(self.text.get(self.at + 1), Some(b' ' | b'\n' | b'\r'));
        if is_item {
            self.at += 1;
            self.after_hyphen = true;
            return Some(true);
        }
        // The next key of the mapping around a list that is not indented.
        self.indent = block.1;
        self.last = None;
        (!is_first && block.0 == block.1).then_some(false)
    }

    fn number(&mut self) -> Option<Number> {
        self.start()?;
        let properties = std::mem::take(&mut self.next);
        let (number, length) = number(&self.text[self.at..], Notation::Yaml)?;
        self.at += length;
        self.keep(self.at - length);
        self.end(properties)?;
        Some(number)
    }

    fn text(&mut self) -> Option<&'a [u8]> {
        self.start()?;
        let properties = std::mem::take(&mut self.next);
        let start = self.at;
        let text = if matches!(self.peek()?, b'"' | b'\'') { self.quoted()? } else { self.words()? };
        self.keep(start);
        self.end(properties)?;
        Some(text)
    }

    fn boolean(&mut self) -> Option<bool> {
        self.start()?;
        let properties = std::mem::take(&mut self.next);
        let rest = &self.text[self.at..];
        let length = rest.iter().position(|byte| !byte.is_ascii_alphabetic()).unwrap_or(rest.len());
        let value = boolean(&rest[..length])?;
        self.at += length;
        self.keep(self.at - length);
        self.end(properties)?;
        Some(value)
    }

    fn has_list(&mut self) -> Option<bool> {
        self.start()?;
        Some(self.at_line_end() || self.peek() == Some(b'['))
    }

    fn has_number(&mut self) -> Option<bool> {
        self.start()?;
        Some(matches!(self.peek(), Some(b'0'..=b'9' | b'+' | b'-' | b'.')))
    }

    fn at_end(&mut self) -> bool {
        self.at == self.text.len()
    }

    fn last(&self) -> Option<Span> {
        self.last
    }
}

/// Returns the value of true or false by the core schema (YAML 1.2.2, section 10.3.2).
fn boolean(word: &[u8]) -> Option<bool> {
    match word {
        b"true" | b"True" | b"TRUE" => Some(true),
        b"false" | b"False" | b"FALSE" => Some(false),
        _ => None,
    }
}

/// Whether words without quotes are null, true or false by the core schema.
fn means_no_text(words: &[u8]) -> bool {
    matches!(words, b"null" | b"Null" | b"NULL") || boolean(words).is_some()
}

/// Whether a text holds only printable characters (`c-printable`, YAML 1.2.2, section 5.1), without tabs and line ends
/// other than `\n` and `\r\n`.
fn is_printable(text: &str) -> bool {
    // In pieces, each without a branch, so that they are checked many bytes at a time.
    let is_plain = |piece: &[u8]| {
        piece.iter().fold(true, |plain, &byte| plain & ((b' '..0x7f).contains(&byte) | (byte == b'\n')))
    };
    if text.as_bytes().chunks(4096).all(is_plain) {
        return true;
    }
    let mut characters = text.chars().peekable();
    while let Some(character) = characters.next() {
        let is_printable = match character {
            '\n' | ' '..='~' => true,
            '\r' => characters.peek() == Some(&'\n'),
            '\u{2028}' | '\u{2029}' => false,
            '\u{a0}'..='\u{d7ff}' | '\u{e000}'..='\u{fefe}' | '\u{ff00}'..='\u{fffd}' => true,
            _ => character >= '\u{10000}',
        };
        if !is_printable {
            return false;
        }
    }
    true
}
