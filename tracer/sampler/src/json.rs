//! Numbers and texts as JSON.

use std::fmt::Write;

/// Writes a number with the fewest digits that read back equal, and with a point or an exponent.
pub fn write_number(number: f64, json: &mut String) {
    let written = match number {
        _ if number.is_finite() => write!(json, "{number:?}"),
        // What is no number in JSON has these names in Python, where a scene with one is refused.
        _ if number.is_nan() => json.write_str("NaN"),
        _ => json.write_str(if number > 0.0 { "Infinity" } else { "-Infinity" }),
    };
    written.expect("a String takes any text");
}

/// Writes numbers as a list.
pub fn write_numbers(numbers: &[f64], json: &mut String) {
    write_list(numbers, json, |&number, json| {
        write_number(number, json);
        Some(())
    });
}

/// Writes a list of items.
pub fn write_list<T>(
    items: &[T],
    json: &mut String,
    mut write: impl FnMut(&T, &mut String) -> Option<()>,
) -> Option<()> {
    json.push('[');
    for (number, item) in items.iter().enumerate() {
        if number > 0 {
            json.push(',');
        }
        write(item, json)?;
    }
    json.push(']');
    Some(())
}

/// Writes a text in quotes.
pub fn write_text(text: &str, json: &mut String) {
    json.push('"');
    for character in text.chars() {
        match character {
            '"' | '\\' => json.extend(['\\', character]),
            '\0'..' ' => json.push_str(&format!("\\u{:04x}", u32::from(character))),
            _ => json.push(character),
        }
    }
    json.push('"');
}

/// Returns a mapping of texts that are JSON already.
pub fn mapping(entries: &[(&str, String)]) -> String {
    let mut json = String::new();
    write_mapping(entries, &mut json);
    json
}

/// Writes a mapping of texts that are JSON already.
pub fn write_mapping(entries: &[(&str, String)], json: &mut String) {
    json.push('{');
    for (number, (key, value)) in entries.iter().enumerate() {
        if number > 0 {
            json.push(',');
        }
        write_text(key, json);
        json.push(':');
        json.push_str(value);
    }
    json.push('}');
}

#[cfg(test)]
mod tests {
    use super::{write_number, write_text};

    fn number(value: f64) -> String {
        let mut json = String::new();
        write_number(value, &mut json);
        json
    }

    #[test]
    fn numbers_read_back_equal_and_are_no_integers() {
        for value in [0.1, 2.0, -0.0, 1e16, 5e-324, f64::MAX, 1.0 / 3.0, 123_456_789_012_345_680.0] {
            let json = number(value);
            assert_eq!(json.parse::<f64>().unwrap().to_bits(), value.to_bits());
            assert!(json.contains(['.', 'e']), "{json}");
        }
        assert_eq!((number(2.0), number(f64::NEG_INFINITY)), ("2.0".into(), "-Infinity".into()));
    }

    #[test]
    fn texts_are_escaped() {
        let mut json = String::new();
        write_text("a\"b\\c\nö", &mut json);
        assert_eq!(json, r#""a\"b\\c\u000aö""#);
    }
}
