//! What a mapping of a scene file may hold: the types of the generated table.

/// A mapping, as keys that each fill some slots of a row of numbers.
pub struct Mapping {
    /// The keys that it may have.
    pub fields: &'static [Field],
    /// The keys that it must have, one bit each.
    pub required: u32,
    /// The slots of the keys that are left out.
    pub defaults: &'static [f64],
}

/// A key of a mapping.
pub struct Field {
    /// The key.
    pub key: &'static str,
    /// The type of its value.
    pub value: Value,
    /// The first of its slots.
    pub slot: usize,
}

/// One of several kinds that share a mapping.
pub struct Kind {
    /// Its name in scene files.
    pub name: &'static str,
    /// The keys that it may have, one bit each.
    pub allowed: u32,
    /// The keys that it must have, one bit each.
    pub required: u32,
    /// The slots of the numbers that the tracers take.
    pub parameters: &'static [usize],
    /// The slot of the number that a light's color is multiplied by.
    pub strength: Option<usize>,
}

/// The type of a value.
pub enum Value {
    /// True or false, as 1 or 0.
    Boolean,
    /// A number.
    Number(Range),
    /// A number, or a word that stands for NaN.
    NumberOr(&'static str, Range),
    /// A list of numbers, of this length.
    Numbers(usize, Range),
    /// The same, but not all 0.
    Direction(usize, Range),
    /// A list of three numbers, or a number, which is the second of three whose others are 0.
    Angles(Range),
    /// A list of three numbers, or the text of a color.
    Color(Range),
    /// One of several words, as its index.
    Choice(&'static [&'static str]),
    /// A text, from shortest to longest, in characters. It has no slot.
    Text(usize, usize),
    /// A mapping. It has no slot.
    Mapping(&'static Mapping),
    /// A list of mappings. It has no slot.
    List(&'static Mapping),
}

impl Value {
    /// Any finite number.
    pub const NUMBER: Range = Range {
        is_integer: false,
        above: f64::NEG_INFINITY,
        from: f64::NEG_INFINITY,
        to: f64::INFINITY,
        below: f64::INFINITY,
    };

    /// Any number without a fraction or exponent.
    pub const INTEGER: Range = Range { is_integer: true, ..Value::NUMBER };

    /// The number of slots.
    pub fn slots(&self) -> usize {
        match self {
            Value::Numbers(count, _) | Value::Direction(count, _) => *count,
            Value::Angles(_) | Value::Color(_) => 3,
            Value::Text(..) | Value::Mapping(_) | Value::List(_) => 0,
            Value::Boolean | Value::Number(_) | Value::NumberOr(..) | Value::Choice(_) => 1,
        }
    }
}

/// The bounds of a number.
#[derive(Clone, Copy)]
pub struct Range {
    /// Whether only integers are allowed.
    pub is_integer: bool,
    above: f64,
    from: f64,
    to: f64,
    below: f64,
}

impl Range {
    /// Greater than a number.
    pub const fn above(self, above: f64) -> Range {
        Range { above, ..self }
    }

    /// At least a number.
    pub const fn from(self, from: f64) -> Range {
        Range { from, ..self }
    }

    /// At most a number.
    pub const fn to(self, to: f64) -> Range {
        Range { to, ..self }
    }

    /// Less than a number.
    pub const fn below(self, below: f64) -> Range {
        Range { below, ..self }
    }

    /// Whether a number is within the bounds.
    pub fn contains(&self, value: f64) -> bool {
        value > self.above && value >= self.from && value <= self.to && value < self.below
    }
}
