//! Lists, texts and mappings as JSON.

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
    let mut json = String::from("{");
    for (number, (key, value)) in entries.iter().enumerate() {
        if number > 0 {
            json.push(',');
        }
        write_text(key, &mut json);
        json.push(':');
        json.push_str(value);
    }
    json.push('}');
    json
}

#[cfg(test)]
mod tests {
    use super::write_text;

    #[test]
    fn texts_are_escaped() {
        let mut json = String::new();
        write_text("a\"b\\c\nö", &mut json);
        assert_eq!(json, r#""a\"b\\c\u000aö""#);
    }
}
