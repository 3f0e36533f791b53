//! The keys of objects as scenes are written: what `rtcli.scene.write.as_data` makes of valid ones.

use crate::json::{write_number, write_numbers};
use crate::row::color;
use crate::source::Source;
use crate::source::json::Json;
use crate::table::{COLORS, LEVELS, WRITTEN};

/// A color, linear RGB.
type Color = [f64; 3];

/// Writes the keys of a valid object but its name, each a text and its value in JSON, in the order of the reference: those
/// with their default values are left out, and numbers are floats. The color of the object is linear. None for values
/// that no valid object has.
pub fn write_object(kind: &str, keys: &[(&str, String)], paint: &Color, json: &mut String) -> Option<()> {
    let value = |key: &str, value: &str| match key {
        "color" => Some(numbers(paint)),
        _ if written(key).is_some() => part(key, value),
        _ => scalar(&mut Json::new(value)),
    };
    let keys = keys.iter().map(|(key, value)| (*key, value.as_str()));
    write_keys(written(kind)?, keys.collect(), value, json)
}

/// The keys of a kind of object, or of a part of objects, and their default values as they would be written.
fn written(name: &str) -> Option<&'static [(&'static str, &'static str)]> {
    WRITTEN.iter().find(|(known, _)| *known == name).map(|(_, keys)| *keys)
}

/// Writes those of some known keys that are there with another value than by default, without braces.
fn write_keys<V: Copy>(
    known: &[(&str, &str)],
    keys: Vec<(&str, V)>,
    value_of: impl Fn(&str, V) -> Option<String>,
    json: &mut String,
) -> Option<()> {
    let mut comma = "";
    for (name, default) in known {
        let Some((_, value)) = keys.iter().find(|(key, _)| key == name) else { continue };
        let text = value_of(name, *value)?;
        if text != *default {
            json.extend([comma, "\"", name, "\":", &text]);
            comma = ",";
        }
    }
    Some(())
}

/// Returns a part of an object, a mapping of numbers and a color.
fn part(name: &str, json: &str) -> Option<String> {
    let mut source = Json::new(json);
    let mut open = source.open_mapping()?;
    let mut keys = Vec::new();
    while let Some(key) = source.key(&mut open)? {
        keys.push((
            str::from_utf8(key).ok()?,
            if key == b"color" { paint(&mut source)? } else { scalar(&mut source)? },
        ));
    }
    let mut written_part = String::from("{");
    let keys = keys.iter().map(|(key, value)| (*key, value.as_str())).collect();
    write_keys(written(name)?, keys, |_, value| Some(value.into()), &mut written_part)?;
    written_part.push('}');
    Some(written_part)
}

/// Returns a number, a list of numbers, or a word.
fn scalar<'a>(source: &mut Json<'a>) -> Option<String> {
    let mut text = String::new();
    if source.has_list()? {
        text = numbers(&list(source)?);
    } else if source.has_number()? {
        write_number(source.number()?.value, &mut text);
    } else {
        text.extend(["\"", str::from_utf8(source.text()?).ok()?, "\""]);
    }
    Some(text)
}

/// Returns a color as its CSS name or `#rrggbb`, or as a list if it has neither.
fn paint(source: &mut Json<'_>) -> Option<String> {
    let linear = if source.has_list()? { list(source)?.try_into().ok()? } else { color(source.text()?)? };
    let mut number = 0;
    for component in linear {
        let level = LEVELS.binary_search_by(|level| level.total_cmp(&component));
        let Ok(level) = level else { return Some(numbers(&linear)) };
        number = number << 8 | level as u32;
    }
    // Of several names, the first.
    let name = COLORS.iter().find(|(_, known)| *known == number).map(|(name, _)| (*name).to_owned());
    Some(format!("\"{}\"", name.unwrap_or_else(|| format!("#{number:06x}"))))
}

fn list(source: &mut Json<'_>) -> Option<Vec<f64>> {
    let mut open = source.open_list()?;
    let mut numbers = Vec::new();
    while source.item(&mut open)? {
        numbers.push(source.number()?.value);
    }
    Some(numbers)
}

fn numbers(numbers: &[f64]) -> String {
    let mut text = String::new();
    write_numbers(numbers, ",", &mut text);
    text
}

#[cfg(test)]
mod tests {
    use super::write_object;

    fn written(kind: &str, keys: &[(&str, &str)]) -> Option<String> {
        let keys: Vec<_> = keys.iter().map(|(key, value)| (*key, (*value).to_owned())).collect();
        let mut json = String::new();
        write_object(kind, &keys, &[0.5, 0.0, 1.0], &mut json)?;
        Some(json)
    }

    #[test]
    fn keys_have_the_order_of_the_reference_and_numbers_are_floats() {
        let keys = [("color", "\"red\""), ("size", "[1, 2e-7, 3]"), ("name", "\"a\""), ("type", "\"box\"")];
        let expected = r#""type":"box","size":[1.0,2e-07,3.0],"color":[0.5,0.0,1.0]"#;
        assert_eq!(written("box", &keys).unwrap(), expected);
    }

    #[test]
    fn defaults_are_left_out_but_not_what_only_equals_them() {
        for (value, text) in [
            ("0", ""),
            ("0.0", ""),
            ("-0", ""),
            ("-0.0", r#""rotation":-0.0"#),
            ("[0, 0, 0]", r#""rotation":[0.0,0.0,0.0]"#),
            ("30", r#""rotation":30.0"#),
        ] {
            assert_eq!(written("box", &[("rotation", value)]).unwrap(), text);
        }
        assert_eq!(written("cone", &[("axis", "[0, 1, 0]"), ("top_radius", "0")]).unwrap(), "");
        assert_eq!(written("cone", &[("axis", "[0, 1, -0.0]")]).unwrap(), r#""axis":[0.0,1.0,-0.0]"#);
    }

    #[test]
    fn parts_are_mappings_with_texts_of_colors() {
        for (value, text) in [
            (r#"{"radius":0,"color":"white","intensity":5}"#, r#""light":{"intensity":5.0}"#),
            (r#"{"intensity":5,"color":[1,0.5,0]}"#, r#""light":{"intensity":5.0,"color":[1.0,0.5,0.0]}"#),
            (r##"{"intensity":5,"color":"#00FFff"}"##, r#""light":{"intensity":5.0,"color":"aqua"}"#),
            (r#"{"intensity":5,"color":[0,-0.0,0]}"#, r#""light":{"intensity":5.0,"color":[0.0,-0.0,0.0]}"#),
        ] {
            assert_eq!(written("sphere", &[("light", value)]).unwrap(), text);
        }
        let checker = written("plane", &[("checker", r##"{"color":"#010203","size":1}"##)]);
        assert_eq!(checker.unwrap(), r##""checker":{"size":1.0,"color":"#010203"}"##);
    }

    #[test]
    fn what_no_object_has_is_not_written() {
        assert_eq!(written("disk", &[]), None);
        assert_eq!(written("sphere", &[("radius", "{}")]), None);
        assert_eq!(written("sphere", &[("light", "5")]), None);
    }
}
