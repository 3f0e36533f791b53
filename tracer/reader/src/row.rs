//! One mapping of a scene file, as the numbers of its keys.

use crate::schema::{Field, Kind, Mapping, Range, Value};
use crate::source::Source;
use crate::table::{COLORS, LEVELS, MAX_VALUES};

/// The most slots of a mapping.
pub const SLOTS: usize = 24;

/// The values of a mapping.
#[derive(Clone, Debug)]
pub struct Row<'a> {
    /// The numbers in the slots of its keys.
    pub numbers: [f64; SLOTS],
    /// The keys that it has, one bit each.
    pub keys: u32,
    /// The last text of a `Value::Text`.
    pub text: Option<&'a str>,
}

impl<'a> Row<'a> {
    /// Returns the row of a mapping without keys.
    pub fn new(mapping: &Mapping) -> Self {
        let mut row = Row { numbers: [f64::NAN; SLOTS], keys: 0, text: None };
        row.reset(mapping);
        row
    }

    /// Removes all keys.
    pub fn reset(&mut self, mapping: &Mapping) {
        self.numbers[..mapping.defaults.len()].copy_from_slice(mapping.defaults);
        self.keys = 0;
        self.text = None;
    }

    /// Adds a key; gives up if it is there.
    pub fn add(&mut self, key: usize) -> Option<()> {
        let bit = 1 << key;
        let is_new = self.keys & bit == 0;
        self.keys |= bit;
        is_new.then_some(())
    }

    /// Whether it has all keys that a kind must have, and none that it may not have.
    pub fn fits(&self, kind: &Kind) -> bool {
        self.has(kind.required) && self.keys & !kind.allowed == 0
    }

    /// Whether it has all of some keys.
    pub fn has(&self, keys: u32) -> bool {
        self.keys & keys == keys
    }
}

/// Counts the values of a file, and gives up when they are too many.
#[derive(Default)]
pub struct Counter(usize);

impl Counter {
    /// Counts some values.
    pub fn add(&mut self, values: usize) -> Option<()> {
        self.0 += values;
        (self.0 <= MAX_VALUES).then_some(())
    }
}

/// Returns the field of a key, and its number.
pub fn field_of(mapping: &'static Mapping, key: &[u8]) -> Option<(usize, &'static Field)> {
    mapping.fields.iter().enumerate().find(|(_, field)| field.key.as_bytes() == key)
}

/// Reads a mapping whose values are scalars and lists of numbers; `nested` reads values of other types.
pub fn read_row<'a, S: Source<'a>>(
    source: &mut S,
    mapping: &'static Mapping,
    row: &mut Row<'a>,
    counter: &mut Counter,
    mut nested: impl FnMut(&mut S, &'static Field, &mut Counter) -> Option<()>,
) -> Option<()> {
    let mut open = source.open_mapping()?;
    while let Some(key) = source.key(&mut open)? {
        let (index, field) = field_of(mapping, key)?;
        row.add(index)?;
        counter.add(1)?;
        match field.value {
            Value::Mapping(_) | Value::List(_) => nested(source, field, counter)?,
            _ => read_value(source, field, row, counter)?,
        }
    }
    Some(())
}

/// Reads the value of a key into its slots.
pub fn read_value<'a, S: Source<'a>>(
    source: &mut S,
    field: &Field,
    row: &mut Row<'a>,
    counter: &mut Counter,
) -> Option<()> {
    let slots = &mut row.numbers[field.slot..field.slot + field.value.slots()];
    match &field.value {
        Value::Boolean => slots[0] = f64::from(source.boolean()?),
        Value::Number(range) => slots[0] = number(source, *range)?,
        Value::NumberOr(word, range) => {
            slots[0] = if source.has_number()? {
                number(source, *range)?
            } else {
                (source.text()? == word.as_bytes()).then_some(f64::NAN)?
            }
        }
        Value::Numbers(_, range) => numbers(source, slots, *range, counter)?,
        Value::Direction(_, range) => {
            numbers(source, slots, *range, counter)?;
            if slots.iter().all(|&number| number == 0.0) {
                return None;
            }
        }
        Value::Angles(range) => {
            if source.has_list()? {
                numbers(source, slots, *range, counter)?;
            } else {
                slots.copy_from_slice(&[0.0, number(source, *range)?, 0.0]);
            }
        }
        Value::Color(range) => {
            if source.has_list()? {
                numbers(source, slots, *range, counter)?;
            } else {
                slots.copy_from_slice(&color(source.text()?)?);
            }
        }
        Value::Choice(words) => {
            let text = source.text()?;
            slots[0] = words.iter().position(|word| word.as_bytes() == text)? as f64;
        }
        Value::Text(shortest, longest) => {
            let text = str::from_utf8(source.text()?).ok()?;
            if !(*shortest..=*longest).contains(&text.chars().count()) {
                return None;
            }
            row.text = Some(text);
        }
        Value::Mapping(_) | Value::List(_) => return None,
    }
    Some(())
}

/// Reads one number of a key's list, which is no color: that may be a word.
pub fn read_component<'a>(
    source: &mut impl Source<'a>,
    field: &Field,
    row: &mut Row<'a>,
    at: usize,
) -> Option<()> {
    let (Value::Numbers(count, range) | Value::Direction(count, range)) = field.value else { return None };
    let slots = &mut row.numbers[field.slot..field.slot + count];
    *slots.get_mut(at)? = number(source, range)?;
    let is_direction = matches!(field.value, Value::Direction(..));
    (!is_direction || slots.iter().any(|&number| number != 0.0)).then_some(())
}

fn number<'a>(source: &mut impl Source<'a>, range: Range) -> Option<f64> {
    let number = source.number()?;
    // Larger integers have no exact float64.
    let is_wanted = !range.is_integer || (number.is_integer && number.value.abs() < (1u64 << 53) as f64);
    (is_wanted && range.contains(number.value)).then_some(number.value)
}

fn numbers<'a>(
    source: &mut impl Source<'a>,
    slots: &mut [f64],
    range: Range,
    counter: &mut Counter,
) -> Option<()> {
    counter.add(slots.len())?;
    let mut list = source.open_list()?;
    for slot in slots {
        if !source.item(&mut list)? {
            return None;
        }
        *slot = number(source, range)?;
    }
    (!source.item(&mut list)?).then_some(())
}

/// Returns the linear color of a CSS name in any case, or of `#rrggbb`.
pub fn color(text: &[u8]) -> Option<[f64; 3]> {
    let number = match text.strip_prefix(b"#") {
        Some(digits) if digits.len() == 6 && digits.iter().all(u8::is_ascii_hexdigit) => {
            u32::from_str_radix(str::from_utf8(digits).ok()?, 16).ok()?
        }
        Some(_) => return None,
        None => {
            let order = |&(name, _): &(&str, u32)| name.bytes().cmp(text.iter().map(u8::to_ascii_lowercase));
            COLORS[COLORS.binary_search_by(order).ok()?].1
        }
    };
    Some([16, 8, 0].map(|shift| LEVELS[(number >> shift & 0xff) as usize]))
}
