//! JSON as Python's `json.dumps` writes it.

use std::fmt::Write;

/// Writes a number as `repr` does: Rust has the same digits, but other exponents.
pub fn write_number(value: f64, json: &mut String) {
    let written = match value {
        // What is no number in JSON has these names in Python, where a scene with one is refused.
        _ if value.is_nan() => json.write_str("NaN"),
        _ if value.is_infinite() => json.write_str(if value > 0.0 { "Infinity" } else { "-Infinity" }),
        _ => {
            let start = json.len();
            let written = write!(json, "{value:?}");
            if let Some(place) = json[start..].find('e') {
                let exponent = json.split_off(start + place + 1);
                let (sign, digits) =
                    exponent.strip_prefix('-').map_or(('+', &exponent[..]), |digits| ('-', digits));
                written.and_then(|()| write!(json, "{sign}{digits:0>2}"))
            } else {
                written
            }
        }
    };
    written.expect("a String takes any text");
}

/// Writes numbers as a list.
pub fn write_numbers(numbers: &[f64], between: &str, json: &mut String) {
    json.push('[');
    for (place, &number) in numbers.iter().enumerate() {
        if place > 0 {
            json.push_str(between);
        }
        write_number(number, json);
    }
    json.push(']');
}

/// Writes a text in quotes and in ASCII.
pub fn write_ascii(text: &str, json: &mut String) {
    json.push('"');
    for character in text.chars() {
        match character {
            '"' | '\\' => json.extend(['\\', character]),
            '\n' => json.push_str("\\n"),
            '\r' => json.push_str("\\r"),
            '\t' => json.push_str("\\t"),
            '\u{8}' => json.push_str("\\b"),
            '\u{c}' => json.push_str("\\f"),
            ' '..='~' => json.push(character),
            _ => {
                for unit in character.encode_utf16(&mut [0; 2]) {
                    write!(json, "\\u{unit:04x}").expect("a String takes any text");
                }
            }
        }
    }
    json.push('"');
}

#[cfg(test)]
mod tests {
    use super::{write_ascii, write_number, write_numbers};

    fn number(value: f64) -> String {
        let mut json = String::new();
        write_number(value, &mut json);
        json
    }

    #[test]
    fn numbers_are_written_as_in_python() {
        for (value, text) in [
            (2.0, "2.0"),
            (-0.0, "-0.0"),
            (1e16, "1e+16"),
            (123_456_789_012_345.6, "123456789012345.6"),
            (0.0001, "0.0001"),
            (0.00001, "1e-05"),
            (-1.5e-7, "-1.5e-07"),
            (1e-300, "1e-300"),
            (2.5e200, "2.5e+200"),
            (f64::NEG_INFINITY, "-Infinity"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(number(value), text);
        }
    }

    #[test]
    fn numbers_read_back_equal_and_are_no_integers() {
        for value in [0.1, 2.0, -0.0, 1e16, 5e-324, f64::MAX, 1.0 / 3.0, 123_456_789_012_345_680.0] {
            let json = number(value);
            assert_eq!(json.parse::<f64>().unwrap().to_bits(), value.to_bits());
            assert!(json.contains(['.', 'e']), "{json}");
        }
    }

    #[test]
    fn numbers_stand_in_a_list() {
        let mut json = String::from(">");
        write_numbers(&[1.0, 1e-7], ", ", &mut json);
        assert_eq!(json, ">[1.0, 1e-07]");
    }

    /// By `json.dumps`.
    #[test]
    fn texts_are_ascii() {
        let mut json = String::new();
        write_ascii("a\"b\\c\n\r\t\u{8}\u{c}\u{1}\u{7f}/~ ö🙂", &mut json);
        assert_eq!(json, r#""a\"b\\c\n\r\t\b\f\u0001\u007f/~ \u00f6\ud83d\ude42""#);
    }
}
