//! Decimal numbers as float64.

/// The longest number; longer ones are valid, but not plainly.
const LONGEST: usize = 1_000;

/// Integers up to this one, and powers of ten up to 10^22, are exact in float64.
const EXACT: u64 = 1 << 53;
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19,
    1e20, 1e21, 1e22,
];

/// A finite number of a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Number {
    /// The nearest float64.
    pub value: f64,
    /// Whether it has neither a fraction nor an exponent.
    pub is_integer: bool,
}

/// The notations of numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Notation {
    /// RFC 8259, section 6.
    Json,
    /// The decimal numbers of YAML 1.2.2, section 10.3.2.
    Yaml,
}

/// Returns the number that a text starts with, and its length; None if there is none, or it is not finite.
pub fn number(text: &[u8], notation: Notation) -> Option<(Number, usize)> {
    let strict = notation == Notation::Json;
    let sign = match text.first()? {
        b'-' => 1,
        b'+' if !strict => 1,
        _ => 0,
    };
    let mut digits = Digits::default();
    let whole = digits.take(text, sign);
    let mut end = sign + whole;
    if strict && (whole == 0 || (whole > 1 && text[sign] == b'0')) {
        return None;
    }
    let mut is_integer = true;
    let mut fraction = 0;
    if text.get(end) == Some(&b'.') {
        fraction = digits.take(text, end + 1);
        if fraction == 0 && (strict || whole == 0) {
            return None;
        }
        is_integer = false;
        end += 1 + fraction;
    } else if whole == 0 {
        return None;
    }
    let mut exponent = 0;
    if let Some(b'e' | b'E') = text.get(end) {
        let length;
        (exponent, length) = exponent_of(&text[end + 1..])?;
        is_integer = false;
        end += 1 + length;
    }
    if end > LONGEST {
        return None;
    }
    let magnitude = match digits.exact(exponent - fraction as i64) {
        Some(value) => value,
        None => str::from_utf8(&text[sign..end]).ok()?.parse().ok()?,
    };
    // An integer has no negative zero.
    let is_negative = text[0] == b'-' && !(is_integer && magnitude == 0.0);
    let value = if is_negative { -magnitude } else { magnitude };
    magnitude.is_finite().then_some((Number { value, is_integer }, end))
}

/// The digits of a number, as an integer.
#[derive(Default)]
struct Digits {
    value: u64,
    count: usize,
}

impl Digits {
    /// Adds the digits of a text from an offset on, and returns their number.
    fn take(&mut self, text: &[u8], start: usize) -> usize {
        let mut end = start;
        while let Some(digit @ b'0'..=b'9') = text.get(end) {
            self.value = self.value.wrapping_mul(10).wrapping_add(u64::from(digit - b'0'));
            end += 1;
        }
        self.count += end - start;
        end - start
    }

    /// Returns digits * 10^exponent if that takes one exact step (W. Clinger, "How to read floating point numbers
    /// accurately", 1990).
    fn exact(&self, exponent: i64) -> Option<f64> {
        let power = POWERS.get(usize::try_from(exponent.unsigned_abs()).ok()?)?;
        if self.count > 19 || self.value > EXACT {
            return None;
        }
        let value = self.value as f64;
        Some(if exponent < 0 { value / power } else { value * power })
    }
}

/// Returns the exponent after the `e`, and the length of its text.
fn exponent_of(text: &[u8]) -> Option<(i64, usize)> {
    let sign = usize::from(matches!(text.first(), Some(b'+' | b'-')));
    let mut end = sign;
    let mut value: i64 = 0;
    while let Some(digit @ b'0'..=b'9') = text.get(end) {
        value = (value * 10 + i64::from(digit - b'0')).min(1 << 32);
        end += 1;
    }
    if end == sign {
        return None;
    }
    Some((if text[0] == b'-' { -value } else { value }, end))
}

#[cfg(test)]
mod tests;
